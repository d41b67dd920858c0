"""docs/evidence/optimum.csv: a line for each tumble; docs/evidence/optimum.md and its figure are made from it.
Tests: tests/evidence/optimum/test_page.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import files

FILE, OTHERS = "optimum.csv", "optimum_others.csv"


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
    """Starts of the whole motion."""
    rods_best: float
    rods_flown: float
    wheel_best: float
    wheel_flown: float
    check_angle_deg: float
    check_rate_rad_s: float
    check_gap_deg: float
    held_on: bool
    seconds: float


@dataclass(frozen=True)
class Other:
    """A motion of another search that the plant confirmed, open loop; of it the time alone is known."""

    run: int
    best_s: float


def others(folder: Path) -> dict[int, float]:
    """By run: the times in s that another search found, in the folder of FILE."""
    return {one.run: one.best_s for one in files.load_if_any(Other, folder / OTHERS, "git checkout")}


def load(file: Path) -> list[Line]:
    """The lines of a file that `save` wrote. Raises InputError for one of another form."""
    return files.load(Line, file, "python -m evidence optimum")


def save(file: Path, found: Sequence[Line]) -> None:
    files.save(Line, file, sorted(found, key=lambda line: line.run))
