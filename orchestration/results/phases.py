"""The phases of a run, to be drawn: by name, from when to when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..scenario.timeline import windows
from ..system.phases import phases
from ..system.wiring import Node
from .data import RunData


class Band(NamedTuple):
    """A phase from `begin` to `end`, s; `colour` is its place in the palette, the same for the same name."""

    name: str
    begin: float
    end: float
    colour: int


class Condition(NamedTuple):
    """A phase while an element has a value; `colour` as of a band."""

    name: str
    signal: Node
    value: float
    colour: int


def conditions(result: RunData) -> list[Condition]:
    """The named values of the scenario's `phases`, where their signal was recorded."""
    scenario = result.scenario
    if scenario.phases is None:
        return []
    known = phases(scenario, result.models)
    named = [(name, known[name].signal, known[name].value) for name in scenario.phases.names]
    return [Condition(name, node, value, i) for i, (name, node, value) in enumerate(named) if node in result.columns]


def bands(result: RunData) -> list[Band]:
    """The bands of a run in the order of time: of `phases` where the scenario has it, else of the timeline."""
    if not len(result.time):
        return []
    scenario, last = result.scenario, float(result.time[-1])
    if scenario.phases is not None:
        return lasting(result, conditions(result))
    named = windows(scenario.timeline)
    places = {name: i for i, name in enumerate(dict.fromkeys(name for name, _, _ in named))}
    spans = [(name, begin, last if end is None else min(end, last)) for name, begin, end in named]
    return [Band(name, begin, end, places[name]) for name, begin, end in spans if begin < end]


def lasting(result: RunData, wanted: Sequence[Condition]) -> list[Band]:
    """When these conditions hold, in the order of time."""
    found = []
    for name, signal, value, colour in wanted:
        inside = (result.column(signal) == value).astype(np.int8)
        edges = np.diff(inside, prepend=0, append=0)
        begins, ends = np.flatnonzero(edges > 0), np.minimum(np.flatnonzero(edges < 0), len(inside) - 1)
        found += [
            Band(name, float(result.time[a]), float(result.time[b]), colour) for a, b in zip(begins, ends, strict=True)
        ]
    return sorted((band for band in found if band.begin < band.end), key=lambda band: band.begin)
