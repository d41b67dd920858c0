"""docs/evidence/health.csv: a line for each flight; the tables of docs/evidence/estimation.md are made from it.
Tests: tests/evidence/health/test_page.py."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from orchestration.campaign.flying.rows import Rows

from .. import files
from ..paper import ROOT
from .allowed import least
from .rows import Row, named
from .verdict import LOST, SAFE_RATE

FILE = ROOT / "docs" / "evidence" / "health.csv"
REMEDY = "python -m evidence health"
_DRAWN = ("node_longitude", "argument_of_latitude", *(f"disturbance_torque_B[{i}]" for i in (1, 2, 3)))


@dataclass(frozen=True)
class Flight:
    """One flight: angles in deg, rates in deg/s, times in s from the failure on, infinite for never.

    `held_deg`: the largest error while the sensors that are left give an attitude; `rate_deg_s`: the largest rate while
    they do not; `spin_deg_s`, `largest_deg`: the largest of all. `least_deg`: of any hold by the actuators that are
    left.
    """

    row: str
    run: int
    least_deg: float
    held_deg: float
    rate_deg_s: float
    spin_deg_s: float
    largest_deg: float
    last_deg: float
    named_s: float
    others: str
    """Parts that were named and are not this row's, or before the failure."""
    remark: str

    @property
    def outcome(self) -> str:
        """`held`; `safe` where sensors or actuators that are left allow no hold for a while, as verdict.py and
        allowed.py say, and rates stay small and the part is named; else `lost`."""
        if self.remark:
            return "lost"
        if self.largest_deg <= LOST:
            return "held"
        if self.least_deg > LOST:
            return "safe" if self.spin_deg_s <= SAFE_RATE and math.isfinite(self.named_s) else "lost"
        return "safe" if self.held_deg <= LOST and self.rate_deg_s <= SAFE_RATE else "lost"


def load() -> list[Flight]:
    """The flights. Raises InputError for a file of another form."""
    return files.load_if_any(Flight, FILE, REMEDY)


def save(flown: Sequence[tuple[Row, Rows]]) -> list[Flight]:
    """Writes every flight of the datasets in the place of those of their rows, and returns all that are kept."""
    kept = load()
    known, anew = {(f.row, f.run): f.least_deg for f in kept}, {row.name for row, _ in flown}
    flights = [flight for row, rows in flown for flight in _flights(row, rows, known)]
    files.save(Flight, FILE, [f for f in kept if f.row not in anew] + flights)
    return load()


def _flights(row: Row, rows: Rows, known: Mapping[tuple[str, int], float]) -> Iterator[Flight]:
    names = [metric["name"] for metric in rows.manifest["metrics"]] + [f"plant.{name}" for name in _DRAWN]
    columns, reasons = {name: rows.numbers(name) for name in names}, rows.reasons()
    for i, index in enumerate(rows.index.tolist()):
        values = {name: float(column[i]) for name, column in columns.items()}
        bound = known.get((row.name, index))
        remark = f"the run failed: {reasons[index]}" if rows.failed[i] else ""
        yield flight(row, index, values, least(row, values) if bound is None else bound, remark)


def flight(row: Row, run: int, m: Mapping[str, float], bound: float, remark: str = "") -> Flight:
    """A flight of a row with these metrics, not a number where the run failed: then nothing was held."""
    values = {name: 180.0 if math.isnan(m[name]) else m[name] for name in ("held", "rate", "spin", "largest", "last")}
    others = [part for part in named() if part not in row.parts and math.isfinite(m[part])]
    times = [m[part] - row.at for part in row.parts if math.isfinite(m[part])]
    return Flight(
        row.name,
        run,
        bound,
        values["held"],
        values["rate"],
        values["spin"],
        values["largest"],
        values["last"],
        min(times, default=math.inf),
        " ".join(others),
        remark,
    )
