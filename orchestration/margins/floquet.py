"""Floquet multipliers of a loop along a periodic motion, in coordinates of what is observed of its state.

Flights with small random pulses at the rig's site are compared with each other. From one instant to the next the
observed difference x moves by x+ = F x + G d, d the pulses of that segment; F and G are what fits all flights best. The
multipliers are the eigenvalues of the product of all F, by the QR decomposition of each factor, since the product
itself may vanish beneath the smallest number. Where the observed state is not the whole one, the fit leaves a rest.

A difference of rotations (a 3 by 3 matrix) is the rotation vector of R_a^T R_b; of all else the difference itself.

Tests: tests/orchestration/margins/test_floquet.py, tests/design/test_floquet.py.
Longer than 250 lines: the flights, the fit and the product of its factors are one computation.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, Place, Problem, hint
from ..fmu.model import Floats, NameUnknown, Variable
from ..scenario.references import Reference
from ..session.plan import Plan
from ..system.wiring import Node
from .analysis import Complex
from .inject import Altered, Rig
from .search import Slope, Starts

SEGMENT = 200
"""Samples from one instant to the next, about."""
MORE = 4
"""Flights beyond those that the fit needs."""
PULSE = 1e-3
"""Size of the pulses beside the largest value of their port so far."""
FRESH = 20
"""Segments after which all flights begin anew with pulses: by then a disturbance has decayed, or grown."""
LEAD = 3
"""Segments with pulses before the first that counts, so that the motion has all directions."""
CYCLES, FACTORS = 30, 6000
"""Times that the period is gone through until the subspaces have settled, and factors, at least."""
SEEN, DEEPEST = 0.01, 4
"""Rest with which no further instant is added to the coordinates, and instants at most."""
UNSEEN = 0.1
"""Rest above which the multipliers are no result."""
SPREAD = 0.1
"""Difference of logarithms, with one more instant, above which the multipliers are no result."""
_APPEARS = 1e-5
"""Direction of the coordinates that counts beside the largest, where they hold several instants."""
_APART = 1e-6
"""Turn of a subspace over a period beneath which it has settled."""


@dataclass(frozen=True)
class Coordinates:
    """The ports that are observed, and their differences between flights."""

    variables: tuple[tuple[str, Variable], ...]
    """Each with its block."""

    @property
    def nodes(self) -> list[Node]:
        """All elements, in order."""
        return [Node(block, element) for block, variable in self.variables for element in variable.elements]

    @property
    def labels(self) -> list[str]:
        """The names of the coordinates."""
        names = []
        for block, v in self.variables:
            if v.shape == (3, 3):
                names += [f"{block}.{v.name} about {axis}" for axis in "xyz"]
            else:
                names += [f"{block}.{v.label(position)}" for position in range(v.size)]
        return names

    def difference(self, a: Floats, b: Floats) -> Floats:
        """Returns b - a, (..., coordinates), of observed values (..., elements)."""
        parts, first = [], 0
        for _, variable in self.variables:
            last = first + variable.size
            one, other = a[..., first:last], b[..., first:last]
            if variable.shape == (3, 3):
                shape = (*one.shape[:-1], 3, 3)
                turn = np.swapaxes(one.reshape(shape), -1, -2) @ other.reshape(shape)
                odd = 0.5 * (turn - np.swapaxes(turn, -1, -2))
                vector = np.stack([odd[..., 2, 1], odd[..., 0, 2], odd[..., 1, 0]], axis=-1)
                sine = np.linalg.norm(vector, axis=-1, keepdims=True)
                parts.append(
                    np.where(sine > 1e-12, np.arcsin(np.minimum(sine, 1)) / np.maximum(sine, 1e-300), 1.0) * vector
                )
            else:
                parts.append(other - one)
            first = last
        return np.asarray(np.concatenate(parts, axis=-1))


@dataclass(frozen=True)
class Orbit:
    """The transitions of a loop over a period, and what follows from them."""

    labels: list[str]
    step: float
    """Seconds of a segment."""
    transitions: Floats
    """(segments, coordinates, coordinates)"""
    rest: float
    """What of the motion in further flights the fit leaves, beside its size: zero where the state is seen whole."""
    flights: int
    spread: float = 0.0
    """By how much the logarithm of the largest multiplier differs with one more instant in the coordinates."""

    @property
    def known(self) -> bool:
        """Returns whether the multipliers are a result."""
        return self.rest <= UNSEEN and self.spread <= SPREAD

    @property
    def period(self) -> float:
        """Seconds."""
        return self.step * len(self.transitions)

    @property
    def logs(self) -> Complex:
        """Logarithms of the multipliers, the largest first, as many as coordinates; the imaginary part is known up to
        turns."""
        return logs(self.transitions)[: len(self.labels)]

    def lines(self) -> list[str]:
        """Returns what is told of it: a line for each multiplier, and the verdict."""
        said = []
        for log in self.logs:
            size, rate = log.real / math.log(10), log.real / self.period
            after = "grows" if rate > 0.0 else "decays"
            said.append(
                f"|multiplier| 10^{size:.4g}: {after} at {abs(rate):.4g} 1/s, e-fold in "
                f"{1 / max(abs(rate), 1e-300):.4g} s"
            )
        return [*said, self.verdict]

    @property
    def decay(self) -> float:
        """The largest multiplier: the factor by which a disturbance is left after a period, at worst."""
        return math.exp(min(self.logs[0].real, 700.0))

    @property
    def verdict(self) -> str:
        """Observability of the state, in words."""
        if self.rest <= UNSEEN and not self.known:
            return (
                f"the largest multiplier changes by a factor of {math.exp(min(self.spread, 700.0)):.3g} with one more "
                "instant in the coordinates: hidden states are slow, and these multipliers are no result; "
                "remedy: --periods"
            )
        if self.rest < 1e-3:
            return "the observed coordinates are the whole state that matters"
        if self.rest <= UNSEEN:
            return f"{100 * self.rest:.2g} % of the motion comes from states that are not observed"
        return f"{100 * self.rest:.2g} % of the motion is not explained: these multipliers are no result"


def coordinates(plan: Plan, names: Sequence[str], option: str = "--state") -> Coordinates:
    """Returns the coordinates that these ports stand for. Raises InputError."""
    found = []
    for text in names:
        try:
            reference = Reference(text)
            if reference.block not in plan.models:
                raise NameUnknown(f"there is no block {reference.block!r}{hint(reference.block, plan.models)}")
            variable, _ = plan.models[reference.block].find(reference.block, reference.variable, (), ("output",))
        except (NameUnknown, InputError) as error:
            raise InputError(Problem(str(error), place=Place(f"{option} {text}"))) from None
        if variable.type != "real" or variable.causality != "output" or reference.indices:
            message = f"{text} is {variable.kind}, {variable.causality}; expected a whole real output"
            raise InputError(Problem(message, place=Place(f"{option} {text}")))
        found.append((reference.block, variable))
    return Coordinates(tuple(found))


def orbit(
    rig: Rig,
    seen: Coordinates,
    samples: int,
    size: Floats,
    segment: int = SEGMENT,
    starts: Starts = None,
    more: int = MORE,
    altered: Altered = Altered(),  # noqa: B008  (it is frozen)
    depth: int = 1,
) -> Orbit:
    """Returns the transitions over so many samples, in segments of equal length.

    They begin LEAD + `depth` - 1 segments after the rig's instant. `size` is that of the pulses of each channel, in
    the unit of its port. With `depth` above 1 the coordinates are those of so many instants one after the other, which
    shows hidden states, and the pulses are in the lead only. Raises BlockError where a block fails."""
    segments = max(round(samples / segment), 1)
    length = round(samples / segments)
    at = rig if starts is None else Rig(rig.session, rig.site, rig.first, starts)
    parts: list[_Part] = []
    flights = 0
    for begun in range(0, segments, FRESH):
        before = at.flights if begun == 0 and at is rig else 0
        parts.append(_part(at, seen, min(FRESH, segments - begun), length, size, more, altered, depth))
        flights += at.flights - before
        if begun + FRESH < segments:
            at = at.further(FRESH * length, altered)
    unexplained, whole = (sum(getattr(part, name) for part in parts) for name in ("unexplained", "whole"))
    rest = float(np.sqrt((unexplained / np.maximum(whole, 1e-300)).max()))
    return Orbit(seen.labels, length * rig.period, np.concatenate([p.transitions for p in parts]), rest, flights)


@dataclass(frozen=True)
class _Part:
    """Transitions of segments between which the flights go on, and squares of motion beside what is not explained."""

    transitions: Floats
    unexplained: Floats
    whole: Floats


def _part(
    rig: Rig, seen: Coordinates, segments: int, length: int, size: Floats, more: int, altered: Altered, depth: int
) -> _Part:
    channels, n, lead, free = len(rig.site.channels), len(seen.labels), LEAD + depth - 1, depth > 1
    pairs = depth * n + (0 if free else channels) + more
    rng = np.random.default_rng(1)
    shape = pairs, segments + lead, channels
    pulses = rng.uniform(0.3, 1.0, shape) * rng.choice([-1.0, 1.0], shape)
    if free:
        pulses[:, LEAD:] = 0.0

    def flown(given: Floats) -> Floats:
        injected = np.zeros((shape[1] * length + 1, channels))
        injected[:-1:length] = given * size
        return observed(rig, seen, injected, length, altered)

    still = flown(np.zeros(shape[1:])) if free else np.empty(0)
    moved = [
        seen.difference(still, flown(one)) if free else 0.5 * seen.difference(flown(-one), flown(one)) for one in pulses
    ]
    y = np.array(moved)  # (pairs, instants, coordinates)
    last = y.shape[1]
    x = np.concatenate([y[:, lead - back : last - back] for back in range(depth)], axis=2)
    pulses = pulses[:, lead:, : 0 if free else channels]
    transitions, unexplained, whole = np.empty((segments, depth * n, depth * n)), np.zeros(n), np.zeros(n)
    fitted, tested = slice(pairs - more // 2), slice(pairs - more // 2, None)
    for k in range(segments):
        known = np.concatenate([x[:, k], pulses[:, k]], axis=1)
        scale = np.maximum(np.abs(known).max(axis=0), 1e-300)
        part, all_ = (
            np.linalg.lstsq(known[of] / scale, x[of, k + 1], rcond=_APPEARS if free else 1e-13)[0]
            for of in (fitted, slice(None))
        )
        transitions[k] = (all_ / scale[:, None])[: depth * n].T
        unexplained += ((x[tested, k + 1] - (known[tested] / scale) @ part)[:, :n] ** 2).sum(axis=0)
        whole += (x[tested, k + 1, :n] ** 2).sum(axis=0)
    return _Part(transitions, unexplained, whole)


@dataclass(frozen=True)
class Repeated:
    """A motion that repeats, as it was measured, for measuring it again with something changed."""

    rig: Rig
    seen: Coordinates
    samples: int
    size: Floats
    segment: int
    nominal: Orbit
    depth: int

    @staticmethod
    def of(rig: Rig, seen: Coordinates, samples: int, size: Floats, segment: int = SEGMENT) -> Repeated:
        """Returns the motion with as many instants in the coordinates as show the hidden states."""
        found, depth = orbit(rig, seen, samples, size, segment), 1
        for deeper in range(2, DEEPEST + 1):
            if found.rest <= SEEN:
                break
            more = orbit(rig, seen, samples, size, segment, depth=deeper)
            if more.rest < found.rest:
                found, depth = more, deeper
        if depth > 1 and found.rest <= UNSEEN:
            more = orbit(rig, seen, samples, size, segment, depth=depth + 1)
            found = replace(found, spread=abs(float(more.logs[0].real - found.logs[0].real)))
        return Repeated(rig, seen, samples, size, segment, found, depth)

    def again(self, altered: Altered, starts: Starts) -> Orbit:
        """Returns the transitions with something changed."""
        rig, seen, samples, size, segment = self.rig, self.seen, self.samples, self.size, self.segment
        return orbit(rig, seen, samples, size, segment, starts, altered=altered, depth=self.depth)

    def sensitivity(self, name: str) -> Slope:
        """Returns that of the logarithm of the largest multiplier."""
        log = float(self.nominal.logs[0].real)
        return Slope.of(self.rig, name, log, lambda starts: float(self.again(Altered(), starts).logs[0].real))

    def decays(self, altered: Altered, starts: Starts) -> bool:
        """Returns whether the largest multiplier is below 1, or twice the one without change where that is more."""
        return self.again(altered, starts).decay < max(1.0, 2.0 * self.nominal.decay)


def observed(
    rig: Rig,
    seen: Coordinates,
    injected: Floats,
    length: int,
    altered: Altered,
) -> Floats:
    """Returns the observed elements every `length` samples from the rig's instant on, (instants, elements)."""
    hold, clock = rig.site.hold, rig.session.opened.plan.clock
    wanted = rig.first + hold * np.arange(0, len(injected), length)
    keeper = Keeper(wanted, clock.step, seen.nodes)
    rig.fly(injected, altered, [keeper], seen.nodes)
    return keeper.rows


