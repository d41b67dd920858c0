"""Which tumbles of docs/satellites.md no controller can keep settled: the balance of the momentum along the field (studies/hold_bound.py)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import files
from ..crew import crew
from ..flight.bound import loop, starts
from ..flight.schemes import Data
from ..hold_bound import missing
from .classes import ALL, DURATION, EARLY, tumbles
from .kept import CONDITIONS, LOST, Flights, Tumble, settling_times, tumble_of

FILE = "satellites_bound.csv"
PROVEN = 0.01
"""Of the disturbance torque: more than this must be missing, far more than what rounding may change."""
AT_ONCE = 16
"""Tumbles between two writings of the file."""


@dataclass(frozen=True)
class Missing:
    """Torque along the field, as a share of the disturbance, without which LOST is exceeded from EARLY to the end; 0: not proven."""

    satellite: str
    condition: str
    run: int
    share: float

    @property
    def tumble(self) -> Tumble:
        """Whose it is, as the lines of the flights have it."""
        return self.satellite, self.condition, f"{self.run}"

    @property
    def excluded(self) -> bool:
        """Whether no controller keeps it settled."""
        return self.share > PROVEN


def load(file: Path) -> list[Missing]:
    """Those of a file, none without one. Raises InputError for a file of another form."""
    return files.load(Missing, file, "python -m studies satellites --bounds") if file.is_file() else []


def not_settled(flights: Flights) -> list[Tumble]:
    """Those that do not settle, or are lost again."""
    never = np.isinf(settling_times(flights.lines))
    return [tumble_of(line) for line, left in zip(flights.lines, never, strict=True) if left]


def make(jobs: int, flights: Flights, file: Path) -> Iterator[str]:
    """Finds what the file does not have of those that are not settled, and tells of each part when it has been saved."""
    wanted = not_settled(flights)
    found = {each.tumble: each for each in load(file)}
    left = [tumble for tumble in wanted if tumble not in found]
    with crew(jobs) as hands:
        for i in range(0, len(left), AT_ONCE):
            part = [(tumble, _start(tumble)) for tumble in left[i : i + AT_ONCE]]
            found |= {each.tumble: each for each in hands.each("bounds of holds", _of_tumble, part)}
            files.save(Missing, file, _sorted(found.values()))
            yield f"{min(i + AT_ONCE, len(left))} of {len(left)} tumbles"
    files.save(Missing, file, _sorted(each for each in found.values() if each.tumble in set(wanted)))


def _start(tumble: Tumble) -> Data:
    name, condition, run = tumble
    return starts(tumbles(name, int(run) + 1, CONDITIONS[condition]))[int(run)]


def _of_tumble(given: tuple[Tumble, Data]) -> Missing:
    (name, condition, run), data = given
    p = loop(data).plant
    torque = missing(p, EARLY, DURATION, math.radians(LOST), ALL[name].slow)
    return Missing(name, condition, int(run), torque / float(np.linalg.norm(p.disturbance_torque_B)))


def _sorted(found: Iterable[Missing]) -> list[Missing]:
    satellites, conditions = list(ALL), list(CONDITIONS)
    return sorted(found, key=lambda it: (satellites.index(it.satellite), conditions.index(it.condition), it.run))
