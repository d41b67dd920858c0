"""Faults and timeline as they act: at steps of the run, with the units of what they give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ..fmu.model import Model
from ..quantities import ONE
from ..scenario import timeline
from ..scenario.faults import Fault, sentence
from ..scenario.scenario import Scenario
from .clock import steps_to


def faults(scenario: Scenario, end: float = math.inf) -> list[Fault]:
    """The scenario's faults with the times at which they act, s: the first step at `at` or after it, and at `until`.

    Without those from `end`, s, on, and those after the run, which an option may have shortened.
    """
    return [
        fault.model_copy(
            update={
                "at": _in_force(scenario, fault.at),
                "until": None if fault.until is None else _in_force(scenario, fault.until),
            }
        )
        for fault in scenario.faults
        if fault.at < min(end, scenario.duration)
    ]


def fault_sentences(scenario: Scenario, models: Mapping[str, Model], end: float = math.inf) -> list[str]:
    """Returns what goes wrong before `end`, s, and when, in words."""
    return [sentence(fault, _unit(fault, models)) for fault in faults(scenario, end)]


def timeline_sentences(scenario: Scenario, end: float = math.inf) -> list[str]:
    """Returns what the timeline does before `end`, s, and when, in words."""
    return [
        timeline.sentence(entry.model_copy(update={"at": _in_force(scenario, entry.at)}))
        for entry in scenario.timeline
        if entry.at < min(end, scenario.duration)
    ]


def _in_force(scenario: Scenario, time: float) -> float:
    count, exact = steps_to(scenario, time)
    return time if exact else float(count * Fraction(repr(scenario.step)))


def _unit(fault: Fault, models: Mapping[str, Model]) -> str:
    """The unit of a fault's bare numbers; "" for values that have units of their own, or none."""
    value = fault.set.value if fault.set is not None else fault.by if fault.bias is not None else fault.to
    target = fault.target
    if not _bare(value):
        return ""
    variable, positions = models[target.block].find(target.block, target.variable, target.indices)
    unit = variable.at(positions).unit or ONE
    return "" if unit.name in ("", "1") else str(unit)


def _bare(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return bool(value) and all(map(_bare, value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)
