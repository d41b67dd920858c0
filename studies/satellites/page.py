"""The tables of docs/satellites.md from docs/satellites.csv; page.md.j2 has the words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .. import markdown
from ..flight.cases import HOLD
from ..markdown import degrees
from ..paper import Array
from .classes import ALL, CLASSES, DURATION, EARLY, Satellite
from .kept import CONDITIONS, HORIZON, Flights, column

NAMES = {"nominal": "nominal", "errors": "all errors"}


def text(flights: Flights) -> str:
    """The page."""
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
        settled=int(np.isfinite(_times(flights.lines)).sum()),
        left=_left(flights),
        alarms=sum(bool(line["told"]) for line in flights.lines if ALL[line["satellite"]].has_wheel),
        duration=f"{DURATION:,.0f}",
        early=f"{EARLY:,.0f}",
        hold=f"{HOLD:,.0f}",
        horizon=f"{HORIZON:,.0f}",
    )


def _times(lines: Sequence[Mapping[str, str]]) -> Array:
    return column(lines, "settled_5deg_s", math.inf)


def _data(name: str, it: Satellite) -> list[str]:
    """What a satellite is."""
    of_wheel = [f"{1e3 * x:g}" if it.has_wheel else "–" for x in (it.wheel_torque_max, it.wheel_momentum_max)]
    axis = ", ".join(f"{x:.2g}" for x in it.wheel_axis) if it.has_wheel else "–"
    return [name, ", ".join(f"{m:.3g}" for m in it.moments), f"{it.dipole_max:g}", *of_wheel, axis, f"{it.time:.0f}"]


def _row(flights: Flights, name: str, condition: str) -> list[str]:
    """What became of a satellite's tumbles under a condition."""
    lines = flights.of(name, condition)
    times = _times(lines)
    well = np.isfinite(times)
    early = np.isfinite(column(lines, "early_s"))
    lost = early & (times > EARLY)
    held = column(lines, "hold_rms_deg")[well]
    spread = [f"{np.quantile(times, q, method='higher'):,.0f}" if well.any() else "–" for q in (0.5, 0.9, 1.0)]
    hold = [degrees(float(f(held))) for f in (np.median, np.max)] if well.any() else ["–", "–"]
    again = f"{lost.sum()}, to {degrees(float(column(lines, 'later_max_deg')[lost].max()))}" if lost.any() else "0"
    return [
        name,
        NAMES[condition],
        f"{well.sum()} of {len(lines)}",
        *(s.replace("inf", "–") for s in spread),
        again,
        *hold,
    ]


def _left(flights: Flights) -> list[list[str]]:
    """The flights that are not settled at the end, without those that have no wheel."""
    rows = []
    for line in flights.lines:
        if line["settled_5deg_s"] or not ALL[line["satellite"]].has_wheel:
            continue
        where = [line[name] or "–" for name in ("inclination_deg", "height_km", "rate_deg_s")]
        hold = [degrees(float(line[name])) if line[name] else "–" for name in ("later_max_deg", "hold_rms_deg")]
        rest = [line["wheel_share"] or "–", line["momentum_bound_s"] or "–"]
        rows.append([line["satellite"], NAMES[line["condition"]], line["run"], *where, *hold, *rest, line["remark"]])
    return rows
