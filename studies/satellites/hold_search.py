"""Searches the best holds of docs/satellites.md: of an orbit from EARLY on, and for some of the last orbit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from ..crew import crew
from ..flight.bound import loop
from ..flight.schemes import Data
from ..hold import best, period
from .classes import DURATION, EARLY
from .kept import Flights
from .searched import Best, Search, load_holds, save_holds, starts_of, waiting

AT_ONCE = 8
"""Tumbles between two writings of the file."""


def make(jobs: int, flights: Flights, file: Path) -> Iterator[str]:
    """Searches what the file does not have of those that are sought, and tells of each part when it has been saved."""
    found = load_holds(file)
    with crew(jobs) as hands:
        while wanted := _wanted(flights, found):  # once more for what is sought after these
            for i in range(0, len(wanted), AT_ONCE):
                found += hands.each("best holds", _of_tumble, wanted[i : i + AT_ONCE])
                save_holds(file, found)
                yield f"{min(i + AT_ONCE, len(wanted))} of {len(wanted)} tumbles"


def _wanted(flights: Flights, found: list[Best]) -> list[tuple[str, str, Search, Data]]:
    wanted = []
    for (name, condition), searches in waiting(flights, found).items():
        of_run = starts_of(name, condition, {search.run for search in searches})
        wanted += [(name, condition, search, of_run[search.run]) for search in searches]
    return wanted


def _of_tumble(tumble: tuple[str, str, Search, Data]) -> Best:
    name, condition, search, data = tumble
    p = loop(data).plant
    hold = best(p, DURATION - period(p) if search.last else EARLY, search.even)
    return Best(name, condition, *search, math.degrees(hold.rms), math.degrees(hold.largest), hold.wheel, hold.gap)
