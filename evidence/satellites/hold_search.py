"""Searches how close to the target the tumbles of docs/evidence/satellites.md can stay (evidence/hold.py)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from ..crew import in_parts
from ..flight.bound import loop
from ..flight.schemes import Data
from ..hold import least
from .classes import ALL, DURATION, EARLY
from .kept import Flights
from .searched import Closest, Search, load_holds, save_holds, starts_of, waiting


def make(jobs: int, flights: Flights, file: Path) -> Iterator[str]:
    """Searches what the file does not have of those that are sought, and tells of each part when it has been saved."""
    found = load_holds(file)
    wanted = []
    for (name, condition), searches in waiting(flights, found).items():
        of_run = starts_of(name, condition, {search.run for search in searches})
        wanted += [(name, condition, search, of_run[search.run]) for search in searches]
    yield from in_parts(jobs, "holds", _of_tumble, wanted, found, partial(save_holds, file))


def _of_tumble(tumble: tuple[str, str, Search, Data]) -> Closest:
    name, condition, search, data = tumble
    p = loop(data).plant
    period = 2.0 * math.pi / p.orbit.mean_motion

    def largest(begin: float, end: float, repeats: bool = False) -> float:
        return math.degrees(least(p, begin, end, ALL[name].slow, repeats))

    orbits = ((EARLY, EARLY + period), (DURATION - period, DURATION)) if search.repeats else ()
    repeating = [largest(*orbit, repeats=True) for orbit in orbits] or [math.nan] * 2
    return Closest(name, condition, search.run, largest(EARLY, DURATION), *repeating)
