"""The phases of a run, to be drawn: by name, from when to when.

Tests: tests/orchestration/test_timeline.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..scenario.timeline import windows
from ..system.phases import phases
from ..system.wiring import Node
from .curves import spans
from .data import RunData


class Band(NamedTuple):
    """A phase lasts from `begin` to `end`, s; `colour` is its place in the palette, the same for the same name."""

    name: str
    begin: float
    end: float
    colour: int


class Condition(NamedTuple):
    """A phase lasts while an element has a value; `colour` is as of a band."""

    name: str
    signal: Node
    value: float
    colour: int


def conditions(result: RunData) -> list[Condition]:
    """Returns the named values of the scenario's `phases`, where their signal was recorded."""
    scenario = result.scenario
    if scenario.phases is None:
        return []
    known = phases(scenario, result.models)
    named = [(name, known[name].signal, known[name].value) for name in scenario.phases.names]
    return [Condition(name, node, value, i) for i, (name, node, value) in enumerate(named) if node in result.columns]


def bands(result: RunData) -> list[Band]:
    """Returns the bands of a run in the order of time: of `phases` where the scenario has it, else of the timeline."""
    if not len(result.time):
        return []
    scenario, last = result.scenario, float(result.time[-1])
    if scenario.phases is not None:
        return lasting(result, conditions(result))
    named = windows(scenario.timeline)
    places = {name: i for i, name in enumerate(dict.fromkeys(name for name, _, _ in named))}
    found = [Band(name, begin, last if end is None else min(end, last), places[name]) for name, begin, end in named]
    return [band for band in found if band.begin < band.end]


def lasting(result: RunData, wanted: Sequence[Condition]) -> list[Band]:
    """Returns when these conditions hold, in the order of time."""
    found = [
        Band(name, begin, end, colour)
        for name, signal, value, colour in wanted
        for begin, end in spans(result.time, result.column(signal) == value)
    ]
    return sorted((band for band in found if band.begin < band.end), key=lambda band: band.begin)
