"""The tables of docs/evidence/satellites.md from docs/evidence/satellites.csv; page.md.j2 has the words."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from .. import markdown
from ..flight.cases import HOLD, LOST
from ..markdown import degrees
from ..paper import Array
from . import without_wheel
from .classes import ALL, CLASSES, DURATION, EARLY, Satellite
from .kept import (
    CONDITIONS,
    HORIZON,
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
from .searched import Closest, Missing, waiting

BETWEEN = (0.0, 3.0, 4.0, LOST, 7.0, 15.0, math.inf)
"""deg: limits between the rows of the table of least largest errors."""


def text(flights: Flights, holds: Sequence[Closest] = (), bounds: Sequence[Missing] = ()) -> str:
    """The page."""
    closest = {hold.tumble: hold for hold in holds}
    excluded = {each.tumble for each in bounds if each.excluded}
    verdicts = {tumble: _verdict(tumble, closest, excluded) for tumble in not_settled(flights)}
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
        left=_left(flights, closest, {each.tumble: each for each in bounds}),
        why_not=_why_not(verdicts),
        most_missing=f"{max(shares):.1f} times the disturbance"
        if (shares := [each.share for each in bounds if each.excluded])
        else "",
        near=_near(verdicts, closest),
        no_bound=len(set(verdicts) - {each.tumble for each in bounds}),
        compared=_compared(flights, closest),
        closer=_closer(flights, closest),
        waiting=sum(map(len, waiting(flights, holds).values())),
        of_excluded=_of_excluded(closest, excluded),
        open=sum(_verdict(hold.tumble, closest, ()) == "not known" for hold in holds),
        unsettled=len(flights.unsettled.lines),
        were_settled=sum(bool(line["early_s"]) for line in flights.unsettled.lines),
        steep=f"{STEEP:g}°",
        without=without_wheel.flown(flights),
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


def _why_not(verdicts: Mapping[Tumble, str]) -> list[list[str]]:
    """Of each satellite and condition with flights that do not settle: how many, and what is known against them."""
    of_row: dict[tuple[str, str], Counter[str]] = {}
    for tumble, verdict in verdicts.items():
        of_row.setdefault(tumble[:2], Counter())[verdict] += 1
    return [
        [name, NAMES[kind], f"{known.total()}", *(f"{known[verdict]}" for verdict in VERDICTS)]
        for (name, kind), known in of_row.items()
    ]


VERDICTS = ("excluded", "none to the end", "none that repeats", "repeats in one orbit", "not ruled out", "not known")
"""What is known of a flight that does not settle: a proof, searches that find no motion within LOST, or find it, nothing."""


def _verdict(tumble: Tumble, closest: Mapping[Tumble, Closest], excluded: Collection[Tumble]) -> str:
    if tumble in excluded:
        return "excluded"
    if (hold := closest.get(tumble)) is None or math.isnan(hold.to_end_deg):
        return "not known"
    if not hold.close:
        return "none to the end"
    if not ALL[tumble[0]].has_wheel:
        return "not ruled out"
    if math.isnan(sum(hold.repeating_deg)):
        return "not known"
    return ("not ruled out", "repeats in one orbit", "none that repeats")[sum(x >= LOST for x in hold.repeating_deg)]


def _near(verdicts: Mapping[Tumble, str], closest: Mapping[Tumble, Closest]) -> int:
    """Flights with a wheel against which only a search speaks, by less than a degree."""
    against = [closest[tumble] for tumble, it in verdicts.items() if ALL[tumble[0]].has_wheel and it.startswith("none")]
    return sum((min(hold.repeating_deg) if hold.close else hold.to_end_deg) < LOST + 1.0 for hold in against)


def _left(flights: Flights, closest: Mapping[Tumble, Closest], bounds: Mapping[Tumble, Missing]) -> list[list[str]]:
    """The flights that are not settled at the end, without those that have no wheel."""
    rows = []
    for line in flights.unsettled.lines:
        where = [line[name] or "–" for name in ("inclination_deg", "height_km", "rate_deg_s")]
        flown = [degrees(float(line[name])) if line[name] else "–" for name in ("later_max_deg", "hold_rms_deg")]
        rest = [line["wheel_share"] or "–", line["momentum_bound_s"] or "–"]
        hold = closest.get(tumble_of(line))
        found = (hold.to_end_deg, *hold.repeating_deg) if hold else [math.nan] * 3
        possible = ["–" if math.isnan(x) else degrees(x) for x in found]
        missing = f"{100.0 * bound.share:.2g}%" if (bound := bounds.get(tumble_of(line))) and bound.excluded else "–"
        what = [line["satellite"], NAMES[line["condition"]], line["run"]]
        rows.append([*what, *where, *flown, *rest, missing, *possible, line["remark"]])
    return rows


def _compared(flights: Flights, closest: Mapping[Tumble, Closest]) -> list[list[str]]:
    """What became of nominal flights without a wheel, by the least largest error that was found, and their largest error over it."""
    lines, least = _found(flights, closest)
    nominal = [not ALL[line["satellite"]].has_wheel and line["condition"] == "nominal" for line in lines]
    compared = np.array(nominal, bool)
    times, lost = settling_times(lines), are_lost(lines)
    over = column(lines, "later_max_deg", math.inf) / least
    rows = []
    for low, high in itertools.pairwise(BETWEEN):
        among = compared & (least >= low) & (least < high)
        if among.any():
            name = f"below {high:g}°" if low == 0.0 else f"{low:g} to {high:g}°".replace(" to inf°", "° and more")
            counts = [among, among & np.isfinite(times), among & lost]
            rows.append([name, *(f"{count.sum()}" for count in counts), f"{np.median(over[among]):.2g}"])
    return rows


def _found(flights: Flights, closest: Mapping[Tumble, Closest]) -> tuple[list[Mapping[str, str]], Array]:
    """The flights of which a motion to the end was found, and its largest error (n,), deg."""
    lines = [
        line for line in flights.lines if (hold := closest.get(tumble_of(line))) and math.isfinite(hold.to_end_deg)
    ]
    return lines, np.array([closest[tumble_of(line)].to_end_deg for line in lines])


def _of_excluded(closest: Mapping[Tumble, Closest], excluded: Collection[Tumble]) -> list[str]:
    """Of the excluded tumbles the smallest of the least largest errors that were found, rounded down, and the median; empty without one."""
    errors = [closest[tumble].to_end_deg for tumble in excluded if tumble in closest]
    return [f"{math.floor(10.0 * np.nanmin(errors)) / 10.0:g}°", degrees(float(np.nanmedian(errors)))] if errors else []


def _closer(flights: Flights, closest: Mapping[Tumble, Closest]) -> int:
    """How many flights stayed closer after EARLY than the least largest error that was found, to a hundredth of a degree."""
    lines, least = _found(flights, closest)
    return int((column(lines, "later_max_deg", math.inf) < least - 0.01).sum())
