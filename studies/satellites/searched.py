"""What was searched of the tumbles of docs/satellites.md beside their flights: best holds, and bounds of what can be held."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import NamedTuple

from .. import files
from ..flight.bound import starts
from ..flight.schemes import Data
from .classes import ALL, tumbles
from .kept import CONDITIONS, LOST, Flights, Tumble

HOLDS, BOUNDS = "satellites_hold.csv", "satellites_bound.csv"
SAMPLE = 20
"""Tumbles of each satellite whose best hold is sought, settled or not."""
CLOSED = 1e-4
"""Largest gap of what counts as a hold that was found."""
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
class Best(Searched):
    """The best hold (studies/hold.py) of a tumble, over the orbit from EARLY on or over the last one.

    Its mean square was minimised, then its largest error where it is `even`. Angles in deg, wheel momentum over its limit, largest gap of
    the motion.
    """

    last: bool
    even: bool
    rms_deg: float
    largest_deg: float
    wheel_share: float
    gap: float

    @property
    def closed(self) -> bool:
        """Whether it is a motion."""
        return self.gap < CLOSED

    @property
    def swings(self) -> bool:
        """Whether it leaves LOST with an rms below it, so that another motion near it may stay within LOST."""
        return self.closed and self.rms_deg < LOST <= self.largest_deg

    @property
    def close(self) -> bool:
        """Whether it stays within LOST."""
        return self.closed and self.largest_deg < LOST


def _sought(flights: Flights, satellite: str, condition: str) -> list[int]:
    """The runs whose best hold is sought: the first SAMPLE under all errors, without a wheel under both conditions; and with a wheel
    all that are not settled."""
    sample = range(SAMPLE) if condition == "errors" or not ALL[satellite].has_wheel else ()
    return sorted({*sample, *_unsettled(flights, satellite, condition)})


def _unsettled(flights: Flights, satellite: str, condition: str) -> list[int]:
    return [int(line["run"]) for line in flights.unsettled.of(satellite, condition)]


class Search(NamedTuple):
    """Of a run: whether of its last orbit, whether its largest error is minimised."""

    run: int
    last: bool
    even: bool


def waiting(flights: Flights, holds: Iterable[Best]) -> dict[tuple[str, str], list[Search]]:
    """By satellite and condition what is sought and not among those found.

    That is the best hold of each run of `_sought`. Of those that are not settled also: in each orbit the largest error, where the best
    hold has an rms below LOST and leaves it; and the last orbit, once a hold within LOST is known of the first.
    """
    known = {(hold.satellite, hold.condition, hold.run, hold.last, hold.even): hold for hold in holds}
    left: dict[tuple[str, str], list[Search]] = {}
    for key in product(ALL, CONDITIONS):
        wanted = [Search(run, False, False) for run in _sought(flights, *key)]
        for run in _unsettled(flights, *key):
            found = {
                (last, even): known.get((*key, run, last, even)) for last in (False, True) for even in (False, True)
            }
            wanted += [
                Search(run, last, True) for last in (False, True) if (hold := found[last, False]) and hold.swings
            ]
            if any(hold and hold.close for (last, _), hold in found.items() if not last):
                wanted.append(Search(run, True, False))
        left[key] = [search for search in wanted if (*key, *search) not in known]
    return {key: searches for key, searches in left.items() if searches}


def load_holds(file: Path) -> list[Best]:
    """The best holds of a file, none without one. Raises InputError for a file of another form."""
    return files.load(Best, file, "python -m studies satellites --holds") if file.is_file() else []


def save_holds(file: Path, holds: Iterable[Best]) -> None:
    """Writes them by satellite, condition, run, orbit and kind."""
    files.save(Best, file, sorted(holds, key=lambda hold: (hold.place, hold.last, hold.even)))


def load_bounds(file: Path) -> list[Missing]:
    """The bounds of a file, none without one. Raises InputError for a file of another form."""
    return files.load(Missing, file, "python -m studies satellites --bounds") if file.is_file() else []


def save_bounds(file: Path, bounds: Iterable[Missing]) -> None:
    """Writes them by satellite, condition and run."""
    files.save(Missing, file, sorted(bounds, key=lambda bound: bound.place))


def starts_of(satellite: str, condition: str, runs: Collection[int]) -> dict[int, Data]:
    """What a search needs of these tumbles, by run."""
    data = starts(tumbles(satellite, max(runs) + 1, CONDITIONS[condition]))
    return {run: data[run] for run in runs}
