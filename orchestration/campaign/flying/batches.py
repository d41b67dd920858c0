"""Batches of runs: how runs are cut into them, what flies them, and the rows that come back in any order."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from numpy.typing import NDArray

from ...fmu.interfaces import is_path
from ...fmu.model import Floats
from .job import Job, Pilot, RunRows


class CrewLost(RuntimeError):
    """A cluster is gone. What has been written stands."""


TARGET = 0.5
"""Seconds that a batch is to take: what a scheduler needs for one, some milliseconds, is a small part of it."""
_LARGEST = 20_000


@dataclass(frozen=True)
class Batch:
    """Runs that are flown one after the other by one worker."""

    indices: NDArray
    points: Floats | None
    """Of each run (n, dimension); None where the worker draws them from the indices."""


class Batches:
    """Cuts runs into batches, as large as their measured time allows. The cut does not change what a run gives."""

    def __init__(self, indices: NDArray, points: Callable[[NDArray], Floats] | None, slots: int) -> None:
        """`points` are made here where the workers cannot draw them; `slots` is how many batches are flown at a time."""
        self._indices, self._points, self._slots = indices, points, max(slots, 1)
        self._next, self._size, self._cost = 0, 1, 0.0

    def next(self) -> Batch | None:
        """The next batch; None where no run is left."""
        left = len(self._indices) - self._next
        if left <= 0:
            return None
        n = max(
            1, min(self._size, -(-left // (2 * self._slots)))
        )  # small ones in the end, so that all workers end together
        chosen = self._indices[self._next : self._next + n]
        self._next += n
        return Batch(chosen, None if self._points is None else self._points(chosen))

    def took(self, count: int, seconds: float) -> None:
        """Takes note of how long a batch took."""
        cost = seconds / max(count, 1)
        self._cost = cost if self._cost == 0.0 else 0.7 * self._cost + 0.3 * cost
        wanted = int(TARGET / self._cost) if self._cost > 0.0 else _LARGEST
        self._size = max(1, min(wanted, 4 * max(self._size, count), _LARGEST))


class Crew(Protocol):
    """What flies batches."""

    @property
    def slots(self) -> int:
        """How many batches it flies at a time."""

    def fly(self, batches: Batches) -> Iterator[RunRows]:
        """The rows of all batches, in any order; each run once."""


def fly(pilot: Pilot, batch: Batch) -> RunRows:
    """The rows of a batch."""
    points = pilot.job.design.points(batch.indices) if batch.points is None else batch.points
    return [pilot.fly(int(index), point) for index, point in zip(batch.indices, points, strict=True)]


def seconds(rows: RunRows) -> float:
    """The wall time of the runs."""
    return sum(float(row[3] or 0.0) for row in rows)


def foreign(job: Job) -> bool:
    """Whether an FMU is not this project's, so that it is not known whether it resets itself."""
    return any(is_path(entry.fmu) for entry in job.opened.plan.scenario.blocks.values())
