"""The faults of a scenario, which set, freeze, bias or cut.

A signal's fault (disturbances.py) acts on the connection, on what a receiver is given; the block that gives the signal
is sound, and so is what is recorded of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..errors import InputError, Problems
from ..fmu.model import Element, Model
from ..quantities import QuantityError
from ..scenario.faults import Fault, sentence
from ..scenario.references import Name, Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .clock import steps_to
from .disturbances import LATE, Disturbance, Span, disturbances_of, signal
from .values import Scalar, values_of
from .wiring import Node, Wiring


@dataclass(frozen=True, eq=False)
class Setting:
    """Values that a block is given at an instant. Those of a fault stand over those of the timeline while its span
    lasts.

    Two with the same entries are still two, each of which begins and ends.
    """

    block: str
    values: tuple[tuple[Element, Scalar], ...]
    span: Span
    name: str
    of_fault: bool = True


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
    with Problems() as problems:
        for number, fault in enumerate(scenario.faults):
            key: Key = ("faults", number)
            with problems.gathered():
                span = _span(scenario, key, fault, faults.notes)
                if span is None:
                    continue
                with scenario.naming((*key, fault.kind)):
                    if fault.set is None:
                        faults.disturbances += disturbances_of(number, fault, models, wiring, span)
                        continue
                    made = setting(fault.set.target, fault.set.value, models, wiring, span)
                if not is_unseen(scenario, (*key, "at"), fault.at, made, sentence(fault), faults.notes):
                    faults.settings.append(made)
    return faults


def _span(scenario: Scenario, key: Key, fault: Fault, notes: list[str]) -> Span | None:
    """None for a fault that begins after the end of a run that was shortened by an option."""
    if fault.at > scenario.duration:
        if ("duration",) in scenario.source.options:
            notes.append(LATE.format(sentence(fault)))
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
        notes.append(scenario.note(key, message))
    return count


def is_unseen(scenario: Scenario, key: Key, time: float, made: Setting, late: str, notes: list[str]) -> bool:
    """Returns whether the last step of its block has begun before: a note of what is `late` where an option shortened
    the run.

    Raises InputError where none did.
    """
    every, (steps, _) = scenario.blocks[made.block].every, steps_to(scenario, scenario.duration)
    last = (steps // every - 1) * every
    if made.span[0] <= last:
        return False
    if ("duration",) in scenario.source.options:
        notes.append(LATE.format(late))
        return True
    begun = float(last * Fraction(repr(scenario.step)))
    message = (
        f"{time:.10g} s lies after the beginning of the last step of {made.block}, {begun:.10g} s; no step sees it"
    )
    raise InputError(scenario.error(key, message))


def setting(name: Reference, value: Any, models: Mapping[str, Model], wiring: Wiring, span: Span) -> Setting:
    """Values for an input that is not connected, or a tunable parameter. Raises QuantityError and NameUnknown."""
    block, variable, positions = signal(name, models)
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
