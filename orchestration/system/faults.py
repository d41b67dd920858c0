"""The faults of a scenario, which set, freeze, bias or cut.

A signal's fault acts on the connection, on what a receiver is given; the block that gives the signal is
sound, and so is what is recorded of it. A value is at fault where the instant to which it belongs lies
within the fault's span: at `at` it is the first time, at `until` no more.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from ..errors import InputError, as_written, hint
from ..fmu.model import Element, Model, NameUnknown, Variable, unit_of
from ..quantities import QuantityError, parse
from ..scenario.faults import Fault, sentence
from ..scenario.references import Name, Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .clock import steps_to
from .values import Scalar, leaves, scalar, values_of
from .wiring import Link, Node, Wiring

Span = tuple[int, float]
"""The counts of base steps at which a fault acts first, and no more."""
_LATE = "does not happen, since the run ends before: {}"


@dataclass(frozen=True, eq=False)
class Setting:
    """Values that a block is given at an instant. Those of a fault stand over those of the timeline while its span lasts.

    Two with the same entries are still two, each of which begins and ends.
    """

    block: str
    values: tuple[tuple[Element, Scalar], ...]
    span: Span
    name: str
    of_fault: bool = True


@dataclass(frozen=True)
class Disturbance:
    """A fault of one element of a connection. `value` is what is added or given instead, in the receiver's unit."""

    target: Node
    source: Node
    delayed: bool
    kind: str
    value: float
    span: Span
    number: int
    """Of the fault in the scenario."""

    def behind(self, parallel: bool, places: Mapping[str, int]) -> int:
        """How many base steps before the instant at which the receiver's step ends the value belongs to: 0 or 1.

        What is stepped later in the same base step, or gives its values delayed, is a step behind; `places` of the blocks.
        """
        late = self.delayed or places[self.source.block] >= places[self.target.block]
        return int(late or parallel)


@dataclass
class Faults:
    """All faults of a run, in the order of the scenario, and behind them the settings of its timeline."""

    settings: list[Setting] = field(default_factory=list)
    disturbances: list[Disturbance] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.settings or self.disturbances)


def resolve(scenario: Scenario, models: Mapping[str, Model], wiring: Wiring) -> Faults:
    """The faults of the scenario, checked against its blocks. Raises InputError with everything that is wrong."""
    faults = Faults()
    errors: list[str] = []
    for number, fault in enumerate(scenario.faults):
        key: Key = ("faults", number)
        try:
            span = _span(scenario, key, fault, faults.notes)
            if span is None:
                continue
            if fault.set is not None:
                made = setting(fault.set.target, fault.set.value, models, wiring, span)
                if not is_unseen(scenario, (*key, "at"), fault.at, made, sentence(fault), faults.notes):
                    faults.settings.append(made)
            else:
                faults.disturbances += _disturbances(number, fault, models, wiring, span)
        except (QuantityError, NameUnknown) as error:
            errors.append(scenario.error((*key, fault.kind), str(error)))
        except InputError as error:
            errors += error.messages
    if errors:
        raise InputError(*errors)
    return faults


def _span(scenario: Scenario, key: Key, fault: Fault, notes: list[str]) -> Span | None:
    """None for a fault that begins after the end of a run that was shortened by an option."""
    if fault.at > scenario.duration:
        if ("duration",) in scenario.source.options:
            notes.append(_LATE.format(sentence(fault)))
            return None
        message = f"{fault.at:.10g} s lies after the end of the run, {scenario.duration:.10g} s"
        raise InputError(scenario.error((*key, "at"), message))
    first = count_of(scenario, (*key, "at"), fault.at, notes)
    return first, math.inf if fault.until is None else count_of(scenario, (*key, "until"), fault.until, notes)


def count_of(scenario: Scenario, key: Key, time: float, notes: list[str]) -> int:
    """The first instant at this time or after it, but for rounding."""
    count, exact = steps_to(scenario, time)
    if not exact:
        taken = float(count * Fraction(repr(scenario.step)))
        message = f"{time:.10g} s is no multiple of the step, {scenario.step:.10g} s; taken as {taken:.10g} s"
        notes.append(scenario.error(key, message))
    return count


