"""The tables and the figure of docs/evidence/wheels.md; page.md.j2 has the words.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import markdown
from ..markdown import degrees
from ..plots import BLUE, RED, name_axes, panels
from .cases import CONDITIONS, DURATION, ORBIT, WHEELS
from .kept import Flown, Least
from .long import Long
from .slews import ANGLES, WITHIN, Slew
from .telemetry import FAILED, SETS, TELEMETRY, Failure

HOLDS = {"nominal": 0.005, "estimated": 0.02}
"""deg rms: the requirements of the hold."""
LATE, ASKED = (1.25, 1.6), 20
"""Of the best time, at the median and at worst, and of how many tumbles of each satellite: the requirement."""


def text(
    flown: Sequence[Flown],
    slews: Sequence[Slew],
    long: Sequence[Long],
    telemetry: Sequence[Failure] = (),
    least: Sequence[Least] = (),
) -> str:
    """Returns the page."""
    healthy = [f for f in flown if f.condition in ("nominal", "errors", "estimated")]
    over = [f.settled_5 / f.least_time for f in flown if f.condition == "nominal" and f.least_time > 60.0]
    return markdown.render(
        Path(__file__).parent,
        healthy=_count(healthy),
        times=_quantiles([f for f in flown if f.condition == "nominal"]),
        holds=[_hold(flown, name, limit) for name, limit in HOLDS.items()],
        one_of_four=_count([f for f in flown if f.condition == "one dead" and len(WHEELS[f.satellite]) == 4]),
        one_of_three=_count([f for f in flown if f.condition == "one dead" and len(WHEELS[f.satellite]) == 3]),
        one_left=_count([f for f in flown if f.condition == "two dead"]),
        alone=_alone([f for f in flown if f.condition == "all dead"]),
        stuck=_unsettled([f for f in flown if f.satellite == "3U" and f.condition == "one stuck"]),
        others=_count([f for f in flown if f.condition in ("one weak", "one reversed", "one stuck", "one drags")]),
        named=sum(f.others for f in flown),
        rows=[row for name in WHEELS for row in _rows(flown, name)],
        failed=list(_failed(flown)),
        failed_head="|".join(["failed", *WHEELS]),
        found=_found([f for f in flown if CONDITIONS[f.condition].lost and f.condition != "all dead"]),
        slews=[_slews(slews, name) for name in WHEELS],
        angles="|".join(f"{angle}°" for angle in ANGLES),
        slews_within=f"{sum(one.ratio <= WITHIN for one in slews):,} of {len(slews):,}",
        long=[
            (one.flight, one.satellite, f"{degrees(one.rms)}, {degrees(one.largest)}", f"{one.wheel_share:.2f}")
            for one in long
        ],
        late=[_late(least, name) for name in WHEELS if any(one.satellite == name for one in least)],
        ratios=", ".join(f"{name} {_median(_ratios(least, name)):.2f}" for name in WHEELS if _ratios(least, name)),
        within=all(_met(_ratios(least, name)) for name in WHEELS),
        over_bound=f"{np.median(over):.1f}, at most {max(over):.1f}, of {len(over)}" if over else "not known, of",
        median_limit=LATE[0],
        asked=ASKED,
        holds_on=f"{sum(one.held_on for one in least)} of {len(least)}",
        most=max((f.run + 1 for f in flown), default=0),
        cases=len(flown),
        duration=f"{DURATION:,.0f}",
        orbit=f"{ORBIT:,.0f}",
        telemetry=list(_telemetry(telemetry)),
        told=_told([f for f in telemetry if f.of_telemetry]),
    )


def _ratios(least: Sequence[Least], satellite: str) -> list[float]:
    """The time to settle over the best found, of each tumble searched."""
    return [one.flown_s / one.best_s for one in least if one.satellite == satellite]


def _met(ratios: Sequence[float]) -> bool:
    return len(ratios) >= ASKED and float(np.median(ratios)) <= LATE[0] and max(ratios) <= LATE[1]


def _late(least: Sequence[Least], satellite: str) -> list[str]:
    those, ratios = [one for one in least if one.satellite == satellite], _ratios(least, satellite)
    best = f"{_median(one.best_s for one in those):.0f} s"
    return [
        satellite,
        str(len(those)),
        str(min(one.tried for one in those)),
        best,
        f"{_median(ratios):.2f}",
        f"{max(ratios):.2f}",
    ]


def _count(flown: Sequence[Flown]) -> str:
    return f"{sum(f.settled for f in flown)} of {len(flown)}"


def _unsettled(flown: Sequence[Flown]) -> tuple[str, int]:
    """How many do not settle, and how many of them turn round."""
    return f"{sum(not f.settled for f in flown)} of {len(flown)}", sum(f.hold_max > 90.0 for f in flown)


def _quantiles(flown: Sequence[Flown]) -> str:
    found = []
    for name in WHEELS:
        times = [f.settled_5 for f in flown if f.satellite == name]
        if times:
            found.append(f"{name} {np.quantile(times, 0.5, method='higher'):,.0f} s and {max(times):,.0f} s")
    return "; ".join(found)


def _hold(flown: Sequence[Flown], condition: str, limit: float) -> str:
    settled = [f for f in flown if f.condition == condition and f.settled]
    met = sum(f.hold_rms < limit for f in settled)
    worst = degrees(max((f.hold_rms for f in settled), default=float("nan")))
    return f"{CONDITIONS[condition].text}: below {limit:g}° rms in {met} of {len(settled)}, worst {worst}"


def _alone(flown: Sequence[Flown]) -> list[str]:
    """The hold of rods alone, rms at the median and the largest, and the median of what any use of them allows."""
    kinds = ((_median, "hold_rms"), (max, "hold_max"), (_median, "least_angle"))
    return [degrees(f(getattr(x, name) for x in flown)) for f, name in kinds] if flown else []


def _rows(flown: Sequence[Flown], satellite: str) -> list[list[str]]:
    rows = []
    for name, condition in CONDITIONS.items():
        those = [f for f in flown if (f.satellite, f.condition) == (satellite, name)]
        if not those or condition.lost:
            continue
        settled = [f for f in those if f.settled]
        share = f"{max(x.wheel_share for x in settled):.2f}" if settled else "–"
        settling = ", ".join([_count(those), *_times(those)])
        rows.append([satellite, name, settling, ", ".join(_holds(settled)), share])
    return rows


def _failed(flown: Sequence[Flown]) -> Iterator[list[str]]:
    """A row for each failure but that of all wheels, which has a table of its own; a dash where none flew."""
    for name, condition in CONDITIONS.items():
        if condition.lost and name != "all dead":
            row = [condition.text]
            for satellite in WHEELS:
                those = [f for f in flown if (f.satellite, f.condition) == (satellite, name)]
                held = _holds([f for f in those if f.settled])[1]
                row.append(f"{_count(those)}, {_times(those)[1]}, {held}" if those else "–")
            yield row


def _found(flown: Sequence[Flown]) -> str:
    """In how many flights the allocator reported what failed, and when at the median and at worst."""
    known = [f.found for f in flown if math.isfinite(f.found)]
    when = f", after {_median(known):,.0f} s at the median and {max(known):,.0f} s at worst" if known else ""
    return f"{len(known)} of {len(flown)} flights{when}"


def _times(those: Sequence[Flown]) -> list[str]:
    return [f"{f(x.settled_5 for x in those):,.0f} s".replace("inf s", "–") for f in (_median, max)]


def _holds(settled: Sequence[Flown]) -> list[str]:
    return [degrees(f(x.hold_rms for x in settled)) if settled else "–" for f in (_median, max)]


def _telemetry(flown: Sequence[Failure]) -> Iterator[list[str]]:
    """A row for each failure with each number of wheels."""
    for failure in (*TELEMETRY, *FAILED):
        for wheels in SETS:
            those = [f for f in flown if (f.failure, f.wheels) == (failure, wheels)]
            named = [f.named for f in those if math.isfinite(f.named)]
            if those:
                what = f"telemetry {failure}" if failure in TELEMETRY else f"a wheel {failure}"
                counts = [f"{sum(f.held for f in those)} of {len(those)}", f"{len(named)} of {len(those)}"]
                times = f"{_median(named):.0f} s" if named else "–"
                largest = degrees(_median(f.largest for f in those)), degrees(max(f.largest for f in those))
                yield [what, str(wheels), *counts, times, *largest, str(sum(f.others for f in those))]


def _told(flown: Sequence[Failure]) -> str:
    held, named = sum(f.held for f in flown), sum(math.isfinite(f.named) for f in flown)
    return f"{held} of {len(flown)} flights hold, the sound wheel is named in {named}"


def _slews(slews: Sequence[Slew], satellite: str) -> list[str]:
    ratios = {
        angle: [one.ratio for one in slews if (one.satellite, one.angle) == (satellite, angle)] for angle in ANGLES
    }
    every = [ratio for those in ratios.values() for ratio in those]
    medians = [f"{_median(those):.2f}" if those else "–" for those in ratios.values()]
    return [satellite, *medians, f"{max(every, default=math.nan):.2f}".replace("inf", "–")]


def _median(values: Any) -> float:
    return float(np.quantile(list(values), 0.5, method="higher"))


def figure(flown: Sequence[Flown]) -> Any:
    """Returns when each flight settled."""
    drawn, axes = panels(1, 1, 8.6, 4.8)
    ax = axes[0, 0]
    names: list[str] = []
    for satellite in reversed(WHEELS):
        for name in reversed(CONDITIONS):
            those = [f for f in flown if (f.satellite, f.condition) == (satellite, name)]
            if those:
                times = np.array([f.settled_5 for f in those if f.settled]) / 60.0
                colour = RED if "dead" in name else BLUE
                ax.scatter(times, np.full(len(times), len(names)), s=9, color=colour, alpha=0.6, linewidths=0)
                ax.annotate(
                    f"{len(times)} of {len(those)}",
                    (1.01, len(names)),
                    xycoords=("axes fraction", "data"),
                    fontsize=7,
                    va="center",
                )
                names.append(f"{satellite}, {name}")
    ax.set_xscale("log")
    ax.set_yticks(range(len(names)), names, fontsize=8)
    name_axes(ax, "settled below 5° after, minutes; at the right how many", "", "tumbles with sets of wheels")
    return drawn
