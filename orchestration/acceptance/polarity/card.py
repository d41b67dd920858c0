"""Makes the ground test card: a stimulus at each port, and what the block's outputs then do, by sign and size.

Each block stands alone. Its inputs keep the values of that instant of the run at which the smallest of them,
beside its own largest value, is largest. One of them is changed for a second, or for one step of the block where that
is longer. What the outputs differ by from those without the change is expected.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ... import rotation
from ...errors import BlockError
from ...fmu.model import Floats, Variable
from ...quantities import Unit, suffix
from ...system.wiring import Node
from ..playback import play_opened
from .bench import flown_inputs
from .fly import Columns, Loop
from .ports import kind_of

_TURN = math.radians(10.0)
_HOLD = 1.0
"""Seconds that a stimulus lasts."""
_SMALL = 1e-3
"""Share of an output's largest value below which its change is not listed, and of its largest element."""
_OUTPUTS = 3
"""So many outputs are listed at most, those first that change most."""


@dataclass(frozen=True)
class Step:
    """One line of the card."""

    block: str
    port: str
    stimulus: str
    hold: float
    """s"""
    output: str
    expected: str
    """Signs and sizes of its elements, with the unit."""


@dataclass(frozen=True)
class Trial:
    """A stimulus in numbers: values (elements,) by the names of the ports, before it and at its end."""

    block: str
    port: str
    axis: int
    """The element that is changed; of a rotation the column about which it is turned."""
    turned: float | None
    """Of a rotation by how much, rad."""
    hold: float
    steps: int
    """Steps of the block in this time."""
    inputs: tuple[dict[str, Floats], dict[str, Floats]]
    outputs: tuple[dict[str, Floats], dict[str, Floats]]
    """Those that answer."""


@dataclass(frozen=True)
class Card:
    """The lines, and for each block the inputs at which it stands before each stimulus."""

    steps: list[Step]
    base: dict[str, dict[str, str]]
    trials: list[Trial] = field(default_factory=list)


def card(loop: Loop, blocks: Sequence[str] | None = None) -> Card:
    """Returns the test card of a loop's blocks, or of these."""
    fed = [node for link in loop.plan.wiring.links for node in link.source]
    models = loop.plan.models.items()
    reals = [Node(block, e) for block, m in models for v in m.of("output") if v.type == "real" for e in v.elements]
    _, signals = loop.record(list(dict.fromkeys([*fed, *reals])))
    made = Card([], {})
    for block in blocks or loop.plan.models:
        if flown := flown_inputs(loop, block, signals):
            _Stand(loop, block, flown, signals).run(made)
    return made


