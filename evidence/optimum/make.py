"""Searches the least time of tumbles of docs/evidence/flight.md, each saved as it ends, and writes
docs/evidence/optimum.csv from them. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..flight.bound import bound, starts
from ..flight.cases import SEEDS, Group, tumbles
from ..paper import FOLDER, Array
from .check import Check, check
from .courses import Course
from .flown import Flight, fly
from .kept import Line, load, save
from .search import Found, again, refined, search, search_after

TURNS = 6
"""Starts of the second search."""


def group(runs: int) -> Group:
    """The nominal tumbles of docs/evidence/flight.md."""
    return tumbles("nominal", SEEDS["nominal"], runs)


def make(runs: int, file: Path) -> Iterator[str]:
    """Writes a line for each of the first so many tumbles to `file`, and tells of each; then searches again from the
    best of each.

    What is there already is kept. A tumble without a motion that the plant confirms has no line.
    """
    lines = {line.run: line for line in load(file)} if file.is_file() else {}
    wanted = group(runs)
    for run in range(runs):
        if run not in lines:
            line = _first(run, wanted)
            if isinstance(line, str):
                yield f"{run}: {line}"
                continue
            lines[run] = line
            save(file, list(lines.values()))
            yield f"{run}: best found {line.best_s:.0f} s, flown {line.flown_s:.0f} s"
    for run, line in sorted(lines.items()):
        if not line.turned and _file(run).is_file():
            lines[run] = _second(line, wanted)
            save(file, list(lines.values()))
            yield f"{run}: best found {lines[run].best_s:.0f} s, before {line.best_s:.0f} s"


def fly_again(file: Path) -> Iterator[str]:
    """Flies the tumbles of `file` anew, as the controller is now, and searches from each hand-over; the best times
    stay."""
    lines = load(file)
    wanted = group(max(line.run for line in lines) + 1)
    for i, line in enumerate(lines):
        flight = fly(wanted, line.run)
        lines[i] = replace(line, **_of_flight(flight, search_after(flight)))
        save(file, lines)
        yield f"{line.run}: best found {line.best_s:.0f} s, flown {flight.settled:.0f} s, before {line.flown_s:.0f} s"


def _first(run: int, wanted: Group) -> Line | str:
    """The line of a tumble, or why there is none."""
    flight = fly(wanted, run)
    found = search(flight)
    if found is None:
        return "no motion found"
    whole, seen = _checked(flight, found.whole, wanted)
    if not seen.held_on:
        return f"not confirmed by the plant: {seen}"
    least = bound(starts(wanted)[run])
    _keep(run, whole.course)
    return Line(
        run=run,
        initial_rate_deg_s=float(np.degrees(np.linalg.norm(flight.plant.omega_B0))),
        bound_s=math.nan if least is None else least,
        feasible=whole.feasible,
        tried=whole.tried + (0 if found.after is None else found.after.tried),
        turned=False,
        seconds=found.seconds,
        **_of_flight(flight, found.after),
        **_of(whole, seen),
    )


def _second(line: Line, wanted: Group) -> Line:
    """The line after the search from its best."""
    began = time.process_time()
    flight = fly(wanted, line.run)
    found = again(flight, _kept(line.run))
    new = replace(line, turned=True, tried=line.tried + TURNS)
    if found is not None:
        new = replace(new, feasible=line.feasible + found.feasible)
        whole, seen = _checked(flight, found, wanted)
        if whole.course.end < line.best_s and seen.held_on:
            _keep(line.run, whole.course)
            new = replace(new, **_of(whole, seen))
    return replace(new, seconds=line.seconds + time.process_time() - began)


def _of(whole: Found, seen: Check) -> dict[str, Any]:
    """What a line says of the best motion."""
    best = whole.course
    use = _use(best)
    return {
        "best_s": best.end,
        "start": whole.start,
        "rods_best": float(use[:3].mean()),
        "wheel_best": float(use[3]),
        "check_angle_deg": float(np.degrees(seen.angle)),
        "check_rate_rad_s": seen.rate,
        "check_gap_deg": float(np.degrees(seen.gap)),
        "held_on": seen.held_on,
    }


def _checked(flight: Flight, found: Found, wanted: Group) -> tuple[Found, Check]:
    """What the plant confirms: the motion found, or the same with finer intervals."""
    seen = check(flight.plant, found.course, wanted)
    if seen.held_on:
        return found, seen
    finer = refined(flight, found)
    return (found, seen) if finer is None else (finer, check(flight.plant, finer.course, wanted))


def _use(course: Course) -> Array:
    """Mean shares (4,) of the actuators' limits until T."""
    times = np.clip(course.times, 0.0, course.end)
    return np.asarray(np.diff(times) @ np.abs(course.u[:-1]) / course.end)


def _of_flight(flight: Flight, after: Found | None) -> dict[str, Any]:
    """What a line says of the flight, and of the best motion after its hand-over."""
    use = _use(flight.course)
    return {
        "flown_s": flight.settled,
        "handed_over_s": flight.handed_over,
        "best_after_s": math.nan if after is None else after.course.end,
        "rods_flown": float(use[:3].mean()),
        "wheel_flown": float(use[3]),
    }


def _file(run: int) -> Path:
    return FOLDER / "optimum" / f"{run}.npz"


def _keep(run: int, course: Course) -> None:
    _file(run).parent.mkdir(parents=True, exist_ok=True)
    Q = course.attitudes.as_matrix()
    np.savez(_file(run), times=course.times, Q=Q, Omega=course.Omega, l_w=course.l_w, u=course.u)


def _kept(run: int) -> Course:
    with np.load(_file(run)) as of:
        return Course(of["times"], Rotation.from_matrix(of["Q"]), of["Omega"], of["l_w"], of["u"])
