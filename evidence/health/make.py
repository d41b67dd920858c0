"""Flies rows in turn, some flights of each before the next, and shows what became of them.
Tests: tests/evidence/health/test_rows.py."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestration.campaign.flying.rows import Rows

from ..crew import crew, runs_of
from ..markdown import degrees, table
from ..paper import FOLDER
from .rows import LOST, ROWS, TUMBLE, Row, named

RESULTS = FOLDER / "health"
HEAD = "what fails|flights|lost|named|median|another named|largest error from ten minutes on|from half an hour on"


def make(flights: int, only: Sequence[str], jobs: int) -> str:
    """Flies what is left of so many flights of each row whose name has one of the texts; returns a table of all."""
    with crew(jobs) as hands:
        for row in ROWS:
            if not only or any(text in row.name for text in only):
                hands.fly(row.case(flights), RESULTS)
    return summary([(row, found) for row in ROWS if (found := runs_of(row.case(1), RESULTS)) is not None])


def summary(flown: Sequence[tuple[Row, Rows]]) -> str:
    """A Markdown table with a line for each row. Lost: beyond LOST ten minutes after a failure in the hold or later,
    half an hour after one in the tumble."""
    return table(
        [line(row, {name: rows.numbers(name) for name in ("largest", "late", *named())}) for row, rows in flown], HEAD
    )


def line(row: Row, metrics: dict[str, np.ndarray]) -> list[str]:
    """The cells of a row: times count from the failure on; a failed run is lost."""
    largest, late = (np.nan_to_num(metrics[name], nan=180.0) for name in ("largest", "late"))
    judged = late if row.at == TUMBLE else largest
    count = len(largest)
    others = np.array([metrics[part] for part in named() if part != row.part])
    at = metrics[row.part] - row.at if row.part else np.full(count, np.inf)
    found = np.isfinite(at)
    return [
        row.name,
        str(count),
        str(int((judged > LOST).sum())),
        f"{int(found.sum())} of {count}" if row.part else "",
        f"{np.median(at[found]):.0f} s" if found.any() else "",
        str(int(np.isfinite(others).any(axis=0).sum())),
        degrees(float(np.median(largest))),
        degrees(float(np.median(late))),
    ]
