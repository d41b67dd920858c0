"""Seeks the least change that loses a loop, by bisection on flights.

Either the answer to a pulse grows, or an expectation of the scenario fails that is met without the change. A change is
a factor on the signal at the rig's site (`gain`), a delay of it, or a factor on a parameter.

Tests: tests/orchestration/margins/test_search.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import BlockError, InputError, Place, Problem, hint
from ..expectations.checks import Check
from ..expectations.outcomes import ExpectationObserver
from ..fmu.model import Floats, NameUnknown
from ..scenario.references import Reference
from ..system.starts import Start
from .inject import Altered, Rig

CLOSE = 0.02
"""Where the bisection ends: the two ends beside their mean."""
CHANGE = 0.01
"""Relative change of a parameter for a sensitivity."""
_PULSE = 1e-3
"""Beside the channel's largest value."""
_UNLIKE = 0.5
"""Difference of answers to pulses of two sizes, beside the answer, with which the loop counts as lost."""
_FAR = 1e3
"""Signal without a pulse, beside its largest before the change, with which the loop counts as lost."""
Starts = Mapping[str, Sequence[Start]] | None
"""Start values where parameters are changed; None for those of the scenario."""
Holds = Callable[[Altered, Starts], bool]


@dataclass(frozen=True)
class Change:
    """A change from the value at which the loop is known to hold."""

    name: str
    """`gain`, `delay` (s), or a parameter as `block.parameter`."""
    start: float
    end: float

    @staticmethod
    def of(text: str) -> Change:
        """Reads `delay=0..20`, `gain=1..0.1` or `plant.J_B=1..10`. Raises InputError."""
        name, _, span = (part.strip() for part in text.partition("="))
        try:
            start, end = (float(part) for part in span.split(".."))
        except ValueError:
            start = end = math.nan
        least = 0.0 if name == "delay" else 1e-9
        if not (name and least <= start < 1e9 and least <= end < 1e9 and start != end):
            raise InputError(
                Problem(
                    expected="NAME=FROM..TO with two numbers that differ, above 0 (a delay also 0) and below 1e9",
                    found=repr(text),
                    place=Place(f"--change {text}"),
                )
            )
        return Change(name, start, end)


@dataclass(frozen=True)
class Lost:
    """The end of a search."""

    change: Change
    holds: float
    """The largest change that was seen to hold."""
    lost: float
    """The least that was seen to lose it; infinite where the end of the span holds."""
    flights: int

    def __str__(self) -> str:
        end = f"lost at {self.lost:.4g}" if math.isfinite(self.lost) else "the end of the span"
        return f"{self.change.name}: holds at {self.holds:.4g}, {end}"

    def data(self) -> dict[str, Any]:
        """Returns the same for JSON."""
        lost_at = self.lost if math.isfinite(self.lost) else None
        return {"name": self.change.name, "holds": self.holds, "lost": lost_at}


def lost(rig: Rig, change: Change, holds: Holds) -> Lost:
    """Returns between which values of a change the loop is lost. Raises InputError where it does not hold at the
    start."""
    before = rig.flights

    def held(value: float) -> bool:
        return holds(*_applied(rig, change, value))

    place = Place(f"--change {change.name}")
    if not held(change.start):
        raise InputError(Problem(f"the loop does not hold at {change.start:g}, where it should", place=place))
    good, bad = change.start, change.end
    if held(bad):
        return Lost(change, bad, math.inf, rig.flights - before)
    step = rig.session.opened.plan.clock.step if change.name == "delay" else 0.0
    while abs(bad - good) > max(CLOSE * 0.5 * (good + bad), 1.01 * step):
        middle = math.sqrt(good * bad) if good > 0.0 and change.name != "delay" else 0.5 * (good + bad)
        good, bad = (middle, bad) if held(middle) else (good, middle)
    return Lost(change, good, bad, rig.flights - before)


