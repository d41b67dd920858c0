"""Faults of signals: what a receiver is given in place of what a connection carries, and when.

A value is at fault where the instant to which it belongs lies within the fault's span: at `at` it is the first time, at
`until` no more.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from ..errors import Problems, as_written, hint
from ..fmu.model import Element, Model, NameUnknown, Variable, unit_of
from ..quantities import QuantityError, convert_difference, parse
from ..scenario.faults import Fault, sentence
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from .clock import steps_to
from .values import leaves, scalar
from .wiring import Link, Node, Wiring

Span = tuple[int, float]
"""The counts of base steps at which a fault acts first, and no more."""
LATE = "does not happen, since the run ends before: {}"


KINDS = ("cut", "bias", "freeze")
"""The kinds of faults of signals, in the order in which loop.h counts them."""


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
        """Returns how many base steps before the instant at which the receiver's step ends the value belongs to: 0 or
        1.

        What is stepped later in the same base step, or gives its values delayed, is a step behind; `places` of the
        blocks.
        """
        late = self.delayed or places[self.source.block] >= places[self.target.block]
        return int(late or parallel)


def acting(
    scenario: Scenario, blocks: Sequence[str], disturbances: Sequence[Disturbance], notes: list[str]
) -> list[Disturbance]:
    """Without those that come after the last step of every receiver, where an option shortened the run, each with a
    note.

    `blocks` in the order in which they are stepped. Raises InputError for other faults whose span has no step of a
    receiver.
    """
    places = {block: place for place, block in enumerate(blocks)}
    numbers = {d.number for d in disturbances if _is_seen(scenario, d, places)}
    unseen = {d.number: d for d in disturbances if d.number not in numbers}
    with Problems() as problems:
        for number, disturbance in unseen.items():
            fault, every = scenario.faults[number], scenario.blocks[disturbance.target.block].every
            if ("duration",) in scenario.source.options and fault.until is None:
                notes.append(LATE.format(sentence(fault)))
                continue
            until = "" if fault.until is None else f" to {fault.until:.10g} s"
            text = (
                f"no step of {disturbance.target.block} is given a value from {fault.at:.10g} s{until}; "
                f"it is stepped each {float(every * Fraction(repr(scenario.step))):.10g} s"
            )
            problems.append(scenario.error(("faults", number, "at"), text))
    return [d for d in disturbances if d.number in numbers]


def _is_seen(scenario: Scenario, disturbance: Disturbance, places: Mapping[str, int]) -> bool:
    """Returns whether the receiver is given a value of the span: at the start or by a step."""
    (first, last), behind = disturbance.span, disturbance.behind(scenario.exchange == "parallel", places)
    every, (steps, _) = scenario.blocks[disturbance.target.block].every, steps_to(scenario, scenario.duration)
    end = max(-(-(first + behind) // every), 1) * every
    at_start = first == 0 and not disturbance.delayed and last > 0
    return at_start or (end <= steps and end - behind < last)


def signal(reference: Reference, models: Mapping[str, Model]) -> tuple[str, Variable, list[int]]:
    block = reference.block
    if block not in models:
        raise NameUnknown(f"there is no block {block!r}{hint(block, models)}")
    of = ("input", "output", "parameter")
    return block, *models[block].find(block, reference.variable, reference.indices, of)


def disturbances_of(
    number: int, fault: Fault, models: Mapping[str, Model], wiring: Wiring, span: Span
) -> list[Disturbance]:
    reference = fault.target
    block, variable, positions = signal(reference, models)
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
    """Returns what each element is biased by, or given instead; in the unit of the variable."""
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
    if variable.type == "integer" and number != int(number):
        raise QuantityError(f"by: expected a whole number, found {as_written(value)}")
    unit = unit_of(variable)
    if own is None:
        return float(number)
    if not own.fits(unit):
        raise QuantityError(f"by: the unit {str(own)!r} does not fit that of {variable.name}, {unit}")
    return convert_difference(number, own, unit)