def is_unseen(scenario: Scenario, key: Key, time: float, made: Setting, late: str, notes: list[str]) -> bool:
    """Whether the last step of its block has begun before: a note of what is `late` where an option shortened the run.

    Raises InputError where none did.
    """
    every, (steps, _) = scenario.blocks[made.block].every, steps_to(scenario, scenario.duration)
    last = (steps // every - 1) * every
    if made.span[0] <= last:
        return False
    if ("duration",) in scenario.source.options:
        notes.append(_LATE.format(late))
        return True
    begun = float(last * Fraction(repr(scenario.step)))
    message = (
        f"{time:.10g} s lies after the beginning of the last step of {made.block}, {begun:.10g} s; no step sees it"
    )
    raise InputError(scenario.error(key, message))


def drop_unseen(scenario: Scenario, blocks: Sequence[str], faults: Faults) -> None:
    """Takes faults of connections away that come after the last step of every receiver, where an option shortened the run.

    `blocks` in the order in which they are stepped. Raises InputError for other faults whose span has no step of a receiver.
    """
    places = {block: place for place, block in enumerate(blocks)}
    seen = {d.number for d in faults.disturbances if _is_seen(scenario, d, places)}
    unseen = {d.number: d for d in faults.disturbances if d.number not in seen}
    late, errors = ("duration",) in scenario.source.options, []
    for number, disturbance in unseen.items():
        fault, every = scenario.faults[number], scenario.blocks[disturbance.target.block].every
        if late and fault.until is None:
            faults.notes.append(_LATE.format(sentence(fault)))
            continue
        message = (
            f"no step of {disturbance.target.block} is given a value from {fault.at:.10g} s"
            f"{'' if fault.until is None else f' to {fault.until:.10g} s'}; "
            f"it is stepped each {float(every * Fraction(repr(scenario.step))):.10g} s"
        )
        errors.append(scenario.error(("faults", number, "at"), message))
    if errors:
        raise InputError(*errors)
    faults.disturbances = [d for d in faults.disturbances if d.number not in unseen]


def _is_seen(scenario: Scenario, disturbance: Disturbance, places: Mapping[str, int]) -> bool:
    """Whether the receiver is given a value of the span: at the start or by a step."""
    (first, last), behind = disturbance.span, disturbance.behind(scenario.exchange == "parallel", places)
    every, (steps, _) = scenario.blocks[disturbance.target.block].every, steps_to(scenario, scenario.duration)
    end = max(-(-(first + behind) // every), 1) * every
    at_start = first == 0 and not disturbance.delayed and last > 0
    return at_start or (end <= steps and end - behind < last)


def _signal(reference: Reference, models: Mapping[str, Model]) -> tuple[str, Variable, list[int]]:
    block = reference.block
    if block not in models:
        raise NameUnknown(f"there is no block {block!r}{hint(block, models)}")
    of = ("input", "output", "parameter")
    return block, *models[block].find(block, reference.variable, reference.indices, of)


def setting(name: Reference, value: Any, models: Mapping[str, Model], wiring: Wiring, span: Span) -> Setting:
    """Values for an input that is not connected, or a tunable parameter. Raises QuantityError and NameUnknown."""
    block, variable, positions = _signal(name, models)
    if variable.causality == "parameter" and variable.variability != "tunable":
        raise QuantityError(
            f"{name} is {variable.variability}: FMI lets only tunable parameters and inputs be set during a run"
            f"{_tunable(models[block])}"
        )
    if variable.causality == "input":
        fed = {node for link in wiring.links for node in link.target}
        if any(Node(block, Element(variable.name, position)) in fed for position in positions):
            raise QuantityError(f"{name} is connected; remedy: 'cut: {name}' with 'to', which takes the signal's place")
    values = values_of(block, models[block], Name(name.partition(".")[2]), value)
    if variable.type == "string" and span[1] < math.inf:
        raise QuantityError(f"{name} is text, which can be set but not be restored; remedy: leave out 'until'")
    return Setting(block, tuple(values.items()), span, name)


def _tunable(model: Model) -> str:
    names = [variable.name for variable in model.of("parameter") if variable.variability == "tunable"]
    return f"; tunable are {', '.join(names)}" if 0 < len(names) <= 12 else ""


def _disturbances(
    number: int, fault: Fault, models: Mapping[str, Model], wiring: Wiring, span: Span
) -> list[Disturbance]:
    reference = fault.target
    block, variable, positions = _signal(reference, models)
    if variable.causality == "parameter":
        raise QuantityError(f"{reference} is a parameter and no signal; remedy: set: {reference} = ...")
    values = _values(fault, reference, variable, positions)
    disturbances = []
    for position, value in zip(positions, values, strict=True):
        node = Node(block, Element(variable.name, position))
        for link, source, target in _ends(wiring):
            if node == source:
                own = link.factor * value + (link.offset if fault.kind == "cut" else 0.0)
            elif node == target:
                own = value
            else:
                continue
            disturbances.append(Disturbance(target, source, link.delayed, fault.kind, own, span, number))
    if not disturbances and variable.causality == "input":
        raise QuantityError(f"{reference} is not connected; remedy: set: {reference} = ...")
    if not disturbances:
        raise QuantityError(f"{reference} feeds no input, so nothing would change")
    return disturbances


def _ends(wiring: Wiring) -> Iterable[tuple[Link, Node, Node]]:
    return ((link, s, t) for link in wiring.links for s, t in zip(link.source, link.target, strict=True))


def _values(fault: Fault, reference: str, variable: Variable, positions: Sequence[int]) -> list[float]:
    """What each element is biased by, or given instead; in the unit of the variable."""
    shape = variable.shape if len(positions) == variable.size else ()
    if fault.kind == "bias":
        if variable.type not in ("real", "integer"):
            raise QuantityError(f"{reference} is {variable.type} and cannot be biased; remedy: 'cut' with 'to'")
        by = leaves(fault.by, shape, variable)
        return [_difference(variable.at([p]), leaf) for p, leaf in zip(positions, by, strict=True)]
    if fault.kind == "freeze":
        return [0.0] * len(positions)
    if fault.to is None:
        if variable.type == "enumeration":
            raise QuantityError(
                f"{reference} is an enumeration, which has no zero; expected 'to' with one of its items"
            )
        return [0.0] * len(positions)
    whole = leaves(fault.to, shape, variable) if isinstance(fault.to, (list, tuple)) else [fault.to] * len(positions)
    unlimited = replace(variable, shape=(), minima=(), maxima=())
    return [float(scalar(unlimited.at([p]), 0, leaf)) for p, leaf in zip(positions, whole, strict=True)]


def _difference(variable: Variable, value: Any) -> float:
    """A difference of two values of the variable: units with an offset have none here."""
    number, own = parse(value) if isinstance(value, str) else (value, None)
    if isinstance(number, bool) or not isinstance(number, (int, float)) or not math.isfinite(number):
        raise QuantityError(f"by: expected a number or text with a unit, found {as_written(value)}")
    unit = unit_of(variable)
    if own is None:
        return float(number)
    if not own.fits(unit):
        raise QuantityError(f"by: the unit {str(own)!r} does not fit that of {variable.name}, {unit}")
    return number * own.factor / unit.factor
