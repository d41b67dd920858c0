"""The tables of docs/satellites.md from docs/satellites.csv; page.md.j2 has the words."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .. import markdown
from ..flight.cases import HOLD
from ..markdown import degrees
from . import without_wheel
from .classes import ALL, CLASSES, DURATION, EARLY, Satellite
from .kept import (
    CONDITIONS,
    HORIZON,
    LOST,
    NAMES,
    STEEP,
    Flights,
    Tumble,
    are_lost,
    column,
    not_settled,
    settled_at_end,
    settling_times,
    tumble_of,
)
from .searched import SAMPLE, Best, Missing, waiting

BETWEEN = (0.0, 0.1, 1.0, 5.0, math.inf)
"""deg: limits between the rows of the table of best holds."""


def text(flights: Flights, holds: Sequence[Best] = (), bounds: Sequence[Missing] = ()) -> str:
    """The page."""
    best = {hold.tumble: hold for hold in holds if hold.closed and not (hold.last or hold.even)}
    least, left = _least(holds), waiting(flights, holds)
    of_wheel = [line for line in flights.lines if ALL[line["satellite"]].has_wheel]
    counts = [len(flights.of(name, kind)) for name in ALL for kind in CONDITIONS]
    return markdown.render(
        Path(__file__).parent,
        data=[_data(name, it) for name, it in ALL.items()],
        classes=[_row(flights, name, kind) for name in CLASSES for kind in CONDITIONS],
        variants=[_row(flights, name, kind) for name in ALL if name not in CLASSES for kind in CONDITIONS],
        cases=len(flights.lines),
        flights=f"{min(counts)} of each row"
        if min(counts) == max(counts)
        else f"{min(counts)} to {max(counts)} of each row",
        settled=int(np.isfinite(settling_times(flights.lines)).sum()),
        again=int((are_lost(flights.lines) & np.isfinite(settled_at_end(flights.lines))).sum()),
        again_with_wheel=int((are_lost(of_wheel) & np.isfinite(settled_at_end(of_wheel))).sum()),
        settled_with_wheel=int(np.isfinite(settling_times(of_wheel)).sum()),
        with_wheel=len(of_wheel),
        late_with_wheel=int((np.isfinite(settling_times(of_wheel)) & (settling_times(of_wheel) > EARLY)).sum()),
        left=_left(flights, best, least, {each.tumble: each for each in bounds}),
        excluded=_excluded(flights, bounds),
        no_bound=len(set(not_settled(flights)) - {each.tumble for each in bounds}),
        held=_held(flights, best),
        sample=SAMPLE,
        waiting=[
            f"{len(first)} of *{name}*, {NAMES[kind]}"
            for (name, kind), searches in left.items()
            if (first := [search for search in searches if not (search.last or search.even)])
        ],
        further=sum(search.last or search.even for searches in left.values() for search in searches),
        open=sum(not hold.closed for hold in holds),
        found=sum(ALL[name].has_wheel for name, *_ in best),
        **_unsettled(flights, best, least),
        steep=f"{STEEP:g}°",
        without=without_wheel.flown(flights),
        beside=without_wheel.beside(flights, best),
        by_inclination=_by_inclination(flights),
        alarms=[
            f"{line['satellite']}, {NAMES[line['condition']]}, run {line['run']}"
            for line in flights.lines
            if line["told"]
        ],
        duration=f"{DURATION:,.0f}",
        early=f"{EARLY:,.0f}",
        hold=f"{HOLD:,.0f}",
        horizon=f"{HORIZON:,.0f}",
    )


def _data(name: str, it: Satellite) -> list[str]:
    """What a satellite is."""
    of_wheel = [f"{1e3 * x:g}" if it.has_wheel else "–" for x in (it.wheel_torque_max, it.wheel_momentum_max)]
    axis = ", ".join(f"{x:.2g}" for x in it.wheel_axis) if it.has_wheel else "–"
    return [name, ", ".join(f"{m:.3g}" for m in it.moments), f"{it.dipole_max:g}", *of_wheel, axis, f"{it.time:.0f}"]


def _row(flights: Flights, name: str, condition: str) -> list[str]:
    """What became of a satellite's tumbles under a condition."""
    lines = flights.of(name, condition)
    times = settling_times(lines)
    well = np.isfinite(times)
    lost = are_lost(lines)
    held = column(lines, "hold_rms_deg")[well]
    spread = [f"{np.quantile(times, q, method='higher'):,.0f}" if well.any() else "–" for q in (0.5, 0.9, 1.0)]
    hold = [degrees(float(f(held))) for f in (np.median, np.max)] if well.any() else ["–", "–"]
    again = f"{lost.sum()}, to {degrees(float(column(lines, 'later_max_deg')[lost].max()))}" if lost.any() else "0"
    again += f"; {back} settle once more" if (back := int((lost & np.isfinite(settled_at_end(lines))).sum())) else ""
    return [
        name,
        NAMES[condition],
        f"{well.sum()} of {len(lines)}",
        *(s.replace("inf", "–") for s in spread),
        again,
        *hold,
    ]


