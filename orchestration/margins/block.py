"""The linear model of one block at an instant of a flight: inputs and outputs by name, observed or balanced states; and
that of the closed loop, from what is added to a signal to outputs that are its states.

The block takes what it took in the flight, from a tape, so the loop is open; the differences that pulses at each input
make are its answers, sample by sample. Of two pulses, a and -a/2, the answers agree where the block is linear. An
output that is not linear here is left out, with the reason. Where the FMU gives directional derivatives, D is theirs.

Longer than 250 lines: the flights that answer pulses, and the two fits to them, share their shapes and sizes.
Tests: tests/orchestration/margins/test_block.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import BlockError, InputError, Place, Problem, hint
from ..fmu.head import read_head
from ..fmu.model import Element, Floats, unit_of
from ..instances.block import Block
from ..instances.slave import Slave
from ..session.session import Session
from .floquet import Coordinates, Keeper, coordinates
from .inject import Altered, Rig
from .linear import SEEN, Linear, balanced, seen
from .measure import AMPLITUDES, GOOD, LIMIT
from .site import site

SAMPLES = 60
"""Samples of an answer to a pulse."""
_APPEARS = 1e-4
"""Direction of the states that counts beside the largest."""
_NONE = 1e-8
"""Answer beside the value of an output, to an input as large as it usually is, that counts as none."""


@dataclass(frozen=True)
class BlockModel:
    """The model of a block or a loop, and notes: what is left out of it and why, and where D comes from."""

    model: Linear
    notes: list[str]

    @property
    def refused(self) -> str:
        """Reason for which there is no model; empty where there is one."""
        if not self.model.outputs:
            return "no output is linear here"
        return self.model.verdict if self.model.error > LIMIT else ""


def linearized(
    session: Session, block: str, first: int, states: Sequence[str] = (), window: float | None = None
) -> BlockModel:
    """Returns the model of a block from a base step on, from sample to sample.

    `window` is how long an answer is looked at, s; SAMPLES samples by default. `states` are outputs, `block.port`,
    that are its state; a rotation matrix among them counts as a rotation vector. Raises InputError, and BlockError
    where a block fails in flight.
    """
    plan, place = session.opened.plan, Place(f"--model {block}")
    if block not in plan.models:
        raise InputError(Problem(f"there is no block {block!r}{hint(block, plan.models)}", place=place))
    named, model = coordinates(plan, states), plan.models[block]
    if other := next((name for name, _ in named.variables if name != block), None):
        raise InputError(Problem(expected=f"states of {block}", found=f"one of {other}", place=place))
    linked = {t.element.variable for link in plan.circuit.wiring.links for t in link.target if t.block == block}
    ports = [f"{block}.{v.name}" for v in model.of("input") if v.name in linked and v.type == "real"]
    shown = Coordinates(tuple((block, v) for v in model.of("output") if v.type == "real"))
    if not ports or not shown.variables:
        raise InputError(Problem(f"{block} has no connected real input, or no real output", place=place))
    rig = Rig(session, site(plan, ports, "--model"), max(first, 1))  # before the first step nothing is taken
    flights = _Flights(rig, shown, named, SAMPLES if window is None else max(round(window / rig.period), 8))
    return _modelled(flights, place)


def closed(rig: Rig, states: Coordinates, samples: int) -> BlockModel:
    """Returns the model of the closed loop from a pulse at the rig's site to these states, from sample to sample.

    Raises InputError for a state that is none, and BlockError where a block fails in flight.
    """
    return _modelled(_Flights(rig, states, states, samples, opened=False), Place("--state"))


def _modelled(flights: _Flights, place: Place) -> BlockModel:
    rig, named = flights.rig, flights.named
    pulse, kept, notes = flights.judged()
    nodes, models = [flights.shown.nodes[i] for i in kept], rig.session.opened.plan.models
    outputs = [f"{n.block}.{models[n.block].variables[n.element.variable].label(n.element.position)}" for n in nodes]
    slopes = flights.slopes([node.element for node in nodes])
    if slopes is not None:
        notes.append(f"D: directional derivatives of the FMU; differences are within {_apart(pulse[0], slopes):.1g}")
        pulse[0] = slopes
    if not named.variables:
        return BlockModel(Linear(rig.site.labels, outputs, *_balanced(flights, pulse)), notes)
    fitted, apart, moved = _observed(flights, pulse, place)
    notes += [
        f"left out: {outputs[i]} is not seen from these states ({100 * apart[i]:.2g} %)"
        for i in range(len(apart))
        if apart[i] > LIMIT
    ]
    outputs = [label for label, error in zip(outputs, apart, strict=True) if error <= LIMIT]
    return BlockModel(Linear(rig.site.labels, outputs, *fitted, tuple(named.labels), moved), notes)


class _Flights:
    """Answers of a block's outputs and named states to pulses at its inputs, (samples, outputs, inputs)."""

    def __init__(self, rig: Rig, shown: Coordinates, named: Coordinates, samples: int, opened: bool = True) -> None:
        self.rig, self.shown, self.named, self.count = rig, shown, named, len(shown.nodes)
        still = np.zeros((samples, len(rig.site.channels)))
        self._altered = Altered(tape=rig.fly(still) if opened else None)
        self._still, self._base = still, self._flown(still)
        columns = [self._column(j) for j in range(still.shape[1])]
        whole, unlike = (np.stack(part, axis=-1) for part in zip(*columns, strict=True))
        self.pulse, self.states = whole[:, : self.count], whole[:, self.count :]
        self._unlike = unlike[: self.count]
        usual: list[float] = []
        first = self.count
        for _, v in named.variables:
            largest = float(np.abs(self._base[:, first : first + v.size]).max())
            usual, first = usual + [largest] * (3 if v.shape == (3, 3) else v.size), first + v.size
        apart, size = (unlike[self.count :] * self.rig.scales).max(axis=1), np.abs(self.states * self.rig.scales)
        size = size.max(axis=(0, 2))
        self.still = np.maximum(size, apart) <= _NONE * np.maximum(usual, 1e-300)
        """The named states that no input moves: what is seen of them is rounding."""
        moved = ~self.still
        self.error = float((apart[moved] / np.maximum(size[moved], 1e-300)).max(initial=0.0))
        """Largest difference between answers to pulses of two sizes, beside the answer."""

    def _flown(self, injected: Floats) -> Floats:
        rig, nodes = self.rig, [*self.shown.nodes, *self.named.nodes]
        keeper = Keeper(rig.first + rig.site.hold * np.arange(len(injected)), rig.session.opened.plan.clock.step, nodes)
        rig.fly(injected, self._altered, [keeper], nodes)
        return keeper.rows

    def _column(self, j: int) -> tuple[Floats, Floats]:
        """Returns the answers to a pulse of 1 at an input, and how far two sizes of pulse differ, the best of each."""
        base, scale, n = self._base, self.rig.scales[j], self.count
        best, unlike = np.zeros(0), np.full(n + len(self.named.labels), np.inf)
        failure: BlockError | None = None
        for share in AMPLITUDES:
            found = []
            for part in (share * scale, -0.5 * share * scale):
                injected = self._still.copy()
                injected[0, j] = part
                try:
                    moved = self._flown(injected)
                except BlockError as error:  # a value that the FMU refuses
                    failure = error
                    break
                states = self.named.difference(base[:, n:], moved[:, n:]) if self.named.variables else moved[:, n:]
                found.append(np.concatenate([moved[:, :n] - base[:, :n], states], axis=1) / part)
            if len(found) < 2:
                continue
            mean, apart = 0.5 * (found[0] + found[1]), np.abs(found[0] - found[1]).max(axis=0)
            best = mean if not best.size else np.where(apart < unlike, mean, best)
            better, unlike = apart < 0.5 * unlike, np.minimum(apart, unlike)
            if not (better & (unlike > GOOD * np.abs(best).max(axis=0))).any():
                break
        if not best.size:
            assert failure is not None
            raise failure
        return best, unlike

    def judged(self) -> tuple[Floats, list[int], list[str]]:
        """Returns the answers of the outputs that are linear here, which these are, and why others are left out."""
        pulse, scales, base = self.pulse.copy(), self.rig.scales, self._usual()
        effects = np.abs(pulse).max(axis=0) * scales
        sizes, apart = effects.max(axis=1), (self._unlike * scales).max(axis=1)
        still = np.maximum(sizes, apart) <= _NONE * base
        pulse[:, still] = 0.0
        errors = np.where(still, 0.0, apart / np.maximum(np.maximum(sizes, apart), 1e-300))
        kept = [int(i) for i in np.flatnonzero(errors <= LIMIT)]
        self.error = max(self.error, float(errors[kept].max(initial=0.0)))
        notes = [
            f"left out: {node.block}.{node.element.variable}[{node.element.position + 1}] is not linear here: pulses "
            f"of two sizes differ by {100 * errors[i]:.2g} % (a limit, a switch, a quantized signal or a norm at zero)"
            for i, node in enumerate(self.shown.nodes)
            if errors[i] > LIMIT
        ]
        if still.any():
            notes.append(f"{int(still.sum())} of {self.count} outputs are not moved by any input")
        return pulse[:, kept], kept, notes

    def _usual(self) -> Floats:
        """Returns the usual size of each output: the largest value of an input or output of its unit."""
        of = {(block, v.name): str(unit_of(v)) for block, v in self.shown.variables}
        units = [of[node.block, node.element.variable] for node in self.shown.nodes]
        largest = np.abs(self._base[:, : self.count]).max(axis=0)
        known = [*zip(units, largest, strict=True)]
        known += [(c.unit, scale) for c, scale in zip(self.rig.site.channels, self.rig.scales, strict=True)]
        return np.array([max(size for unit, size in known if unit == own) for own in units])

    def slopes(self, outputs: Sequence[Element]) -> Floats | None:
        """Returns the directional derivatives of outputs by the inputs, where the FMU gives them in this process."""
        rig, found = self.rig, list[Floats]()
        if self._altered.tape is None:
            return None
        receivers = [channel.receivers[0] for channel in rig.site.channels]
        path = rig.session.opened.fmus[receivers[0].target.block].path
        if path.suffix == ".py" or not read_head(path).slopes:
            return None

        def ask(block: Block) -> None:
            if isinstance(block, Slave):
                found.append(block.slopes(outputs, [r.target.element for r in receivers]))

        rig.fly(self._still[:1], Altered(tape=self._altered.tape), after=ask)
        return found[0] if found else None


