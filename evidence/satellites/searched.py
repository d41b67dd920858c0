"""What was searched of the tumbles of docs/evidence/satellites.md beside their flights: how close a motion can stay, and what none can."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from .. import files
from ..flight.bound import starts
from ..flight.cases import LOST
from ..flight.schemes import Data
from .classes import ALL, tumbles
from .kept import CONDITIONS, Flights, Tumble, not_settled, tumble_of

HOLDS, BOUNDS = "satellites_hold.csv", "satellites_bound.csv"
PROVEN = 0.01
"""Of the disturbance torque: more than this must be missing, far more than what rounding may change."""


@dataclass(frozen=True)
class Searched:
    """What was searched of a tumble beside its flight."""

    satellite: str
    condition: str
    run: int

    @property
    def tumble(self) -> Tumble:
        """Whose it is, as the lines of the flights have it."""
        return self.satellite, self.condition, f"{self.run}"

    @property
    def place(self) -> tuple[int, int, int]:
        """Where it stands in its file: by satellite, condition and run."""
        return list(ALL).index(self.satellite), list(CONDITIONS).index(self.condition), self.run


@dataclass(frozen=True)
class Missing(Searched):
    """Torque along the field, as a share of the disturbance, without which LOST is exceeded from EARLY to the end; 0: not proven."""

    share: float

    @property
    def excluded(self) -> bool:
        """Whether no controller keeps it settled."""
        return self.share > PROVEN


@dataclass(frozen=True)
class Closest(Searched):
    """The least largest errors that were found (evidence/hold.py), deg: of motions from EARLY to the end, and of motions that repeat, in
    the orbit from EARLY on and in the last one. NaN: none found, or not sought."""

    to_end_deg: float
    first_orbit_deg: float
    last_orbit_deg: float

    @property
    def repeating_deg(self) -> tuple[float, float]:
        """Of the motions that repeat."""
        return self.first_orbit_deg, self.last_orbit_deg

    @property
    def close(self) -> bool:
        """Whether a motion to the end is known that stays within LOST."""
        return self.to_end_deg < LOST


class Search(NamedTuple):
    """Of a run: whether motions that repeat are sought, too."""

    run: int
    repeats: bool


def waiting(flights: Flights, holds: Iterable[Closest]) -> dict[tuple[str, str], list[Search]]:
    """By satellite and condition what is sought and not among those found.

    That is each flight that is not settled, or lost again; with a wheel, motions that repeat, too. And, to compare, all nominal flights
    without a wheel.
    """
    known, left_again = {hold.tumble for hold in holds}, set(not_settled(flights))
    left: dict[tuple[str, str], list[Search]] = {}
    for line in flights.lines:
        tumble = satellite, condition, run = tumble_of(line)
        wheel = ALL[satellite].has_wheel
        to_compare = not wheel and condition == "nominal"
        if tumble not in known and (to_compare or tumble in left_again):
            left.setdefault((satellite, condition), []).append(Search(int(run), wheel and tumble in left_again))
    return left


def load_holds(file: Path) -> list[Closest]:
    """The least largest errors of a file, none without one. Raises InputError for a file of another form."""
    return files.load_if_any(Closest, file, "python -m evidence satellites --holds")


def save_holds(file: Path, holds: Iterable[Closest]) -> None:
    """Writes them by satellite, condition and run."""
    files.save(Closest, file, sorted(holds, key=lambda hold: hold.place))


def load_bounds(file: Path) -> list[Missing]:
    """The bounds of a file, none without one. Raises InputError for a file of another form."""
    return files.load_if_any(Missing, file, "python -m evidence satellites --bounds")


def save_bounds(file: Path, bounds: Iterable[Missing]) -> None:
    """Writes them by satellite, condition and run."""
    files.save(Missing, file, sorted(bounds, key=lambda bound: bound.place))


def starts_of(satellite: str, condition: str, runs: Collection[int]) -> dict[int, Data]:
    """What a search needs of these tumbles, by run."""
    data = starts(tumbles(satellite, max(runs) + 1, CONDITIONS[condition]))
    return {run: data[run] for run in runs}
