"""What a scenario expects of its run, and what the run shows of it.

Looked at is every base step, recorded or not, in the window `after` to `before` at which `when` is true.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InputError
from ..fmu.model import Floats, Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse, real, with_unit
from ..scenario.expectations import Bound, Expectation
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import signals
from ..system.starts import item
from ..system.wiring import Node


@dataclass(frozen=True)
class Outcome:
    """What was found. `margin` is positive where the bound is met; both are in `unit`."""

    name: str
    signal: str
    expected: str
    passed: bool
    found: float | None
    """The worst value for `always`, the best one for `ever`, the count for `zeros`; None without a sample."""
    unit: str
    margin: float | None
    time: float | None
    """When it was found, s."""
    samples: int
    note: str = ""

    @property
    def status(self) -> str:
        """`met`, `failed`, or `not reached` where there was no sample to look at."""
        return "met" if self.passed else "failed" if self.samples else "not reached"

    @property
    def text(self) -> str:
        """The value that decides, and when it occurred."""
        if self.found is None:
            return self.note
        boolean = self.expected.endswith((" true", " false"))
        value = str(bool(self.found)).lower() if boolean else with_unit(self.found, self.unit)
        if self.expected.startswith("always") and self.passed and self.margin is None:
            return value  # at all times
        return value if self.time is None else f"{value} at {self.time:.5g} s"


@dataclass(frozen=True)
class Highlight:
    """A signal in two numbers: its value at the end and that of largest magnitude; of a vector, by its largest element."""

    signal: str
    unit: str
    final: float
    peak: float
    time: float
    """When the peak is, s."""

    @property
    def text(self) -> str:
        """The peak and its time."""
        return f"{with_unit(self.peak, self.unit)} at {self.time:.5g} s"


@dataclass(frozen=True)
class Check:
    """An expectation that fits the blocks: signals found, units converted."""

    expectation: Expectation
    nodes: list[Node]
    when: Node | None
    unit: Unit
    """That of the bound, in which it is judged and told."""
    factor: float
    offset: float
    low: float
    high: float
    strict: bool
    expected: str
    number: bool = True
    """Whether the signal is a number, and no boolean or item of an enumeration."""

    @property
    def needed(self) -> list[Node]:
        return [*self.nodes, self.when] if self.when else self.nodes


# ---------------------------------------------------------------- before the run


def prepare(scenario: Scenario, models: Mapping[str, Model]) -> tuple[list[Check], list[str]]:
    """Checks expectations against the blocks, and remarks on them. Raises InputError with every fault.

    One that begins after the end of the run is a fault, but where the duration was given as an option
    it is left out with a remark.
    """
    checks: list[Check] = []
    faults: list[str] = []
    notes: list[str] = []
    shortened = ("duration",) in scenario.source.options
    first: dict[str, int] = {}
    for number, expectation in enumerate(scenario.expect):
        name = " ".join(expectation.name.split())
        if not name or first.setdefault(name, number) != number:
            said = f"is that of expect[{first[name] + 1}], too; expected another" if name else "must not be blank"
            faults.append(scenario.error(("expect", number, "name"), said))
            continue
        if shortened and expectation.after is not None and expectation.after > scenario.duration:
            notes.append(f"not looked at, since the run ends before {expectation.after:.10g} s: {expectation.name}")
            continue
        try:
            checks.append(_check(scenario, ("expect", number), expectation, models))
        except InputError as error:
            faults += error.messages
    if faults:
        raise InputError(*faults)
    return checks, notes


def _check(scenario: Scenario, key: Key, expectation: Expectation, models: Mapping[str, Model]) -> Check:
    variable, nodes = signals.find(scenario, (*key, "signal"), expectation.signal, models)
    when = None
    if expectation.when is not None:
        condition, found = signals.find(scenario, (*key, "when"), expectation.when, models)
        if condition.type != "boolean" or len(found) != 1:
            message = f"expected one boolean, but {expectation.when} is {condition.kind}"
            raise InputError(scenario.error((*key, "when"), message))
        when = found[0]
    if expectation.after is not None and expectation.after > scenario.duration:
        message = f"{expectation.after:.10g} s lies after the end of the run, {scenario.duration:.10g} s"
        raise InputError(scenario.error((*key, "after"), message))
    for name in ("after", "before"):
        if (limit := getattr(expectation, name)) is not None and limit < 0.0:
            raise InputError(scenario.error((*key, name), f"expected zero or more, found {limit:.10g} s"))
    if expectation.before is not None and expectation.before < (expectation.after or 0.0):
        message = f"{expectation.before:.10g} s lies before {expectation.after or 0.0:.10g} s, where the span begins"
        raise InputError(scenario.error((*key, "before"), message))
    if expectation.measure == "norm" and variable.type != "real":
        raise InputError(scenario.error((*key, "measure"), f"{expectation.signal} is {variable.type} and has no norm"))
    if expectation.zeros is not None:
        if len(nodes) != 1 or variable.type == "boolean" or expectation.measure == "norm":
            message = f"zeros are counted of one number; {expectation.signal} is {variable.kind}"
            raise InputError(scenario.error((*key, "zeros"), message))
        unit = variable.unit or ONE
        return Check(expectation, nodes, when, unit, 1.0, 0.0, 0.0, 0.0, False, _times(expectation.zeros))
    how = "always" if expectation.always else "ever"
    bound: Bound = getattr(expectation, how)
    try:
        return _bounded(expectation, nodes, when, variable, bound, how)
    except QuantityError as error:
        raise InputError(scenario.error((*key, how, bound.kind), str(error))) from None


def _times(count: int) -> str:
    return "no change of sign" if count == 0 else f"{count} change{'s' if count > 1 else ''} of sign"


def _bounded(
    expectation: Expectation, nodes: list[Node], when: Node | None, variable: Variable, bound: Bound, how: str
) -> Check:
    value = getattr(bound, bound.kind)
    if variable.type == "boolean":
        if bound.kind != "equals" or not isinstance(value, bool):
            raise QuantityError(f"{expectation.signal} is boolean; expected 'equals: true' or 'equals: false'")
        number = float(value)
        return Check(
            expectation, nodes, when, ONE, 1.0, 0.0, number, number, False, f"{how} {str(value).lower()}", False
        )
    if variable.type == "enumeration" and bound.kind == "equals":
        number = float(item(variable, value))
        return Check(expectation, nodes, when, ONE, 1.0, 0.0, number, number, False, f"{how} {value}", False)
    if isinstance(value, bool):
        raise QuantityError(f"{expectation.signal} is {variable.type}; expected a number, found {str(value).lower()}")
    ends = [_end(end, variable) for end in (value if isinstance(value, list) else [value])]
    units = {unit for _, unit in ends if unit is not None}
    unit = ends[0][1] or next(iter(units), None) or variable.unit or ONE
    numbers = []
    for number, own in ends:
        factor, offset = (own or variable.unit or ONE).conversion(unit)
        numbers.append(factor * number + offset)
    factor, offset = (variable.unit or ONE).conversion(unit) if units else (1.0, 0.0)
    suffix = f" {unit}" if str(unit) != "1" else ""
    low, high = {
        "below": (-math.inf, numbers[0]),
        "above": (numbers[0], math.inf),
        "within": (numbers[0], numbers[1]) if len(numbers) == 2 else (-numbers[0], numbers[0]),
        "equals": (numbers[0], numbers[0]),
    }[bound.kind]
    if low > high:
        raise QuantityError(f"expected [low, high], found {value!r}")
    words = {"below": "<", "above": ">", "within": "within", "equals": "="}[bound.kind]
    span = f"{low:g} .. {high:g}" if len(numbers) == 2 else f"{numbers[0]:g}"
    strict = bound.kind in ("below", "above")
    return Check(expectation, nodes, when, unit, factor, offset, low, high, strict, f"{how} {words} {span}{suffix}")


def _end(end: Any, variable: Variable) -> tuple[float, Unit | None]:
    number, unit = parse(end) if isinstance(end, str) else (real(end), None)
    if not math.isfinite(number):
        raise QuantityError(f"expected a finite number, found {end}")
    if unit is not None and not unit.fits(variable.unit or ONE):
        if variable.unit is None:
            raise QuantityError(f"{variable.name} has no unit, so expected a bare number, found {end!r}")
        raise QuantityError(f"the unit {str(unit)!r} does not fit that of {variable.name}, {variable.unit}")
    return number, unit


# ---------------------------------------------------------------- during the run


class Judge:
    """Looks at an expectation's signal piece by piece, and tells in the end what was found."""

    def __init__(self, check: Check) -> None:
        self.check = check
        self._samples = 0
        self._inside = False
        """Whether a sample lay in the span of time, whatever `when` says."""
        self._worst: tuple[float, float, float] | None = None
        """Of the sample that decides: margin, value and time."""
        self._sign = 0.0
        self._changes = 0
        self._changed: float | None = None
        self._final = 0.0
        self._peak: tuple[float, float] | None = None
        """The value of largest magnitude, and its time."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before."""
        if not len(time):
            return
        check, expectation = self.check, self.check.expectation
        values = np.column_stack([columns[node] for node in check.nodes])
        if expectation.measure == "norm":
            values = np.sqrt((values * values).sum(axis=1, keepdims=True))
        if (check.factor, check.offset) != (1.0, 0.0):
            values = values * check.factor + check.offset
        self._highlight(time, values)
        chosen = np.ones(len(time), bool)
        if expectation.after is not None:
            chosen &= time >= expectation.after - _slack(expectation.after)
        if expectation.before is not None:
            chosen &= time <= expectation.before + _slack(expectation.before)
        self._inside |= bool(chosen.any())
        if check.when is not None:
            chosen &= columns[check.when] != 0.0
        if chosen.any():
            self._samples += int(chosen.sum())
            (self._bound if expectation.zeros is None else self._count)(time[chosen], values[chosen])

    def _bound(self, time: Floats, values: Floats) -> None:
        check, always = self.check, self.check.expectation.always is not None
        margins = np.minimum(values - check.low, check.high - values)
        worst = margins.argmin(axis=1)
        of_sample = margins[np.arange(len(time)), worst]  # a sample is as good as its worst element
        sample = int(of_sample.argmin() if always else of_sample.argmax())
        margin = float(of_sample[sample])
        if self._worst is None or (margin < self._worst[0] if always else margin > self._worst[0]):
            self._worst = margin, float(values[sample, worst[sample]]), float(time[sample])

    def _count(self, time: Floats, values: Floats) -> None:
        signs = np.sign(values[:, 0])
        some = signs != 0.0
        signs = np.concatenate(([self._sign or 0.0], signs[some]))
        changes = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
        self._changes += len(changes)
        if len(changes) and self._changed is None:
            self._changed = float(time[some][changes[0]])
        self._sign = float(signs[-1])

    def _highlight(self, time: Floats, values: Floats) -> None:
        largest = values[np.arange(len(time)), np.abs(values).argmax(axis=1)]
        peak = int(np.abs(largest).argmax())
        self._final = float(largest[-1])
        if self._peak is None or abs(largest[peak]) > abs(self._peak[0]):
            self._peak = float(largest[peak]), float(time[peak])

    @property
    def outcome(self) -> Outcome:
        """What was found up to now."""
        check, expectation, samples = self.check, self.check.expectation, self._samples
        if not samples:
            never = self._inside and f"{expectation.when} is never true"
            return _outcome(check, False, None, None, None, 0, never or "no sample lies in this span of time")
        if expectation.zeros is not None:
            if self._sign == 0.0:
                return _outcome(check, False, None, None, None, samples, "always 0, so it has no sign")
            passed = self._changes == expectation.zeros
            return _outcome(check, passed, float(self._changes), None, self._changed, samples)
        assert self._worst is not None
        margin, found, time = self._worst
        passed = margin > 0.0 if check.strict else margin >= 0.0
        return _outcome(check, passed, found, margin if check.low != check.high else None, time, samples)

    @property
    def highlight(self) -> Highlight | None:
        """The signal's final and peak values; None for what is no number."""
        if self._peak is None or not self.check.number:
            return None
        unit = "" if str(self.check.unit) == "1" else str(self.check.unit)
        return Highlight(_signal(self.check.expectation), unit, self._final, *self._peak)


def _slack(time: float) -> float:
    return 1e-9 * max(1.0, abs(time))


def _outcome(
    check: Check,
    passed: bool,
    found: float | None,
    margin: float | None,
    time: float | None,
    samples: int,
    note: str = "",
) -> Outcome:
    expectation = check.expectation
    unit = "" if expectation.zeros is not None or str(check.unit) == "1" else str(check.unit)
    return Outcome(
        expectation.name, _signal(expectation), check.expected, passed, found, unit, margin, time, samples, note
    )


def highlights(judges: Iterable[Judge]) -> list[Highlight]:
    """Final and peak values of the numbers that the expectations look at, each once."""
    found: dict[str, Highlight] = {}
    for judge in judges:
        if (highlight := judge.highlight) is not None:
            found.setdefault(highlight.signal, highlight)
    return list(found.values())


def _signal(expectation: Expectation) -> str:
    return f"|{expectation.signal}|" if expectation.measure == "norm" else expectation.signal
