"""The timeline of a scenario held against its blocks: values at given times, and nothing that contradicts itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from ..errors import Problems
from ..fmu.model import Model
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..scenario.timeline import TimelineEntry, sentence
from .disturbances import LATE
from .faults import Setting, count_of, is_unseen, setting
from .wiring import Node, Wiring


def settings(scenario: Scenario, models: Mapping[str, Model], wiring: Wiring) -> tuple[list[Setting], list[str]]:
    """The values of the timeline, and notes. Raises InputError with everything that is wrong."""
    found: list[Setting] = []
    notes: list[str] = []
    entries = scenario.timeline
    taken: dict[tuple[int, Node], str] = {}
    named: dict[int, str] = {}
    with Problems() as problems:
        for number, entry in enumerate(entries):
            key: Key = ("timeline", number)
            if number and entry.at < (before := entries[number - 1].at):
                text = f"{entry.at:.10g} s lies before the entry above, {before:.10g} s"
                problems.append(scenario.error((*key, "at"), text, expected="entries in the order of time"))
            if _is_late(scenario, key, entry, problems, notes):
                continue
            first = count_of(scenario, (*key, "at"), entry.at, notes)
            if entry.phase is not None and (other := named.setdefault(first, entry.phase)) != entry.phase:
                text = f"{entry.phase!r} begins at the same time as {other!r}, {entry.at:.10g} s"
                problems.append(scenario.error((*key, "phase"), text, expected="one phase at a time"))
            for name, value in entry.set.items():
                place: Key = (*key, "set", name)
                late = sentence(entry.model_copy(update={"phase": None, "set": {name: value}}))
                with problems.gathered():
                    with scenario.naming(place):
                        made = replace(setting(name, value, models, wiring, (first, math.inf)), of_fault=False)
                    if is_unseen(scenario, place, entry.at, made, late, notes):
                        continue
                    nodes = [(first, Node(made.block, element)) for element, _ in made.values]
                    if twice := [node for node in nodes if node in taken]:
                        text = f"is set at {entry.at:.10g} s by {taken[twice[0]]}, too"
                        problems.append(scenario.error(place, text, expected="one value at a time"))
                    taken.update(dict.fromkeys(nodes, f"timeline[{number + 1}].set.{name}"))
                    found.append(made)
    if scenario.phases is not None and any(entry.phase is not None for entry in entries):
        text = "its phases are not drawn, since 'phases' is given; expectations may name both"
        notes.append(scenario.note(("timeline",), text))
    return found, notes


def _is_late(scenario: Scenario, key: Key, entry: TimelineEntry, problems: Problems, notes: list[str]) -> bool:
    """Returns whether the run is over before a step could see the entry: an error, or a note where an option shortened
    the run.
    """
    if entry.at < scenario.duration:
        return False
    if ("duration",) in scenario.source.options:
        notes.append(LATE.format(sentence(entry)))
    else:
        message = f"{entry.at:.10g} s lies at or after the end of the run, {scenario.duration:.10g} s; no step sees it"
        problems.append(scenario.error((*key, "at"), message))
    return True
