"""What is known of tumbles that do not settle, beside their flights: what no controller can do, and what no search
found. Tests: tests/evidence/satellites/test_page.py."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .. import files
from ..flight.cases import LOST
from .classes import ALL
from .kept import CONDITIONS, Tumble

HOLDS, BOUNDS = "satellites_hold.csv", "satellites_bound.csv"
PROVEN = 0.01
"""Of the disturbance torque: more than this must be missing, far more than what rounding may change."""


@dataclass(frozen=True)
class Searched:
    """Results of searches for a tumble, beside its flight."""

    satellite: str
    condition: str
    run: int

    @property
    def tumble(self) -> Tumble:
        """Whose it is, as the lines of the flights have it."""
        return self.satellite, self.condition, f"{self.run}"

    @property
    def place(self) -> tuple[int, int, int]:
        """Its key in its file: by satellite, condition and run."""
        return list(ALL).index(self.satellite), list(CONDITIONS).index(self.condition), self.run


@dataclass(frozen=True)
class Missing(Searched):
    """Torque along the field without which LOST is exceeded from EARLY on, as a share of the disturbance; 0: not
    proven."""

    share: float

    @property
    def excluded(self) -> bool:
        """Returns whether no controller keeps it settled."""
        return self.share > PROVEN


@dataclass(frozen=True)
class Closest(Searched):
    """Least largest errors, deg, of motions that a search found: from EARLY to the end, and of those that repeat each
    orbit.

    The motions that repeat are those of the orbit from EARLY on and of the last one. NaN: none found, or not sought.
    Decision 25 describes the search, whose code version 0.2.0 has.
    """

    to_end_deg: float
    first_orbit_deg: float
    last_orbit_deg: float

    @property
    def none_within(self) -> bool:
        """Returns whether no motion within LOST was found to the end, or none that repeats in either orbit."""
        repeating = self.first_orbit_deg, self.last_orbit_deg
        return self.to_end_deg >= LOST or all(error >= LOST for error in repeating)


def load_holds(file: Path) -> list[Closest]:
    """Returns what the search found, none without a file. Raises InputError for a file of another form."""
    return files.load_if_any(Closest, file, "git checkout the file")


def load_bounds(file: Path) -> list[Missing]:
    """Returns the bounds of a file, none without one. Raises InputError for a file of another form."""
    return files.load_if_any(Missing, file, "python -m evidence satellites --bounds")


def save_bounds(file: Path, bounds: Iterable[Missing]) -> None:
    """Writes them by satellite, condition and run."""
    files.save(Missing, file, sorted(bounds, key=lambda bound: bound.place))