def pulse_dies_out(rig: Rig, samples: int, most: Floats | float = math.inf) -> Holds:
    """Returns whether a pulse at the site is answered by less at the end of the window than at its beginning, and one
    of half its size with the other sign in proportion. A loop that is lost at once shows no answers but a tumble, in
    which the signal is far larger than before. `most`: largest pulse of each channel."""

    def holds(altered: Altered, starts: Starts) -> bool:
        still = np.zeros((samples, len(rig.site.channels)))
        pulse = still.copy()
        pulse[0] = np.minimum(_PULSE * rig.scales, most)
        try:
            base, *moved = (rig.fly(part * pulse, altered, starts=starts) for part in (0.0, 1.0, -0.5))
        except BlockError as error:
            if error.time is None:
                raise  # a value that the FMU refuses says nothing of the loop
            return False
        if np.abs(base).max() > _FAR * rig.scales.max():
            return False
        whole, half = (came - base for came in moved)
        first, *_, last = (float(part.mean()) for part in np.array_split(np.abs(whole).max(axis=1), 4))
        apart = float(np.abs(whole + 2.0 * half).max(axis=1).mean())
        return last < first and apart < _UNLIKE * float(np.abs(whole).max(axis=1).mean())

    return holds


def expectations_are_met(rig: Rig, checks: Sequence[Check] | None = None) -> Holds:
    """Returns whether a flight of the scenario's length meets these expectations, or every one."""
    plan = rig.session.opened.plan
    checks = plan.checks if checks is None else checks
    nodes = list(dict.fromkeys(node for check in checks for node in check.needed))
    samples = max(plan.clock.steps - rig.first, 0) // rig.site.hold

    def holds(altered: Altered, starts: Starts) -> bool:
        observers = [ExpectationObserver(check) for check in checks]
        try:
            rig.fly(np.zeros((samples, len(rig.site.channels))), altered, observers, nodes, starts)
        except BlockError as error:
            if error.time is None:
                raise
            return False
        return all(observer.outcome(False).passed for observer in observers)

    return holds


@dataclass(frozen=True)
class Slope:
    """By how much the logarithm of a size changes for a parameter's relative change of one."""

    value: float
    apart: float
    """By how much the slopes upwards and downwards differ; both are NaN where a changed loop has no number."""

    @staticmethod
    def of(rig: Rig, name: str, nominal: float, log: Callable[[Starts], float]) -> Slope:
        """Measures it from changes of CHANGE and -CHANGE. Raises InputError for a parameter that is none."""
        changed = (scaled(rig, name, 1.0 + part, "--sensitivity") for part in (CHANGE, -CHANGE))
        up, down = ((log({**rig.session.opened.plan.starts, **starts}) - nominal) / CHANGE for starts in changed)
        return Slope(0.5 * (up - down), abs(up + down))

    def line(self, name: str, what: str) -> str:
        """Returns what is told of it."""
        if math.isnan(self.value):
            return f"{name} ± 1 %: no number, since the changed loop has none"
        factor, more = math.exp(0.01 * self.value), 0.005 * self.apart
        return f"{name} + 1 %: {what} times {factor:.5g} ± {factor * more:.2g}"


def _applied(rig: Rig, change: Change, value: float) -> tuple[Altered, Starts]:
    plan = rig.session.opened.plan
    if change.name == "gain":
        return Altered(gain=value), None
    if change.name == "delay":
        return Altered(delay=round(value / plan.clock.step)), None
    return Altered(), {**plan.starts, **scaled(rig, change.name, value)}


def scaled(rig: Rig, name: str, factor: float, option: str = "--change") -> dict[str, list[Start]]:
    """Returns the start values of a block with one parameter, or an element of it, multiplied. Raises InputError."""
    plan, place = rig.session.opened.plan, Place(f"{option} {name}")
    try:
        reference = Reference(name)
        model = plan.models.get(reference.block)
        if model is None:
            raise NameUnknown(f"there is no block {reference.block!r}{hint(reference.block, plan.models)}")
        variable, positions = model.find(reference.block, reference.variable, reference.indices, ("parameter",))
        if variable.type != "real" or variable.causality != "parameter":
            raise NameUnknown(f"{name} is {variable.kind}, {variable.causality}; expected a real parameter")
    except (NameUnknown, InputError) as error:
        raise InputError(Problem(str(error), place=place)) from None
    given = {start.element: start.value for start in plan.starts[reference.block]}
    for position in positions:
        element = variable.elements[position]
        value = given.get(element, model.starts.get(element))
        if value is None:
            raise InputError(Problem(f"the value of {name} is not known; remedy: state it under start", place=place))
        given[element] = factor * float(value)
    if not any(given[variable.elements[position]] for position in positions):
        raise InputError(
            Problem(f"{name} is 0, which no factor changes; remedy: state a value of it under start", place=place)
        )
    return {reference.block: [Start(element, value) for element, value in given.items()]}