class _Stand:
    """One block alone."""

    def __init__(self, loop: Loop, block: str, flown: dict[str, Floats], signals: Columns) -> None:
        plan = loop.plan
        self.loop, self.block, self.flown, self.model = loop, block, flown, plan.models[block]
        every = plan.scenario.blocks[block].every
        self.count = max(round(_HOLD / (plan.clock.step * every)), 1) * every
        self.clock = replace(plan.clock, steps=self.count, interval=1)
        sizes = [np.linalg.norm(values, axis=1) for values in flown.values()]
        alive = np.min([size / size.max() for size in sizes if size.any()] or [np.zeros(1)], axis=0)
        self.row = int(alive.argmax())
        self.base = {name: np.repeat(values[self.row][None], self.count + 1, axis=0) for name, values in flown.items()}
        wired = {source for link in plan.wiring.links for source in link.source if source.block == block}
        names = {node.element.variable for node in wired}
        self.shown = [v for v in self.model.of("output") if v.type == "real" and (v.name in names or not names)]
        self.peaks = {v.name: max(float(np.abs(signals[Node(block, e)]).max()) for e in v.elements) for v in self.shown}

    def run(self, card: Card) -> None:
        """Adds the block's lines to the card."""
        at_rest = self._last(self.base)
        if isinstance(at_rest, str):
            return
        variables = self.model.variables
        card.base[self.block] = {name: _vector(variables[name], values[0]) for name, values in self.base.items()}
        for name, values in self.flown.items():
            axes = 3 if kind_of(variables[name], range(values.shape[1]), values) == "rotation" else values.shape[1]
            for axis in range(axes):
                card.steps.extend(self._axis(card, name, values, axis, at_rest))

    def _axis(self, card: Card, name: str, values: Floats, axis: int, at_rest: dict[str, Floats]) -> list[Step]:
        """Returns the lines of one axis of an input, with less of it where a limit or a hold keeps all as it is."""
        port, hold = f"{self.block}.{name}", self.count * self.clock.step
        lines: list[Step] = []
        for share in (1.0, 0.1, 0.01):
            stimulus = _stimulus(self.model.variables[name], values, self.row, axis, share)
            if stimulus is None:
                return []
            text, stimulated, turned = stimulus
            held = np.repeat(stimulated[None], self.count + 1, axis=0)
            held[0] = self.base[name][0]  # it begins at the base, so that nothing latches the stimulus
            after = self._last({**self.base, name: held})
            if isinstance(after, str):
                lines = lines or [Step(self.block, port, text, hold, "", after)]
                continue
            changes = {v.name: after[v.name] - at_rest[v.name] for v in self.shown}
            shares = {n: float(np.abs(c).max()) / self.peaks[n] if self.peaks[n] else 0.0 for n, c in changes.items()}
            listed = sorted((n for n in shares if shares[n] > _SMALL * share), key=lambda n: -shares[n])[:_OUTPUTS]
            if listed:
                of = self.model.variables
                before = {n: rows[0] for n, rows in self.base.items()}
                steps = self.count // self.loop.plan.scenario.blocks[self.block].every
                outputs = {n: at_rest[n] for n in listed}, {n: after[n] for n in listed}
                inputs = before, {**before, name: stimulated}
                card.trials.append(Trial(self.block, name, axis, turned, hold, steps, inputs, outputs))
                return [Step(self.block, port, text, hold, n, _vector(of[n], changes[n], sign=True)) for n in listed]
            lines = lines or [Step(self.block, port, text, hold, "", "no output changes")]
        return lines

    def _last(self, inputs: dict[str, Floats]) -> dict[str, Floats] | str:
        """Returns the outputs at the end, or why there are none."""
        try:
            _, played, failure = play_opened(self.loop.opened, self.block, inputs, self.clock)
        except BlockError as error:
            failure = error
        return f"refused: {failure.problem}" if failure else {name: values[-1] for name, values in played.items()}


def _stimulus(
    variable: Variable, values: Floats, row: int, axis: int, share: float
) -> tuple[str, Floats, float | None] | None:
    """Returns to what an input is set on one of its axes, in words and in numbers, and of a rotation by what angle;
    None where that is nothing."""
    first, n = values[row], values.shape[1]
    if variable.type == "boolean":
        return "inverted", 1.0 - first, None
    if variable.type != "real":
        return None
    if kind_of(variable, range(n), values) == "rotation":
        turn = np.array(rotation.about([float(axis == j) for j in range(3)], _TURN)).reshape(3, 3)
        text = f"{variable.name} turned by +10 deg about its column {axis + 1}"
        return text, (first.reshape(3, 3) @ turn).ravel(), _TURN
    alike = [axis] if variable.units else list(range(n))
    sizes = np.linalg.norm(values[:, alike], axis=1)
    steady = 0.1 if sizes.min() > 0.5 * sizes.max() else 1.0  # what never vanishes is changed by a part of it
    one = variable.at([axis])
    factor = _factor(one)
    change = float(f"{steady * share * float(np.abs(values[:, alike]).max()) * factor:.1g}") / factor
    if change == 0.0:
        return None
    label = variable.name + (f"[{axis + 1}]" if n > 1 else "")
    return f"{label} {_vector(one, np.array([change]), sign=True)}", first + change * np.eye(n)[axis], None


def _shown_in(variable: Variable) -> Unit | None:
    return variable.display_unit or variable.unit


def _factor(variable: Variable) -> float:
    display, unit = _shown_in(variable), variable.unit
    return unit.factor / display.factor if display and unit and unit.exponents is not None else 1.0


def _vector(variable: Variable, values: Floats, sign: bool = False) -> str:
    """Returns values in the unit in which they are shown, without what is small beside the largest."""
    factor = _factor(variable)
    largest = float(np.abs(values).max())
    cells = [f"{x * factor:{'+' if sign else ''}.3g}" if abs(x) > _SMALL * largest else "0" for x in values]
    text = cells[0] if len(cells) == 1 else f"({', '.join(cells)})"
    return text + (suffix(_shown_in(variable)) if not variable.units else "")
