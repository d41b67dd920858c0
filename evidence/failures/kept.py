"""docs/evidence/failures.csv: a line for each flight; docs/evidence/failures.md is made from it.
Tests: tests/evidence/failures/test_rows.py."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from orchestration.campaign.flying.rows import Rows

from .. import files
from ..flight.cases import ALARMS
from ..flight.cases import HOLD as LAST
from .rows import Row

FILE = "failures.csv"


@dataclass(frozen=True)
class Flight:
    """One flight: times in s, infinite for never; all but `settled_s`, which counts from the start, from the failure
    on.

    `given_up_s`: since when less than `rows.ASKED` is asked of the wheel for good.
    """

    row: str
    run: int
    found_s: float
    settled_s: float
    within_15_s: float
    within_5_s: float
    given_up_s: float
    hold_rms_deg: float
    hold_max_deg: float
    others: str
    """Failures that were told and are not this row's: another rod, another part, or before the failure."""
    remark: str


def load(file: Path) -> list[Flight]:
    """The flights of a file that `save` wrote. Raises InputError for one of another form."""
    return files.load(Flight, file, "python -m evidence failures")


def save(file: Path, flown: Sequence[tuple[Row, Rows]]) -> None:
    """Writes every flight of the datasets."""
    files.save(Flight, file, (flight for row, rows in flown for flight in _flights(row, rows)))


def _flights(row: Row, rows: Rows) -> Iterator[Flight]:
    columns = {metric["name"]: rows.numbers(metric["name"]) for metric in rows.manifest["metrics"]}
    reasons = rows.reasons()
    for i, index in enumerate(rows.index.tolist()):
        remark = f"the run failed: {reasons[index]}" if rows.failed[i] else ""
        yield flight(row, index, {name: float(values[i]) for name, values in columns.items()}, remark)


def flight(row: Row, run: int, m: Mapping[str, float], remark: str = "") -> Flight:
    """A flight of a row with these metrics, not a number where the run failed.

    Settled counts from the start, and for at least LAST up to the end of the flight.
    """
    flag = f"rod_{row.rod}" if row.rod else row.flag
    settled = max(m["angle"], m["rate"])
    told = {name: m[name] for name in (*ALARMS, "rod_1", "rod_2", "rod_3") if math.isfinite(m[name])}
    expected = {flag, row.flag}
    others = [name for name, time in told.items() if name not in expected or time < row.at]
    return Flight(
        row.name,
        run,
        found_s=_from(row, m[flag]),
        settled_s=settled if settled <= row.end - LAST else math.inf,
        within_15_s=_from(row, m["within_15"]),
        within_5_s=_from(row, m["within_5"]),
        given_up_s=_from(row, m["given_up"]),
        hold_rms_deg=math.degrees(m["hold_rms"]),
        hold_max_deg=math.degrees(m["hold_max"]),
        others=" ".join(others),
        remark=remark,
    )


def _from(row: Row, time: float) -> float:
    """From the failure on; infinite where it never was, or before it."""
    return time - row.at if time >= row.at else math.inf
