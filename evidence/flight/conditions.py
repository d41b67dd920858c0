"""Fields of docs/evidence/flight.md: other conditions, and each controller with each allocator."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..markdown import degrees, finite, orbits
from ..paper import ORBIT
from .cases import PAIRINGS
from .kept import Flights, angle, quantile
from .tried import TRIED


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
                became(flights, t.name),
                told(flights, t.name),
            ]
        )
    return rows


def became(flights: Flights, group: str) -> str:
    """What became over three orbits of those that were settled at EARLY."""
    then = np.isfinite(flights.column(group, "early_5deg_s"))
    lost = flights.lost(group)
    if not lost.any():
        return f"{then.sum()}, all stay" if then.any() else "0"
    return f"{then.sum()}, {lost.sum()} lose it, up to {degrees(float(flights.column(group, 'later_max_deg')[lost].max()))}"


def told(flights: Flights, group: str) -> str:
    """In how many flights the controller said that a part had failed, which, and when."""
    times = flights.told(group)
    if not len(times):
        return "0"
    names = sorted({name for line in flights.of(group) for name in line["told"].split()})
    return f"{len(times)} ({', '.join(f'`{name}`' for name in names)}), {np.median(times):.0f} s, {times.max():.0f} s"


def notable(flights: Flights) -> list[Mapping[str, str]]:
    """What stands out in the table of TRIED, by its own numbers."""
    usual = quantile(flights.times("as nominal"), 0.5)
    lost, back, slow, coarse = [], [], [], []
    for t in TRIED:
        times, held, again = flights.times(t.name), flights.hold_errors(t.name), flights.lost(t.name)
        if again.any():
            back.append(f"{t.text} ({int(again.sum())})")
        if not np.isfinite(times).all():
            lost.append(f"{t.text} ({int((~np.isfinite(times)).sum())})")
        elif quantile(times, 0.5) > 1.5 * usual:
            slow.append(t.text)
        if len(held) and np.median(held) > 0.1:
            coarse.append(t.text)
    lists = (
        ("Not all are settled at the end (how many are not)", lost),
        ("Some settled and were lost again (how many)", back),
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
