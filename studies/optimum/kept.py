"""docs/optimum.csv: a line for each tumble; docs/optimum.md and its figure are made from it."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from orchestration import InputError

FILE = "optimum.csv"


@dataclass(frozen=True)
class Line:
    """A tumble: times in s, shares of the actuators' limits, on average until T."""

    run: int
    initial_rate_deg_s: float
    bound_s: float
    best_s: float
    flown_s: float
    handed_over_s: float
    best_after_s: float
    """From the flown motion at the hand-over; NaN where the plan has it from the start."""
    start: str
    feasible: int
    tried: int
    rods_best: float
    rods_flown: float
    wheel_best: float
    wheel_flown: float
    check_angle_deg: float
    check_rate_rad_s: float
    check_gap_deg: float
    held_on: bool
    turned: bool
    """Whether the search was made again from the best with a turn more."""
    seconds: float


def load(file: Path) -> list[Line]:
    """The lines of a file that `save` wrote. Raises InputError for one of another form."""
    convert: dict[str, Callable[[str], Any]] = {
        "run": int,
        "feasible": int,
        "tried": int,
        "start": str,
        "held_on": "True".__eq__,
        "turned": "True".__eq__,
    }
    with file.open(encoding="utf-8", newline="") as text:
        rows = csv.DictReader(text)
        if missing := next((f.name for f in fields(Line) if f.name not in (rows.fieldnames or ())), None):
            raise InputError(f"{file}: expected a column {missing!r}, found none; remedy: python -m studies optimum")
        return [Line(**{f.name: convert.get(f.name, float)(row[f.name]) for f in fields(Line)}) for row in rows]


def save(file: Path, lines: Sequence[Line]) -> None:
    with file.open("w", encoding="utf-8", newline="") as text:
        out = csv.DictWriter(text, [f.name for f in fields(Line)], lineterminator="\n")
        out.writeheader()
        for line in sorted(lines, key=lambda line: line.run):
            out.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in asdict(line).items()})
