"""The samples of a signal that are looked at, for expectations and metrics alike: every base step, recorded or not, in
the window `after` to `before` at which `when` is true, in the phases of `during`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..fmu.model import Floats, Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse, real, suffix
from ..scenario.expectations import Bound, Span
from ..scenario.references import Reference
from ..scenario.source import Key
from ..scenario.timeline import either
from ..system import signals
from ..system.clock import slack
from ..system.phases import Phase, during
from ..system.values import item
from ..system.wiring import Node


@dataclass(frozen=True)
class Sight:
    """A signal and the samples of it that are looked at, known to the blocks."""

    name: str
    """The signal, as messages name it: `|plant.omega_B|` for a norm."""
    variable: Variable
    nodes: list[Node]
    when: Node | None
    during: tuple[Phase, ...]
    span: Span

    @property
    def needed(self) -> list[Node]:
        conditions = [self.when, *(phase.signal for phase in self.during)]
        return [*self.nodes, *(node for node in conditions if node is not None)]

    @np.errstate(over="ignore")
    def values(self, columns: Mapping[Node, Floats], factor: float = 1.0, offset: float = 0.0) -> Floats:
        """Returns the signal (n, elements), or (n, 1) for a norm, in another unit by `factor` and `offset`."""
        values = np.column_stack([columns[node] for node in self.nodes])
        if self.span.measure == "norm":
            values = np.sqrt((values * values).sum(axis=1, keepdims=True))
        return values if (factor, offset) == (1.0, 0.0) else values * factor + offset

    def chosen(self, time: Floats, columns: Mapping[Node, Floats]) -> tuple[bool, NDArray[np.bool_]]:
        """Returns whether a sample lies in the window, whatever `when` says, and which samples (n,) are looked at."""
        span, chosen = self.span, np.ones(len(time), bool)
        if span.after is not None:
            chosen &= time >= span.after - slack(span.after)
        if span.before is not None:
            chosen &= time <= span.before + slack(span.before)
        inside = bool(chosen.any())
        if self.when is not None:
            chosen &= columns[self.when] != 0.0
        if self.during:
            chosen &= np.logical_or.reduce([phase.chosen(time, columns) for phase in self.during])
        return inside, chosen


def sight(
    places: signals.Places,
    key: Key,
    span: Span,
    signal: Reference,
    models: Mapping[str, Model],
    duration: float,
    phases: Mapping[str, Phase],
) -> Sight:
    """Returns a signal and its span held against the blocks; `phases` by their names. Raises InputError."""
    variable, nodes = signals.find(places, (*key, "signal"), signal, models)
    when = None if span.when is None else signals.flag(places, (*key, "when"), span.when, models)
    if span.after is not None and span.after > duration:
        message = f"{span.after:.10g} s lies after the end of the run, {duration:.10g} s"
        raise InputError(places.error((*key, "after"), message))
    for name in ("after", "before"):
        if (limit := getattr(span, name)) is not None and limit < 0.0:
            raise InputError(places.error((*key, name), f"expected zero or more, found {limit:.10g} s"))
    if span.before is not None and span.before < (span.after or 0.0):
        message = f"{span.before:.10g} s lies before {span.after or 0.0:.10g} s, where the span begins"
        raise InputError(places.error((*key, "before"), message))
    if span.measure == "norm" and variable.type != "real":
        raise InputError(places.error((*key, "measure"), f"{signal} is {variable.type} and has no norm"))
    name = f"|{signal}|" if span.measure == "norm" else str(signal)
    return Sight(name, variable, nodes, when, during(places, (*key, "during"), span.during, phases), span)


@dataclass(frozen=True)
class Limits:
    """A bound in one unit, which is also that of what is held against it."""

    unit: Unit
    factor: float
    offset: float
    """From the signal's unit into this one."""
    low: float
    high: float
    strict: bool
    text: str
    """In words, `< 2 deg`."""
    number: bool = True
    """Whether the signal is a number, and no boolean or item of an enumeration."""

    def margins(self, values: Floats) -> Floats:
        """Returns how far values lie within the bound, in its unit; negative outside."""
        return np.minimum(values - self.low, self.high - values)

    def met(self, values: Floats) -> NDArray[np.bool_]:
        """Returns which values meet the bound."""
        margins = self.margins(values)
        return margins > 0.0 if self.strict else margins >= 0.0


def limits(signal: str, variable: Variable, bound: Bound) -> Limits:
    """Returns a bound on a signal, its unit converted. Raises QuantityError."""
    value = getattr(bound, bound.kind)
    if variable.type == "boolean":
        if bound.kind != "equals" or not isinstance(value, bool):
            raise QuantityError(f"{signal} is boolean; expected 'equals: true' or 'equals: false'")
        return Limits(ONE, 1.0, 0.0, float(value), float(value), False, str(value).lower(), False)
    if variable.type == "enumeration" and bound.kind == "equals":
        number = float(item(variable, value))
        return Limits(ONE, 1.0, 0.0, number, number, False, str(value), False)
    if isinstance(value, bool):
        raise QuantityError(f"{signal} is {variable.type}; expected a number, found {str(value).lower()}")
    return numeric(variable.name, variable.unit, bound)


def numeric(name: str, own: Unit | None, bound: Bound) -> Limits:
    """Returns a bound on a number that has the unit `own`, or none. Raises QuantityError."""
    value = getattr(bound, bound.kind)
    ends = [_end(end, name, own) for end in (value if isinstance(value, list) else [value])]
    units = {unit for _, unit in ends if unit is not None}
    unit = ends[0][1] or next(iter(units), None) or own or ONE
    numbers = []
    for number, given in ends:
        factor, offset = (given or own or ONE).conversion(unit)
        numbers.append(factor * number + offset)
    factor, offset = (own or ONE).conversion(unit) if units else (1.0, 0.0)
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
    return Limits(unit, factor, offset, low, high, bound.kind in ("below", "above"), f"{words} {span}{suffix(unit)}")


def _end(end: object, name: str, own: Unit | None) -> tuple[float, Unit | None]:
    number, unit = parse(end) if isinstance(end, str) else (real(end), None)  # type: ignore[arg-type]
    if not math.isfinite(number):
        raise QuantityError(f"expected a finite number, found {end}")
    if unit is not None and not unit.fits(own or ONE):
        if own is None:
            raise QuantityError(f"{name} has no unit, so expected a bare number, found {end!r}")
        raise QuantityError(f"the unit {str(unit)!r} does not fit that of {name}, {own}")
    return number, unit


def one_number(sight: Sight) -> bool:
    """Returns whether it gives one number at each instant."""
    return len(sight.nodes) == 1 or sight.span.measure == "norm"


def window(span: Span) -> str:
    """Returns which samples are looked at, in words."""
    parts = [
        f"{word} {limit:.10g} s" for word, limit in (("from", span.after), ("to", span.before)) if limit is not None
    ]
    parts += [f"while {span.when}" * bool(span.when), f"during {either(span.during or '')}" * bool(span.during)]
    return ", ".join(["", *filter(None, parts)])
