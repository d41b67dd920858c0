"""Flies the satellites in turn, so that each has about as many flights at any time, and writes
docs/evidence/satellites.md. Tests: tests/evidence/satellites/test_classes.py."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from orchestration.campaign.flying.rows import Rows

from ..crew import complete, runs_of
from ..paper import FOLDER, ROOT
from ..plots import save as save_figures
from . import page
from .classes import ALL, tumbles
from .kept import CONDITIONS, FILE, load, save
from .searched import BOUNDS, HOLDS, load_bounds, load_holds

RESULTS = FOLDER / "satellites"
PART = 10
"""Flights of a satellite before the next one has its turn."""


def parts(cases: int) -> Iterator[tuple[str, str, int]]:
    """Satellite, condition and the number of flights that it has after this part, in the order of flying."""
    for most in [*range(PART, cases, PART), cases]:
        for satellite in ALL:
            for condition in CONDITIONS:
                yield satellite, condition, most


def make(cases: int, jobs: int) -> Path:
    """Flies what is left of so many tumbles each; then writes docs/evidence/satellites.csv and the page, and returns
    it."""
    complete(jobs, (tumbles(name, most, CONDITIONS[how]).case for name, how, most in parts(cases)), RESULTS)
    save(ROOT / "docs" / "evidence" / FILE, {(s, c): found for s in ALL for c in CONDITIONS if (found := flown(s, c))})
    return write()


def flown(satellite: str, condition: str) -> Rows | None:
    """Returns what these FMUs have flown so far; None where they have not begun."""
    return runs_of(tumbles(satellite, PART, CONDITIONS[condition]).case, RESULTS)


def write() -> Path:
    """Writes the page from the files in docs/."""
    docs = ROOT / "docs" / "evidence"
    target = docs / "satellites.md"
    found = load_holds(docs / HOLDS), load_bounds(docs / BOUNDS)
    flights = load(docs / FILE)
    save_figures({"satellites": page.figure(flights)}, docs.parent / "figures")
    target.write_text(page.text(flights, *found), "utf-8")
    return target
