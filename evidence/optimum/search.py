"""The shortest motion that the optimiser finds: local minima from several courses, and the best of them."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..flight.cases import RATE
from .courses import Course, of
from .flown import Flight
from .motion import Motion
from .problem import ANGLE, FINE
from .transcription import Solution, solve

SLACK = 1.1
"""T is sought up to so many times the time flown."""

_SENSES = (("about", 1.0), ("against", -1.0))


@dataclass(frozen=True)
class Found:
    """The best of some solutions."""

    solution: Solution
    start: str
    """The course that it came from."""
    feasible: int
    tried: int

    @property
    def course(self) -> Course:
        return of(self.solution)


@dataclass(frozen=True)
class Optimum:
    """Of a tumble."""

    whole: Found
    """From its start."""
    after: Found | None
    """From the flown motion at the hand-over; None where the plan has it from the start."""
    seconds: float
    """Of processor time."""


def search(flight: Flight) -> Optimum | None:
    """The best found; None without a feasible motion.

    After a hand-over the short problem from there is solved first. Its best, after the flown steering, is one of the
    starts.
    """
    began = time.process_time()
    flown, handed_over = flight.course, flight.handed_over
    motion = Motion(flight.plant, SLACK * flown.end)
    starts = [("flown", flown)]
    after = search_after(flight)
    if handed_over > 0.0:
        if after is not None:
            starts = [(f"steering as flown, then {after.start}", flown.then(handed_over, after.course))]
    else:
        axis = flight.plant.wheel_axes[0]
        starts = list(_ways(motion, flown))
        starts += [(f"flown with a turn {way} the wheel", flown.turned(v * axis, motion.turn)) for way, v in _SENSES]
    whole = _best(motion, starts)
    if whole is None and handed_over > 0.0:
        whole = _best(motion, [("flown", flown)])
    return None if whole is None else Optimum(whole, after, time.process_time() - began)


def search_after(flight: Flight) -> Found | None:
    """The best found from the flown motion at the hand-over; None where the plan has it from the start, or nothing is
    feasible."""
    if not flight.handed_over > 0.0:
        return None
    motion = Motion(flight.plant, SLACK * (flight.course.end - flight.handed_over), flight.handed_over)
    return _best(motion, _ways(motion, flight.course.late(flight.handed_over)))


def again(flight: Flight, best: Course) -> Found | None:
    """From the best so far with one turn more, either way about each body axis; None where none of it is feasible."""
    motion = Motion(flight.plant, SLACK * best.end)
    return _best(
        motion,
        [
            (f"the best with a turn {way} e{i}", best.turned(sign * axis, motion.turn))
            for i, axis in enumerate(np.eye(3), 1)
            for way, sign in _SENSES
        ],
    )


def refined(flight: Flight, found: Found) -> Found | None:
    """The same with intervals of at most FINE; None where that is not feasible."""
    motion = Motion(flight.plant, SLACK * flight.course.end)
    solution = solve(motion.task(ANGLE, RATE), found.course.guess(FINE))
    return Found(solution, found.start, found.feasible, found.tried) if solution.feasible else None


def _ways(motion: Motion, flown: Course) -> Iterable[tuple[str, Course]]:
    yield "flown", flown
    yield "straight", flown.straight(motion.turn)
    yield "the other way round", flown.straight(motion.turn, 1)


def _best(motion: Motion, starts: Iterable[tuple[str, Course]]) -> Found | None:
    task = motion.task(ANGLE, RATE)
    found = [(name, solve(task, course.guess())) for name, course in starts]
    feasible = [(name, solution) for name, solution in found if solution.feasible]
    if not feasible:
        return None
    name, solution = min(feasible, key=lambda pair: pair[1].time)
    return Found(solution, name, len(feasible), len(found))