_Fit = tuple[Floats, Floats, Floats, Floats, float, Floats, float, str]
"""A, B, C, D, step, sizes, error, verdict"""


def _balanced(flights: _Flights, pulse: Floats) -> _Fit:
    """Fits balanced states to the answers, with inputs and outputs by their sizes."""
    scales = flights.rig.scales
    size = np.maximum(np.abs(pulse * scales).max(axis=(0, 2), initial=0.0), 1e-300)[:, None]
    A, B, C, sizes = balanced(pulse * scales / size, max(SEEN, 0.1 * flights.error))
    B, C = B / scales, C * size
    error = flights.error + _apart(_answers(A, B, C, pulse) * scales / size, pulse * scales / size)
    verdict = f"{seen(len(A), sizes)}; the model's answers are within {100 * error:.2g} % of the measured ones"
    return A, B, C, pulse[0], flights.rig.period, sizes, error, verdict


def _observed(flights: _Flights, pulse: Floats, place: Place) -> tuple[_Fit, Floats, int]:
    """Fits the named states, which must not follow the inputs at once, and returns what of each output is left; the
    outputs of which it is too much are left out. The last is how many directions of the states are moved."""
    scales = flights.rig.scales
    z, y = flights.states * scales, pulse * scales  # (samples, states, inputs)
    z[:, flights.still] = 0.0
    sizes = np.maximum(np.abs(z).max(axis=(0, 2)), 1e-300)
    if late := [
        name for name, at, of in zip(flights.named.labels, z[0], sizes, strict=True) if abs(at).max() > 0.9 * of
    ]:
        raise InputError(Problem(f"{late[0]} follows the inputs at once: it is no state", place=place))
    z = z / sizes[:, None]
    size = np.maximum(np.abs(y).max(axis=(0, 2), initial=0.0), 1e-300)
    y = y / size[:, None]
    n, m = z.shape[1:]
    rows = z.transpose(0, 2, 1)  # (samples, inputs, states)
    given = np.zeros((len(z), m, m))
    given[0] = np.eye(m)
    known = np.concatenate([rows, given], axis=2)
    step, _, rank, _ = np.linalg.lstsq(known[:-1].reshape(-1, n + m), rows[1:].reshape(-1, n), rcond=_APPEARS)
    show = np.linalg.lstsq(known.reshape(-1, n + m), y.transpose(0, 2, 1).reshape(-1, y.shape[1]), rcond=_APPEARS)[0]
    A, B = step[:n].T * sizes[:, None] / sizes, step[n:].T * sizes[:, None] / scales
    C, D = show[:n].T * size[:, None] / sizes, show[n:].T * size[:, None] / scales
    told = rows.copy()
    for k, now in enumerate(given[:-1]):  # the model's own states, so that errors of slow ones add up
        told[k + 1] = np.concatenate([told[k], now], axis=1) @ step
    rest = float(np.nan_to_num(np.abs(told - rows), nan=np.inf).max())
    apart = np.abs(known @ show - y.transpose(0, 2, 1)).max(axis=(0, 1))
    kept = apart <= LIMIT
    error = flights.error + max(rest, float(apart[kept].max(initial=0.0)))
    moved = min(int(rank) - m, n)
    verdict = (
        f"the inputs move {moved} of {n} directions of the named states; the model is within "
        f"{100 * error:.2g} % of the measured answers"
    )
    return (A, B, C[kept], D[kept], flights.rig.period, np.empty(0), error, verdict), apart, moved


def _answers(A: Floats, B: Floats, C: Floats, pulse: Floats) -> Floats:
    """Returns the answers of a model with this D to a pulse, (samples, outputs, inputs)."""
    found, x = pulse.copy(), B
    for k in range(1, len(pulse)):
        found[k], x = C @ x, A @ x
    return found


def _apart(a: Floats, b: Floats) -> float:
    """Returns the largest difference beside the largest of b."""
    return float(np.abs(a - b).max(initial=0.0) / max(np.abs(b).max(initial=0.0), 1e-300))