def _by_inclination(flights: Flights) -> list[list[str]]:
    """What became of the flights with a wheel."""
    lines = [line for line in flights.lines if ALL[line["satellite"]].has_wheel]
    tilt, times, lost = column(lines, "inclination_deg"), settling_times(lines), are_lost(lines)
    kinds = np.array([line["condition"] for line in lines])
    rows = []
    for low, high in itertools.pairwise((0.0, 15.0, STEEP, 98.0)):
        row = [f"{low:g} to {high:g}°"]
        for kind in CONDITIONS:
            among = (tilt >= low) & (tilt < high) & (kinds == kind)
            row += [f"{(among & np.isfinite(times)).sum()} of {among.sum()}", f"{(among & lost).sum()}"]
        rows.append(row)
    return rows


def _least(holds: Sequence[Best]) -> dict[Tumble, list[float]]:
    """By tumble the smallest largest error that was found in the orbit from EARLY on and in the last one, deg; NaN where none was."""
    least: dict[Tumble, list[float]] = {}
    for hold in holds:
        if hold.closed:
            of_tumble = least.setdefault(hold.tumble, [math.nan, math.nan])
            of_tumble[hold.last] = float(np.fmin(of_tumble[hold.last], hold.largest_deg))
    return least


def _excluded(flights: Flights, bounds: Sequence[Missing]) -> list[list[str]]:
    """Of each satellite and condition with flights that do not settle: how many, how many of them no controller holds, and by how much."""
    count = Counter((name, kind) for name, kind, _ in not_settled(flights))
    rows = []
    for (name, kind), flown in count.items():
        shares = [each.share for each in bounds if (each.satellite, each.condition) == (name, kind) and each.excluded]
        most = f"{100.0 * max(shares):.0f}%" if shares else "–"
        rows.append([name, NAMES[kind], f"{flown}", f"{len(shares)}", most])
    return rows


def _left(
    flights: Flights,
    best: Mapping[Tumble, Best],
    least: Mapping[Tumble, list[float]],
    bounds: Mapping[Tumble, Missing],
) -> list[list[str]]:
    """The flights that are not settled at the end, without those that have no wheel."""
    rows = []
    for line in flights.unsettled.lines:
        where = [line[name] or "–" for name in ("inclination_deg", "height_km", "rate_deg_s")]
        flown = [degrees(float(line[name])) if line[name] else "–" for name in ("later_max_deg", "hold_rms_deg")]
        rest = [line["wheel_share"] or "–", line["momentum_bound_s"] or "–"]
        hold = best.get(tumble_of(line))
        possible = [degrees(hold.rms_deg), f"{hold.wheel_share:.2f}"] if hold else ["–"] * 2
        possible += ["" if math.isnan(x) else degrees(x) for x in least.get(tumble_of(line), [math.nan, math.nan])]
        missing = f"{100.0 * bound.share:.0f}%" if (bound := bounds.get(tumble_of(line))) and bound.excluded else "–"
        what = [line["satellite"], NAMES[line["condition"]], line["run"]]
        rows.append([*what, *where, *flown, *rest, missing, *possible, line["remark"]])
    return rows


def _unsettled(flights: Flights, best: Mapping[Tumble, Best], least: Mapping[Tumble, list[float]]) -> dict[str, int]:
    """Of the flights with a wheel that are not settled: how many, how many were at EARLY; and what is known of their best holds."""
    lines = flights.unsettled.lines
    known = [best[key] for line in lines if (key := tumble_of(line)) in best]
    errors = [least[key] for line in lines if (key := tumble_of(line)) in best]
    return {
        "unsettled": len(lines),
        "were_settled": sum(bool(line["early_s"]) for line in lines),
        "known": len(known),
        "full": sum(hold.wheel_share > 0.995 for hold in known),
        "far": (far := sum(hold.rms_deg >= LOST for hold in known)),
        "close": (close := sum(first < LOST for first, _ in errors)),
        "rest": len(known) - far - close,
        "both": sum(first < LOST and last < LOST for first, last in errors),
    }


def _held(flights: Flights, best: Mapping[Tumble, Best]) -> list[list[str]]:
    """What became of the flights with a wheel whose best hold was found, by its rms."""
    lines = [line for line in flights.lines if tumble_of(line) in best and ALL[line["satellite"]].has_wheel]
    rms = np.array([best[tumble_of(line)].rms_deg for line in lines])
    times, lost = settling_times(lines), are_lost(lines)
    rows = []
    for low, high in itertools.pairwise(BETWEEN):
        among = (rms >= low) & (rms < high)
        if among.any():
            name = f"below {high:g}°" if low == 0.0 else f"{low:g} to {high:g}°".replace(" to inf°", "° and more")
            rows.append([name, f"{among.sum()}", f"{(among & np.isfinite(times)).sum()}", f"{(among & lost).sum()}"])
    return rows