class Keeper:
    """An observer that keeps the rows of some base steps."""

    def __init__(self, wanted: NDArray[np.int64], step: float, nodes: Sequence[Node]) -> None:
        self._wanted, self._step, self._nodes = wanted, step, nodes
        self.rows = np.full((len(wanted), len(nodes)), np.nan)

    def see(self, time: Floats, values: Mapping[Node, Floats]) -> None:
        counts = np.round(time / self._step).astype(int)
        _, here, there = np.intersect1d(counts, self._wanted, assume_unique=True, return_indices=True)
        for column, node in enumerate(self._nodes):
            self.rows[there, column] = values[node][here]


def logs(transitions: Floats) -> Complex:
    """Returns the logarithms of the eigenvalues of ... F2 F1 F0, (segments, n, n), the largest first."""
    n = transitions.shape[1]
    whole = np.eye(n)
    for F in transitions:
        whole = F @ whole
    values = np.linalg.eigvals(whole)
    if np.abs(values).min() > 1e-6 * np.abs(values).max():
        return _sorted(np.log(values.astype(complex)))
    Q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))
    for _ in range(max(CYCLES, FACTORS // len(transitions))):
        for F in transitions:
            Q, _ = np.linalg.qr(F @ Q)
    begun, pairs, shifts, sizes = Q, [np.eye(2) for _ in range(n - 1)], np.zeros(n - 1), np.zeros(n)
    signs = np.ones(n)
    for F in transitions:
        Q, R = np.linalg.qr(F @ Q)
        sizes += np.log(np.maximum(np.abs(np.diagonal(R)), 1e-300))
        signs *= np.sign(np.diagonal(R))
        for i in range(n - 1):
            block = R[i : i + 2, i : i + 2] @ pairs[i]
            size = max(float(np.abs(block).max()), 1e-300)
            pairs[i], shifts[i] = block / size, shifts[i] + math.log(size)
    # Q0^T M Q0 = (Q0^T QN) R, which is triangular but for blocks of two equal sizes.
    turned = begun.T @ Q
    found: list[complex] = []
    while (i := len(found)) < n:
        if i + 1 < n and abs(turned[i + 1, i]) > _APART:
            values = np.linalg.eigvals(turned[i : i + 2, i : i + 2] @ pairs[i])
            found += [complex(np.log(value.astype(complex) + 1e-300)) + shifts[i] for value in values]
        else:
            found.append(complex(sizes[i], 0.0 if turned[i, i] * signs[i] > 0.0 else math.pi))
    return _sorted(found)


def _sorted(found: Iterable[complex]) -> Complex:
    return np.array(sorted(found, key=lambda v: (-v.real, v.imag)))
