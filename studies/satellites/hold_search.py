"""Searches how close to the target the tumbles of docs/satellites.md can stay (studies/hold.py)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from ..crew import crew
from ..flight.bound import loop
from ..flight.schemes import Data
from ..hold import least
from .classes import ALL, DURATION, EARLY
from .kept import Flights
from .searched import Closest, Search, load_bounds, load_holds, save_holds, starts_of, waiting

AT_ONCE = 8
"""Tumbles between two writings of the file."""


def make(jobs: int, flights: Flights, bounds: Path, file: Path) -> Iterator[str]:
    """Searches what the file does not have of those that are sought, by the file of what is excluded, and tells of each part saved."""
    found = load_holds(file)
    wanted = []
    for (name, condition), searches in waiting(flights, found, load_bounds(bounds)).items():
        of_run = starts_of(name, condition, {search.run for search in searches})
        wanted += [(name, condition, search, of_run[search.run]) for search in searches]
    with crew(jobs) as hands:
        for i in range(0, len(wanted), AT_ONCE):
            found += hands.each("holds", _of_tumble, wanted[i : i + AT_ONCE])
            save_holds(file, found)
            yield f"{min(i + AT_ONCE, len(wanted))} of {len(wanted)} tumbles"
    save_holds(file, found)


def _of_tumble(tumble: tuple[str, str, Search, Data]) -> Closest:
    name, condition, search, data = tumble
    p = loop(data).plant
    period = 2.0 * math.pi / p.orbit.mean_motion

    def largest(begin: float, end: float, repeats: bool = False) -> float:
        found = least(p, begin, end, ALL[name].slow, repeats)
        return math.nan if found is None else math.degrees(found)

    orbits = ((EARLY, EARLY + period), (DURATION - period, DURATION)) if search.repeats else ()
    repeating = [largest(*orbit, repeats=True) for orbit in orbits] or [math.nan] * 2
    return Closest(name, condition, search.run, largest(EARLY, DURATION), *repeating)
