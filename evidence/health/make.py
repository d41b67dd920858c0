"""Flies rows in turn, so that all have about as many flights at any time, and writes docs/evidence/health.csv and
docs/evidence/estimation.md. Tests: tests/evidence/health/test_rows.py."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from orchestration.campaign.flying.rows import Rows

from ..crew import complete, runs_of
from ..paper import FOLDER, ROOT
from . import page
from .kept import load, save
from .rows import ROWS, Row

RESULTS = FOLDER / "health"


def parts(flights: int, only: Sequence[str]) -> Iterator[tuple[Row, int]]:
    """Rows whose name has one of the texts, or all, and the number of flights after this part; those by rods alone,
    which take minutes, come last."""
    wanted = [row for row in ROWS if not only or any(text in row.name for text in only)]
    slow = [row for row in wanted if row.actuators and not row.actuators.wheel]
    quick = [row for row in wanted if row not in slow]
    for rows in (quick, slow):
        yield from ((row, most) for most in range(1, flights + 1) for row in rows)


def make(flights: int, only: Sequence[str], jobs: int) -> Path:
    """Flies what is left of so many flights of each row; then writes file and page, and returns the page."""
    complete(jobs, (row.case(most) for row, most in parts(flights, only)), RESULTS)
    save([(row, found) for row in ROWS if (found := flown(row))])
    return write()


def flown(row: Row) -> Rows | None:
    """Returns what these FMUs have flown so far; None where they have not begun."""
    return runs_of(row.case(1), RESULTS)


def write() -> Path:
    """Writes the page from docs/evidence/health.csv."""
    target = ROOT / "docs" / "evidence" / "estimation.md"
    target.write_text(page.text(load()), "utf-8")
    return target
