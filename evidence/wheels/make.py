"""Flies the satellites in turn and writes docs/evidence/wheels.md. Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

from pathlib import Path

from .. import files
from ..crew import crew, runs_of
from ..paper import FOLDER, ROOT
from ..plots import save as save_figures
from . import page
from .bound import of_draws
from .cases import all_flights
from .kept import FILE, REMEDY, Flown, flown_of

RESULTS = FOLDER / "wheels"


def make(cases: int, jobs: int) -> Path:
    """Flies what is left of so many tumbles of each; then writes docs/evidence/wheels.csv and the page, and returns
    it."""
    with crew(jobs) as hands:
        for flights in all_flights():
            rows = runs_of(flights.case(cases), RESULTS)
            if rows is None or len(rows) < cases:
                hands.fly(flights.case(cases), RESULTS)
    return keep()


def keep() -> Path:
    """Writes docs/evidence/wheels.csv from the flights that there are, and the page."""
    found: list[Flown] = []
    for flights in all_flights():
        rows = runs_of(flights.case(2), RESULTS)
        if rows is not None:
            bounds = of_draws(flights, len(rows)) if flights.condition == "nominal" else []
            found += flown_of(flights, rows, bounds)
    files.save(Flown, ROOT / "docs" / "evidence" / FILE, found, 4)
    return write()


def write() -> Path:
    """Writes the page from docs/evidence/wheels.csv."""
    docs = ROOT / "docs" / "evidence"
    found = files.load(Flown, docs / FILE, REMEDY)
    save_figures({"wheels": page.figure(found)}, docs.parent / "figures")
    (docs / "wheels.md").write_text(page.text(found), "utf-8")
    return docs / "wheels.md"
