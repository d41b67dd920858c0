"""The ground test card of another team's FMU: stimuli and expected answers in its own names, units and axes.

What is expected is what our block gives; the mapping says what that is in theirs.
Tests: tests/orchestration/acceptance/test_vendor_card.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import rotation
from ...fmu.model import Element, Floats
from ...quantities import shown
from ...swap.findings import Fit
from ...swap.named_values import handed_on
from ...system.starts import Start
from .card import Trial

_SHARE = 0.05
"""Share of an expected change that it may differ by."""
_FLOOR = 0.01
"""The same of the largest change of its port, for what is to stay as it is."""


@dataclass(frozen=True)
class Reading:
    """One scalar of theirs."""

    name: str
    unit: str
    before: float
    after: float
    tolerance: float = 0.0

    @property
    def sign(self) -> str:
        """Its direction: +, -, or 0 where it is to stay."""
        change = self.after - self.before
        return "0" if abs(change) <= self.tolerance else "+" if change > 0 else "-"


@dataclass(frozen=True)
class Line:
    """A stimulus and what answers."""

    text: str
    """The stimulus in words."""
    hold: float
    """s"""
    steps: int
    inputs: list[Reading]
    """Those that change."""
    all: list[Reading]
    """All inputs of theirs."""
    outputs: list[Reading]
    attitudes: tuple[Floats, Floats] | None
    """Body axes of theirs (columns) before and after, where the stimulus turns the body."""


def lines(trials: list[Trial], fit: Fit) -> list[Line]:
    """Returns the card, in theirs; stimuli that theirs does not see are left out."""
    made = []
    axes = body_axes(fit)
    for trial in trials:
        before, after = (_theirs(fit, values, {}) for values in trial.inputs)
        changed = [e for e in before if before[e] != after[e]]
        answers = [_theirs(fit, given, inputs) for given, inputs in zip(trial.outputs, trial.inputs, strict=True)]
        wanted = [e for e in answers[0] if fit.theirs.variables[e.variable].causality == "output"]
        if not changed or not wanted:
            continue
        largest: dict[str, float] = {}
        for e in wanted:
            port = _stem(fit, e)
            largest[port] = max(largest.get(port, 0.0), abs(answers[1][e] - answers[0][e]))
        outputs = [
            _reading(fit, e, answers[0][e], answers[1][e], largest[_stem(fit, e)])
            for e in wanted
            if largest[_stem(fit, e)]
        ]
        given = [_reading(fit, e, before[e], after[e]) for e in before]
        inputs = [reading for reading in given if reading.before != reading.after]
        made.append(
            Line(_text(trial, inputs, axes), trial.hold, trial.steps, inputs, given, outputs, _turned(trial, axes))
        )
    return made


def settings(fit: Fit, starts: Iterable[Start]) -> list[tuple[str, Any, str]]:
    """Returns name, value and unit of each parameter of theirs that the run sets."""
    values = handed_on(fit, [(start.element, start.value) for start in starts])
    own = [e for e in values if fit.theirs.variables[e.variable].causality == "parameter"]
    return [(_name(fit, e), values[e], _unit(fit, e)) for e in own]


def body_axes(fit: Fit) -> Floats:
    """Returns the axes of their vectors in ours (rows); those of ours where no vector of theirs has others."""
    for link in fit.links.values():
        if link.A is None or link.A.shape != (3, 3) or link.turned or not link.ours.frame or link.ours.size != 3:
            continue
        scale = np.cbrt(abs(np.linalg.det(link.A)))
        U = link.A / scale if scale > 0 else link.A
        if np.allclose(U @ U.T, np.eye(3), atol=1e-6) and np.linalg.det(U) > 0:
            return U
    return np.eye(3)


def axis_and_angle(R: Floats) -> str:
    """Returns a rotation matrix in words."""
    x = np.array(rotation.three(R.ravel().tolist(), "rotation vector"))
    angle = float(np.linalg.norm(x))
    if angle < 1e-9:
        return "no turn"
    return f"{math.degrees(angle):.1f} deg about ({', '.join(f'{c:+.3f}' for c in x / angle)})"


def _theirs(fit: Fit, values: Mapping[str, Floats], more: Mapping[str, Floats]) -> dict[Element, float]:
    """Returns what theirs is for values of ours; `more` are others on which that may depend."""
    ours = [(e, float(row[e.position])) for name, row in {**more, **values}.items() for e in _elements(fit, name, row)]
    theirs = handed_on(fit, ours)
    own = {e for name in values if name in fit.links for e in fit.links[name].theirs}
    return {e: float(v) for e, v in theirs.items() if e in own and isinstance(v, (int, float))}


def _elements(fit: Fit, name: str, row: Floats) -> list[Element]:
    return [Element(name, i) for i in range(len(row))] if name in fit.links else []


def _name(fit: Fit, element: Element) -> str:
    return fit.theirs.variables[element.variable].label(element.position)


def _stem(fit: Fit, element: Element) -> str:
    """The port of ours for which it stands: its elements share a scale."""
    return next(name for name, link in fit.links.items() if element in link.theirs)


def _reading(fit: Fit, element: Element, before: float, after: float, largest: float = 0.0) -> Reading:
    tolerance = max(_SHARE * abs(after - before), _FLOOR * largest)
    return Reading(_name(fit, element), _unit(fit, element), before, after, tolerance)


def _unit(fit: Fit, element: Element) -> str:
    unit = fit.theirs.variables[element.variable].at([element.position]).unit
    return "" if unit is None else shown(unit)


def _text(trial: Trial, inputs: list[Reading], axes: Floats) -> str:
    if trial.turned is None:
        return f"{', '.join(reading.name for reading in inputs)} set"
    axis = axes[:, trial.axis]
    along = int(np.abs(axis).argmax())
    exact = abs(axis[along]) > 1 - 1e-6
    names = f"{'+' if axis[along] > 0 else '-'}{'xyz'[along]}" if exact else f"({', '.join(f'{c:+.3f}' for c in axis)})"
    return f"body turned by {math.degrees(trial.turned):+.3g} deg about its {names} axis"


def _turned(trial: Trial, axes: Floats) -> tuple[Floats, Floats] | None:
    if trial.turned is None:
        return None
    before, after = (inputs[trial.port].reshape(3, 3) @ axes.T for inputs in trial.inputs)
    return before, after


def as_data(card: list[Line], about: Mapping[str, Any], parameters: list[tuple[str, Any, str]]) -> dict[str, Any]:
    """Returns the card as plain data, for the script and for others."""
    return {
        **about,
        "parameters": {name: value for name, value, _ in parameters},
        "steps": [
            {
                "stimulus": line.text,
                "hold_s": line.hold,
                "steps": line.steps,
                "inputs": {reading.name: [reading.before, reading.after] for reading in line.all},
                "expected": [
                    {"output": r.name, "unit": r.unit, "before": r.before, "after": r.after, "tolerance": r.tolerance}
                    for r in line.outputs
                ],
            }
            for line in card
        ],
    }
