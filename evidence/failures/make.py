"""Flies the rows in turn, so that those of a table have about as many flights at any time, and writes
docs/evidence/failures.md. Tests: tests/evidence/failures/test_rows.py."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from orchestration.campaign.flying.rows import Rows

from ..crew import complete, runs_of
from ..paper import FOLDER, ROOT
from . import page
from .kept import FILE, load, save
from .rows import ROWS, Row

RESULTS = FOLDER / "failures"
PART = 2
"""Flights of a row before the next one has its turn."""


def parts(cases: int, tables: Collection[str]) -> Iterator[tuple[Row, int]]:
    """A row of these tables and the number of flights that it has after this part, in the order of flying."""
    for most in [*range(PART, cases, PART), cases]:
        yield from ((row, most) for row in ROWS if row.table in tables)


def make(cases: int, tables: Collection[str], jobs: int) -> Path:
    """Flies what is left of so many flights of each row; then writes docs/evidence/failures.csv and the page, and
    returns it."""
    complete(jobs, (row.case(most) for row, most in parts(cases, tables)), RESULTS)
    save(ROOT / "docs" / "evidence" / FILE, [(row, found) for row in ROWS if (found := flown(row))])
    return write()


def flown(row: Row) -> Rows | None:
    """Returns what these FMUs have flown so far; None where they have not begun."""
    return runs_of(row.case(PART), RESULTS)


def write() -> Path:
    """Writes the page from docs/evidence/failures.csv."""
    target = ROOT / "docs" / "evidence" / "failures.md"
    target.write_text(page.text(load(ROOT / "docs" / "evidence" / FILE)), "utf-8")
    return target
