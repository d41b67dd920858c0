"""A scenario's expectations, checked against its blocks before the run; judge.py holds the run against them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse, real
from ..scenario.expectations import Bound, Expectation
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..system import signals
from ..system.values import item
from ..system.wiring import Node


@dataclass(frozen=True)
class Check:
    """An expectation that fits the blocks: its signals are known, its units converted."""

    expectation: Expectation
    nodes: list[Node]
    when: Node | None
    unit: Unit
    """That of the bound, which is also that of the outcome."""
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


def prepare(scenario: Scenario, models: Mapping[str, Model]) -> tuple[list[Check], list[str]]:
    """Checks expectations against the blocks, and remarks on them. Raises InputError with every error.

    One that begins after the end of the run is an error; where the duration was given as an option,
    it is left out with a remark.
    """
    checks: list[Check] = []
    errors: list[str] = []
    notes: list[str] = []
    shortened = ("duration",) in scenario.source.options
    first: dict[str, int] = {}
    for number, expectation in enumerate(scenario.expect):
        name = " ".join(expectation.name.split())
        if not name or first.setdefault(name, number) != number:
            message = f"is that of expect[{first[name] + 1}], too; expected another" if name else "must not be blank"
            errors.append(scenario.error(("expect", number, "name"), message))
            continue
        if shortened and expectation.after is not None and expectation.after > scenario.duration:
            notes.append(f"not looked at, since the run ends before {expectation.after:.10g} s: {expectation.name}")
            continue
        try:
            checks.append(_check(scenario, ("expect", number), expectation, models))
        except InputError as error:
            errors += error.messages
    if errors:
        raise InputError(*errors)
    return checks, notes


def _check(scenario: Scenario, key: Key, expectation: Expectation, models: Mapping[str, Model]) -> Check:
    variable, nodes = signals.find(scenario, (*key, "signal"), expectation.signal, models)
    when = None
    if expectation.when is not None:
        condition, elements = signals.find(scenario, (*key, "when"), expectation.when, models)
        if condition.type != "boolean" or len(elements) != 1:
            message = f"expected one boolean, but {expectation.when} is {condition.kind}"
            raise InputError(scenario.error((*key, "when"), message))
        when = elements[0]
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
        return Check(expectation, nodes, when, unit, 1.0, 0.0, 0.0, 0.0, False, changes_of_sign(expectation.zeros))
    how = "always" if expectation.always else "ever"
    bound: Bound = getattr(expectation, how)
    try:
        return _bounded(expectation, nodes, when, variable, bound, how)
    except QuantityError as error:
        raise InputError(scenario.error((*key, how, bound.kind), str(error))) from None


def changes_of_sign(count: int) -> str:
    """What `zeros` expects, in words."""
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
