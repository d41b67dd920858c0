"""What the flights of a group are measured by, and what they say of another value of a constant."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from .. import files
from ..paper import Array
from .loop import ALARMS, Flight, Flown

FILE = "sweep.csv"
"""In docs."""


def _found(flight: Flight, flown: Flown) -> float:
    return flown.told[flight.expected[-1]] - flight.fails if flight.expected else math.nan


def _sound(flight: Flight, flown: Flown) -> float:
    """0 without a false alarm."""
    told = (flown.told[i] < (flight.fails if i in flight.expected else math.inf) for i in range(ALARMS))
    return math.inf if any(told) else 0.0


def _hold(flight: Flight, flown: Flown) -> float:
    return math.degrees(flown.rms) if flown.largest < flight.angle else math.inf


@dataclass(frozen=True)
class Measure:
    """A number of each flight; infinite where it is not reached, NaN where it is not asked."""

    of: Callable[[Flight, Flown], float]
    missed: str
    """Flights that do not reach it, as the page says it."""
    unit: str = ""

    def many(self, flight: Flight) -> float:
        """What a flight that does not reach it counts as: its end, or half a turn."""
        return flight.until if self.unit == "s" else 180.0


MEASURES = {
    "settled": Measure(lambda _, flown: flown.settled, "not settled", "s"),
    "found": Measure(_found, "not detected", "s"),
    "sound": Measure(_sound, "with false alarms"),
    "hold": Measure(_hold, "lost", "°"),
}


Key = tuple[str, str, str, float]
"""Group, file, name and value; the last three empty and 0 for the flights as they are."""


@dataclass(frozen=True)
class Line:
    """Flights of a group with one value of one constant, by one measure."""

    group: str
    file: str
    name: str
    value: float
    measure: str
    runs: int
    reached: int
    median: float
    worst: float
    ratio: float
    """Geometric mean of the measure over that with the chosen value."""
    error: float
    """Half the width of the 95% interval of its logarithm, by Student's t of the flights' logarithms."""

    @property
    def key(self) -> Key:
        """What these flights are."""
        return self.group, self.file, self.name, self.value

    @property
    def change(self) -> float:
        """Logarithm of the ratio where it is beyond 2% and that width, else 0."""
        change = math.log(self.ratio) if math.isfinite(self.ratio) else 0.0
        return change if abs(change) > 0.02 and abs(change) > self.error else 0.0


def line(key: Key, measure: str, values: Array, chosen: Array, most: Array) -> Line:
    """The values of the flights beside those with the chosen value, and what one that is not reached counts as; each (n,)."""
    asked = ~np.isnan(values)
    found, before = values[asked], chosen[asked]
    with np.errstate(all="ignore"):
        logs = np.log(np.minimum(found, most[asked]) / np.minimum(before, most[asked]))
    logs = logs[np.isfinite(logs)]
    ratio = math.exp(logs.mean()) if len(logs) else math.nan
    error = student.ppf(0.975, len(logs) - 1) * logs.std(ddof=1) / math.sqrt(len(logs)) if len(logs) > 1 else math.nan
    reached = int(np.isfinite(found).sum())
    return Line(*key, measure, len(found), reached, float(np.median(found)), float(found.max()), ratio, float(error))


def load(file: Path) -> list[Line]:
    """The lines of docs/evidence/sweep.csv. Raises InputError for a file of another form."""
    return files.load(Line, file, "python -m evidence sweep")
