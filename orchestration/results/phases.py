"""The phases of a run, to be drawn: by name, from when to when."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..scenario.timeline import windows
from ..system.phases import phases
from .data import RunData


class Band(NamedTuple):
    """A phase from `begin` to `end`, s; `colour` is its place in the palette, the same for the same name."""

    name: str
    begin: float
    end: float
    colour: int


def bands(result: RunData) -> list[Band]:
    """The bands of a run in the order of time: of `phases` where the scenario has it, else of the timeline."""
    if not len(result.time):
        return []
    scenario, last = result.scenario, float(result.time[-1])
    if scenario.phases is None:
        named = windows(scenario.timeline)
        places = {name: i for i, name in enumerate(dict.fromkeys(name for name, _, _ in named))}
        spans = [(name, begin, last if end is None else min(end, last)) for name, begin, end in named]
        return [Band(name, begin, end, places[name]) for name, begin, end in spans if begin < end]
    known = phases(scenario, result.models)
    found = []
    for place, name in enumerate(scenario.phases.names):
        signal = known[name].signal
        if signal is None or signal not in result.columns:
            continue
        inside = (result.column(signal) == known[name].value).astype(np.int8)
        edges = np.diff(inside, prepend=0, append=0)
        begins, ends = np.flatnonzero(edges > 0), np.minimum(np.flatnonzero(edges < 0), len(inside) - 1)
        found += [
            Band(name, float(result.time[a]), float(result.time[b]), place) for a, b in zip(begins, ends, strict=True)
        ]
    return sorted((band for band in found if band.begin < band.end), key=lambda band: band.begin)
