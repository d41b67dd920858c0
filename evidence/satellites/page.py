"""The tables and the figure of docs/evidence/satellites.md from its CSV files; page.md.j2 has the words.

Tests: tests/evidence/satellites/test_page.py.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import markdown
from ..flight.cases import HOLD
from ..markdown import degrees
from ..plots import BLUE, RED, name_axes, panels
from .classes import ALL, DURATION, EARLY
from .kept import (
    CONDITIONS,
    NAMES,
    STEEP,
    Flights,
    are_lost,
    column,
    not_settled,
    settled_at_end,
    settling_times,
    tumble_of,
)
from .searched import Closest, Missing


def text(flights: Flights, holds: Sequence[Closest] = (), bounds: Sequence[Missing] = ()) -> str:
    """Returns the page."""
    closest = {hold.tumble: hold for hold in holds}
    excluded = {each.tumble: each.share for each in bounds if each.excluded}
    of_wheel = [line for line in flights.lines if ALL[line["satellite"]].has_wheel]
    times = settling_times(of_wheel)
    steep = column(of_wheel, "inclination_deg") >= STEEP
    missed = not_settled(flights)
    return markdown.render(
        Path(__file__).parent,
        flown=[_row(flights, name) for name in ALL],
        cases=len(flights.lines),
        settled_with_wheel=int(np.isfinite(times).sum()),
        with_wheel=len(of_wheel),
        late_with_wheel=int((np.isfinite(times) & (times > EARLY)).sum()),
        settled_steep=f"{np.isfinite(times[steep]).sum()} of {steep.sum()}",
        by_inclination=_by_inclination(flights),
        why_not=_why_not(flights, closest, set(excluded)),
        most_missing=f"{max(excluded.values(), default=0.0):.1f}",
        not_known=len(set(missed) - {each.tumble for each in bounds}),
        without=_without_wheel(flights),
        alarms=sum(bool(line["told"]) for line in flights.lines),
        alarms_with_wheel=sum(bool(line["told"]) for line in of_wheel),
        duration=f"{DURATION:,.0f}",
        early=f"{EARLY:,.0f}",
        hold=f"{HOLD:,.0f}",
        steep=f"{STEEP:g}°",
    )


def _row(flights: Flights, name: str) -> list[str]:
    """Returns what became of a satellite's tumbles."""
    settled, median, *_ = _became(flights.of(name, "nominal"))
    count, *times, again, rms, largest = _became(flights.of(name, "errors"))
    return [name, f"{settled}, {median}", ", ".join((count, *times)), again, f"{rms}, {largest}"]


def _became(lines: Sequence[Mapping[str, str]]) -> list[str]:
    """Returns how many settled, when, how many were lost again, and their hold."""
    times, lost = settling_times(lines), are_lost(lines)
    well = np.isfinite(times)
    held = column(lines, "hold_rms_deg")[well]
    spread = [f"{np.quantile(times, q, method='higher'):,.0f} s" if well.any() else "–" for q in (0.5, 1.0)]
    hold = [degrees(float(f(held))) for f in (np.median, np.max)] if well.any() else ["–", "–"]
    again = f"{lost.sum()}, to {degrees(float(column(lines, 'later_max_deg')[lost].max()))}" if lost.any() else "0"
    return [f"{well.sum()} of {len(lines)}", *(s.replace("inf s", "–") for s in spread), again, *hold]


def _by_inclination(flights: Flights) -> list[list[str]]:
    """Returns what became of the flights with a wheel."""
    lines = [line for line in flights.lines if ALL[line["satellite"]].has_wheel]
    tilt, times = column(lines, "inclination_deg"), settling_times(lines)
    kinds = np.array([line["condition"] for line in lines])
    rows = []
    for low, high in itertools.pairwise((0.0, 15.0, STEEP, 98.0)):
        among = [(tilt >= low) & (tilt < high) & (kinds == kind) for kind in CONDITIONS]
        rows.append(
            [f"{low:g} to {high:g}°", *(f"{(those & np.isfinite(times)).sum()} of {those.sum()}" for those in among)]
        )
    return rows


def _why_not(flights: Flights, closest: dict[Any, Closest], excluded: set[Any]) -> list[list[str]]:
    """Returns, of each row with flights that do not settle, how many, and what is known against them."""
    rows = []
    for name, kind in itertools.product(ALL, CONDITIONS):
        lines = flights.of(name, kind)
        left = [tumble_of(line) for line, time in zip(lines, settling_times(lines), strict=True) if math.isinf(time)]
        if left:
            rest = [tumble for tumble in left if tumble not in excluded]
            none = sum((hold := closest.get(tumble)) is not None and hold.none_within for tumble in rest)
            again = int((are_lost(lines) & np.isfinite(settled_at_end(lines))).sum())
            counts = (len(left), again, len(left) - len(rest), none, len(rest) - none)
            rows.append([name, NAMES[kind], *(f"{count}" for count in counts)])
    return rows


def _without_wheel(flights: Flights) -> list[list[str]]:
    """Returns what satellites without a wheel hold, settled or not."""
    rows = []
    for name, kind in itertools.product((name for name in ALL if not ALL[name].has_wheel), CONDITIONS):
        lines = flights.of(name, kind)
        largest = column(lines, "later_max_deg", math.inf)
        below = [f"{(largest < limit).sum()} of {len(largest)}" for limit in (5.0, 15.0)]
        rows.append([name, NAMES[kind], f"{1e9 * ALL[name].disturbance(CONDITIONS[kind]):.2g}", *below])
    return rows


def figure(flights: Flights) -> Any:
    """Returns the settling times of each satellite's tumbles, over its own time T."""
    drawn, axes = panels(1, 1, 8.6, 4.6)
    ax = axes[0, 0]
    for place, name in enumerate(reversed(ALL)):
        for kind, colour, off in (("nominal", BLUE, 0.17), ("errors", RED, -0.17)):
            times = settling_times(flights.of(name, kind))
            found = times[np.isfinite(times)] / 60.0
            style = {
                "s": 7,
                "color": colour,
                "alpha": 0.5,
                "linewidths": 0,
                "label": NAMES[kind] if not place else None,
            }
            ax.scatter(found, np.full(len(found), place + off), **style)
            ax.annotate(
                f"{len(found)}", (1.01, place + off), xycoords=("axes fraction", "data"), fontsize=7, va="center"
            )
    ax.set_xscale("log")
    ax.set_yticks(range(len(ALL)), list(reversed(ALL)), fontsize=8)
    ax.legend(fontsize=8, frameon=False, loc="lower left", markerscale=2.0)
    name_axes(ax, "settled below 5° after, minutes; at the right how many of 100", "", "tumbles of each satellite")
    return drawn
