"""docs/evidence/flight_hold.csv: how close to the target some tumbles of docs/evidence/flight.md can stay (evidence/hold.py), beside their flights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import files
from ..markdown import degrees
from .cases import LOST
from .kept import Flights
from .tried import TRIED

FILE = "flight_hold.csv"
SOUGHT = ("wheel stuck", "drag")
"""Groups of TRIED of whose tumbles it is sought."""


@dataclass(frozen=True)
class Closest:
    """The least largest error of a motion from EARLY to the end that was found for a tumble, deg; NaN: none."""

    group: str
    run: int
    error_deg: float


def load(file: Path) -> list[Closest]:
    """Those of a file, none without one. Raises InputError for a file of another form."""
    return files.load_if_any(Closest, file, "python -m evidence flight --holds")


def save(file: Path, found: Iterable[Closest]) -> None:
    """Writes them by group and run."""
    files.save(Closest, file, sorted(found, key=lambda one: (SOUGHT.index(one.group), one.run)))


def compared(flights: Flights, found: Iterable[Closest]) -> list[list[str]]:
    """Of each group: its least largest errors, and the largest errors flown after EARLY beside them."""
    text, rows = {t.name: t.text for t in TRIED}, []
    for group in SOUGHT:
        least_of = {one.run: one.error_deg for one in found if one.group == group}
        runs = [int(line["run"]) for line in flights.of(group)]
        least = np.array([least_of.get(run, np.nan) for run in runs])
        flown = flights.column(group, "later_max_deg")
        known = np.isfinite(least) & np.isfinite(flown)
        if known.any():
            beyond = known & (flown >= LOST)
            over = (flown / least)[known]
            sizes = [f(errors[known]) for errors in (least, flown) for f in (np.median, np.max)]
            rows.append(
                [
                    text[group],
                    f"{known.sum()}",
                    *(degrees(float(size)) for size in sizes),
                    f"{beyond.sum()}",
                    f"{(beyond & (least >= LOST)).sum()}",
                    *(_times(float(f(over))) for f in (np.min, np.median, np.max)),
                ]
            )
    return rows


def _times(over: float) -> str:
    return f"{over:.3g}" if over < 1000.0 else "above 1000"
