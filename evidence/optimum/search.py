"""The shortest motion that the optimiser finds: local minima from several courses, and the best of them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..flight.cases import RATE
from .courses import Course, of
from .flown import Flight
from .motion import Motion
from .problem import ANGLE, Grid
from .transcription import Solution, solve

SLACK = 1.1
"""T is sought up to so many times the time flown."""
SIMPLE = 3
"""Ways without a turn more."""


@dataclass(frozen=True)
class Found:
    """A feasible motion."""

    solution: Solution
    start: str
    """The course that it came from."""

    @property
    def course(self) -> Course:
        return of(self.solution)


@dataclass(frozen=True)
class Optimum:
    """The best motion of a tumble."""

    wholes: list[Found]
    """From its start, the shortest first."""
    tried: int
    """Starts of these."""
    after: Found | None
    """From the flown motion at the hand-over; None where the plan has it from the start."""
    seconds: float
    """Of processor time."""


def search(flight: Flight, grid: Grid) -> Optimum:
    """Returns what is found from WIDE starts or more, or from ten where the guess is short.

    After a hand-over the short problem from there is solved first. Its best, after the flown steering, is one of the
    starts.
    """
    began = time.process_time()
    short = math.isfinite(grid.guess)
    motion = Motion(flight.plant, SLACK * (max(flight.course.end, grid.guess) if short else flight.course.end))
    after = search_after(flight, grid)
    course = flight.course.within(grid.guess)
    starts = list(_ways(motion, course))
    if short:
        starts[SIMPLE:] = [("flown, sooner", course.within(0.5 * course.end))]
    starts += _turned(motion, "straight", course.straight(motion.turn))
    if after is not None:
        begin = flight.handed_over
        starts.append((f"steering as flown, then {after.start}", flight.course.then(begin, after.course)))
    return Optimum(_found(motion, starts, grid), len(starts), after, time.process_time() - began)


def search_after(flight: Flight, grid: Grid) -> Found | None:
    """The best found from the flown motion at the hand-over; None where the plan has it from the start, or nothing is
    feasible."""
    if not flight.handed_over > 0.0:
        return None
    motion = Motion(flight.plant, SLACK * (flight.course.end - flight.handed_over), flight.handed_over)
    return next(iter(_found(motion, _ways(motion, flight.course.late(flight.handed_over)), grid)), None)


def refined(flight: Flight, found: Found, grid: Grid) -> Found | None:
    """The same at a finer grid; None where that is not feasible."""
    motion = Motion(flight.plant, SLACK * flight.course.end)
    solution = solve(motion.task(ANGLE, RATE), found.course.guess(grid))
    return replace(found, solution=solution) if solution.feasible else None


def _ways(motion: Motion, flown: Course) -> Iterator[tuple[str, Course]]:
    yield "flown", flown
    yield "straight", flown.straight(motion.turn)
    yield "the other way round", flown.straight(motion.turn, 1)
    yield from _turned(motion, "flown", flown)


def _turned(motion: Motion, name: str, course: Course) -> Iterator[tuple[str, Course]]:
    """A course with one turn more, either way about each body axis."""
    for i, axis in enumerate(np.eye(3), 1):
        for way, sign in (("about", 1.0), ("against", -1.0)):
            yield f"{name} with a turn {way} e{i}", course.turned(sign * axis, motion.turn)


def _found(motion: Motion, starts: Iterable[tuple[str, Course]], grid: Grid) -> list[Found]:
    """The feasible motions, the shortest first."""
    task = motion.task(ANGLE, RATE)
    found = [Found(solve(task, course.guess(grid)), name) for name, course in starts]
    return sorted((one for one in found if one.solution.feasible), key=lambda one: one.solution.time)
