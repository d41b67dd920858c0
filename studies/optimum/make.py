"""Searches the least time of tumbles of docs/flight.md, each saved as it ends, and writes docs/optimum.csv from them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..flight.bound import bound, starts
from ..flight.cases import SEEDS, Group, tumbles
from ..paper import FOLDER, Array
from .check import Check, check
from .courses import Course
from .flown import Flight, fly
from .kept import Line, load, save
from .search import Found, Optimum, refined, search


def group(runs: int) -> Group:
    """The nominal tumbles of docs/flight.md."""
    return tumbles("nominal", SEEDS["nominal"], runs)


def make(runs: int, file: Path) -> Iterator[str]:
    """Writes a line for each of the first so many tumbles to `file`, and tells of each; those that are there already are kept.

    The best commands of each stand beside the datasets of the studies. A tumble without a checked motion has no line.
    """
    done = load(file) if file.is_file() else []
    wanted = group(runs)
    for run in sorted(set(range(runs)) - {line.run for line in done}):
        flight = fly(wanted, run)
        found = search(flight)
        if found is None:
            yield f"{run}: no motion found"
            continue
        whole, seen = _checked(flight, found.whole, wanted)
        if not seen.held_on:
            yield f"{run}: not confirmed by the plant: {seen}"
            continue
        least = bound(starts(wanted)[run])
        done.append(_line(run, flight, found, whole, seen, np.nan if least is None else least))
        save(file, done)
        _keep(run, whole.course)
        yield f"{run}: best found {done[-1].best_s:.0f} s, flown {done[-1].flown_s:.0f} s"


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


def _line(run: int, flight: Flight, found: Optimum, whole: Found, seen: Check, least: float) -> Line:
    best, flown = whole.course, flight.course
    ours, theirs = _use(best), _use(flown)
    return Line(
        run=run,
        initial_rate_deg_s=float(np.degrees(np.linalg.norm(flight.plant.omega_B0))),
        bound_s=least,
        best_s=best.end,
        flown_s=flight.settled,
        handed_over_s=flight.handed_over,
        best_after_s=found.after.course.end if found.after is not None else best.end,
        start=whole.start,
        feasible=whole.feasible,
        tried=whole.tried + (found.after.tried if found.after is not None else 0),
        rods_best=float(ours[:3].mean()),
        rods_flown=float(theirs[:3].mean()),
        wheel_best=float(ours[3]),
        wheel_flown=float(theirs[3]),
        check_angle_deg=float(np.degrees(seen.angle)),
        check_rate_rad_s=seen.rate,
        check_gap_deg=float(np.degrees(seen.gap)),
        held_on=seen.held_on,
        seconds=found.seconds,
    )


def _keep(run: int, course: Course) -> None:
    folder = FOLDER / "optimum"
    folder.mkdir(parents=True, exist_ok=True)
    Q = course.attitudes.as_matrix()
    np.savez(folder / f"{run}.npz", times=course.times, Q=Q, Omega=course.Omega, l_w=course.l_w, u=course.u)
