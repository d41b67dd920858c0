"""Fields of docs/flight.md: other conditions, the cases that are flown on, and each controller with each allocator."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..markdown import degrees, finite, orbits
from ..paper import ORBIT
from .cases import PAIRINGS
from .kept import Flights, angle, quantile
from .tried import FLOWN_ON, TRIED


def tried(flights: Flights) -> list[list[str]]:
    """A row for each of TRIED."""
    rows = []
    for t in TRIED:
        times, held = flights.times(t.name), flights.hold_errors(t.name)
        failed = sum("the run failed" in line["remark"] for line in flights.of(t.name))
        rows.append(
            [
                t.text + (f" ({failed} runs failed)" if failed else ""),
                finite(times),
                *(orbits(quantile(times, q)) for q in (0.5, 0.9, 1.0)),
                finite(flights.times(t.name, 1)),
                angle(held, np.median),
                angle(held, np.max),
            ]
        )
    return rows


def flown_on(flights: Flights) -> dict[str, str] | None:
    """What became of the cases of FLOWN_ON in three orbits: errors after the time at which they are judged, deg."""
    on = [flights.column(f"{name} flown on", "late_max_deg") for name in FLOWN_ON]
    each = len(on[0])
    if not each:
        return None
    settled = [np.isfinite(flights.times(name)[:each]) for name in FLOWN_ON]
    largest = np.concatenate([errors[good] for errors, good in zip(on, settled, strict=True)])
    lost = largest[largest > 5.0]
    return {
        "cases": f"{each * len(on)}",
        "each": f"{each}",
        "settled": f"{len(largest)}",
        "lost": f"{len(lost)}",
        "least": degrees(float(lost.min(initial=math.inf))),
        "largest": degrees(float(lost.max(initial=0.0))),
    }


def notable(flights: Flights) -> list[Mapping[str, str]]:
    """What stands out in the table of TRIED, by its own numbers."""
    usual = quantile(flights.times("as nominal"), 0.5)
    lost, slow, coarse = [], [], []
    for t in TRIED:
        times, held = flights.times(t.name), flights.hold_errors(t.name)
        if not np.isfinite(times).all():
            lost.append(f"{t.text} ({int((~np.isfinite(times)).sum())})")
        elif quantile(times, 0.5) > 1.5 * usual:
            slow.append(t.text)
        if len(held) and np.median(held) > 0.1:
            coarse.append(t.text)
    lists = (
        ("Not all settle (how many do not)", lost),
        ("All settle, but half of them more than 1.5 times as late as nominally", slow),
        ("Held worse than 0.1° rms at the median of those that settle", coarse),
    )
    return [{"what": what, "names": "; ".join(names)} for what, names in lists if names]


def pairings(flights: Flights) -> list[list[str]]:
    """A row for each of PAIRINGS."""
    rows = []
    for (law, allocator), name in PAIRINGS.items():
        line = flights.of(f"{law} + {allocator}")[0]
        times = [line[f"settled_{d}deg_s"] for d in (5, 1)]
        hold = f"hold {degrees(float(line['hold_rms_deg'] or 'nan'))} rms"
        rows.append([name, *(orbits(float(t or "inf") / ORBIT) for t in times), hold if times[0] else line["remark"]])
    return rows
