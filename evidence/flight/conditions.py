"""Fields of docs/evidence/flight.md: other conditions, and each controller with each allocator.
Tests: tests/evidence/flight/test_page.py."""

from __future__ import annotations

import numpy as np

from ..markdown import degrees, finite, orbits
from ..paper import ORBIT
from .cases import PAIRINGS
from .kept import Flights, quantile
from .tried import TRIED


def tried(flights: Flights) -> list[list[str]]:
    """A row for each of TRIED."""
    rows = []
    for t in TRIED:
        times = flights.times(t.name)
        failed = sum("the run failed" in line["remark"] for line in flights.of(t.name))
        rows.append(
            [
                t.text + (f" ({failed} runs failed)" if failed else ""),
                finite(times),
                *(orbits(quantile(times, q)) for q in (0.5, 1.0)),
                became(flights, t.name),
                told(flights, t.name),
            ]
        )
    return rows


def became(flights: Flights, group: str) -> str:
    """Returns how many of those that were settled at EARLY were lost again, and their largest error."""
    then = np.isfinite(flights.column(group, "early_5deg_s"))
    lost = flights.lost(group)
    if not lost.any():
        return "0"
    return f"{lost.sum()} of {then.sum()}, up to {degrees(float(flights.column(group, 'later_max_deg')[lost].max()))}"


def told(flights: Flights, group: str) -> str:
    """In how many flights the controller said that a part had failed, which, and when."""
    times = flights.told(group)
    if not len(times):
        return "0"
    names = sorted({name for line in flights.of(group) for name in line["told"].split()})
    return f"{len(times)} ({', '.join(f'`{name}`' for name in names)}), {np.median(times):.0f} s, {times.max():.0f} s"


def pairings(flights: Flights) -> str:
    """Returns when each of PAIRINGS settles."""
    flown = {name: flights.of(f"{law} + {allocator}")[0] for (law, allocator), name in PAIRINGS.items()}
    times = {name: orbits(float(line["settled_5deg_s"] or "inf") / ORBIT) for name, line in flown.items()}
    return "; ".join(f"{name}: {time}" for name, time in times.items())
