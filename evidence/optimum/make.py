"""Searches the least time of tumbles of docs/evidence/flight.md, each saved as it ends, and writes
docs/evidence/optimum.csv from them. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..flight.cases import SEEDS, Group, tumbles
from ..paper import Array
from .check import Check, check
from .courses import Course
from .flown import Flight, fly
from .kept import Line, load, save
from .problem import WIDE
from .search import Found, Optimum, refined, search, search_after
from .tumbles import Tumbles, of_group

OF_BEST = (
    "best_s",
    "start",
    "rods_best",
    "wheel_best",
    "check_angle_deg",
    "check_rate_rad_s",
    "check_gap_deg",
    "held_on",
)
"""What a line says of the best motion."""


def group(runs: int) -> Group:
    """The nominal tumbles of docs/evidence/flight.md."""
    return tumbles("nominal", SEEDS["nominal"], runs)


def make(runs: Iterable[int], file: Path) -> Iterator[str]:
    """Writes a line for each of these tumbles to `file`, and tells of each.

    What was found from WIDE starts is kept; of another line the shorter motion stays. A tumble without a motion that
    the plant confirms has no line.
    """
    lines = {line.run: line for line in load(file)} if file.is_file() else {}
    runs = list(runs)
    wanted = of_group(group(max(runs) + 1))
    for run in runs:
        old = lines.get(run)
        if old is not None and old.tried >= WIDE:
            continue
        flight = fly(wanted, run)
        line = line_of(run, wanted, flight, search(flight, wanted.grid), old)
        if line is None:
            yield f"{run}: no motion that the plant confirms"
            continue
        lines[run] = line
        save(file, list(lines.values()))
        before = "" if old is None else f", before {old.best_s:.0f} s"
        yield f"{run}: best found {line.best_s:.0f} s, flown {line.flown_s:.0f} s{before}"


def fly_again(file: Path) -> Iterator[str]:
    """Flies the tumbles of `file` anew, as the controller is now, and searches from each hand-over; the best times
    stay."""
    lines = load(file)
    wanted = of_group(group(max(line.run for line in lines) + 1))
    for i, line in enumerate(lines):
        flight = fly(wanted, line.run)
        lines[i] = replace(line, **_of_flight(flight, search_after(flight, wanted.grid)))
        save(file, lines)
        yield f"{line.run}: best found {line.best_s:.0f} s, flown {flight.settled:.0f} s, before {line.flown_s:.0f} s"


def line_of(run: int, wanted: Tumbles, flight: Flight, found: Optimum, old: Line | None = None) -> Line | None:
    """The line of a tumble with the shortest motion that the plant confirms, or the old line's; None without one."""
    best = None if old is None else {name: getattr(old, name) for name in OF_BEST}
    for whole in found.wholes:
        if old is not None and whole.course.end >= old.best_s:
            break
        whole, seen = _checked(flight, whole, wanted)
        if _counts(seen, wanted):
            best = _of(whole, seen)
            break
    if best is None:
        return None
    least = wanted.bound_of(run)
    return Line(
        run=run,
        initial_rate_deg_s=float(np.degrees(np.linalg.norm(flight.plant.omega_B0))),
        bound_s=math.nan if least is None else least,
        feasible=len(found.wholes),
        tried=found.tried,
        seconds=found.seconds,
        **_of_flight(flight, found.after),
        **best,
    )


def _of(whole: Found, seen: Check) -> dict[str, Any]:
    """Returns what a line says of the best motion."""
    best = whole.course
    use = _use(best)
    return {
        "best_s": best.end,
        "start": whole.start,
        "rods_best": float(use[:3].mean()),
        "wheel_best": float(use[3:].mean()),
        "check_angle_deg": float(np.degrees(seen.angle)),
        "check_rate_rad_s": seen.rate,
        "check_gap_deg": float(np.degrees(seen.gap)),
        "held_on": seen.held_on,
    }


def _checked(flight: Flight, found: Found, wanted: Tumbles) -> tuple[Found, Check]:
    """Returns what the plant confirms: the motion found, or the same with finer intervals."""
    seen = check(flight.plant, found.course, wanted.scenario)
    if _counts(seen, wanted):
        return found, seen
    finer = refined(flight, found, wanted.grid.finer)
    return (found, seen) if finer is None else (finer, check(flight.plant, finer.course, wanted.scenario))


def _counts(seen: Check, wanted: Tumbles) -> bool:
    return seen.held_on if wanted.held else seen.inside


def _use(course: Course) -> Array:
    """Mean shares (3 + n,) of the actuators' limits until T."""
    times = np.clip(course.times, 0.0, course.end)
    return np.asarray(np.diff(times) @ np.abs(course.u[:-1]) / course.end)


def _of_flight(flight: Flight, after: Found | None) -> dict[str, Any]:
    """Returns what a line says of the flight, and of the best motion after its hand-over."""
    use = _use(flight.course)
    return {
        "flown_s": flight.settled,
        "handed_over_s": flight.handed_over,
        "best_after_s": math.nan if after is None else after.course.end,
        "rods_flown": float(use[:3].mean()),
        "wheel_flown": float(use[3:].mean()),
    }
