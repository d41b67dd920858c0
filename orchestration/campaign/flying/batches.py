"""Batches of runs: how runs are cut into them, what flies them, and the rows that come back in any order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
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
    check: bool = False
    """Whether they have been flown, and are flown on fresh instances to be compared."""


@dataclass(frozen=True)
class Flown:
    """The rows of a batch."""

    rows: RunRows
    batch: Batch
    pilot: str = ""
    """Who flew them one after the other on instances that were reset; "" where they were fresh for each run."""


class Batches:
    """Cuts runs into batches, as large as their measured time allows. The cut does not change what a run gives."""

    def __init__(self, indices: NDArray, points: Callable[[NDArray], Floats] | None, slots: int) -> None:
        """`points` are made here where the workers cannot draw them; `slots` batches are flown at a time."""
        self._indices, self._points, self._slots = indices, points, max(slots, 1)
        self._next, self._size, self._cost = 0, 1, 0.0
        self._checks: list[int] = []

    def next(self) -> Batch | None:
        """Returns the next batch; None where no run is left."""
        if self._checks:
            chosen = np.array(self._checks[: self._size])
            del self._checks[: self._size]
            return self._batch(chosen, True)
        left = len(self._indices) - self._next
        if left <= 0:
            return None
        n = max(
            1, min(self._size, -(-left // (2 * self._slots)))
        )  # small ones in the end, so that all workers end together
        chosen = self._indices[self._next : self._next + n]
        self._next += n
        return self._batch(chosen, False)

    def _batch(self, chosen: NDArray, check: bool) -> Batch:
        return Batch(chosen, None if self._points is None else self._points(chosen), check)

    def again(self, indices: Iterable[int]) -> None:
        """Adds runs to those that are left."""
        self._indices = np.concatenate((self._indices, np.array(list(indices), np.int64)))

    def check(self, indices: Iterable[int]) -> None:
        """Adds runs that have been flown and are to be checked next."""
        self._checks += indices

    @property
    def over(self) -> bool:
        """Returns whether no run is left to be flown or checked."""
        return self._next == len(self._indices) and not self._checks

    def took(self, count: int, seconds: float) -> None:
        """Takes note of how long a batch took."""
        cost = seconds / max(count, 1)
        self._cost = cost if self._cost == 0.0 else 0.7 * self._cost + 0.3 * cost
        wanted = int(TARGET / self._cost) if self._cost > 0.0 else _LARGEST
        self._size = max(1, min(wanted, 4 * max(self._size, count), _LARGEST))


@dataclass(frozen=True)
class Progress:
    """State of a campaign."""

    flown: int
    """Runs that are there, those of an earlier start included."""
    wanted: int
    failed: int
    fresh: int
    """Runs of this start."""
    seconds: float
    """Since its first batch was sent."""


Tell = Callable[[Progress], None]


class Crew(Protocol):
    """Those who fly batches."""

    @property
    def slots(self) -> int:
        """Returns how many batches it flies at a time."""

    anew: bool
    """Whether FMUs are instantiated for each run. What is flown after it is set obeys it."""

    def fly(self, batches: Batches) -> Iterator[Flown]:
        """Returns the rows of all batches, in any order; each batch once."""


def fly(pilot: Pilot, batch: Batch) -> RunRows:
    """Returns the rows of a batch."""
    points = pilot.job.design.points(batch.indices) if batch.points is None else batch.points
    return [pilot.fly(int(index), point) for index, point in zip(batch.indices, points, strict=True)]


def seconds(rows: RunRows) -> float:
    """Returns the wall time of the runs."""
    return sum(float(row[3] or 0.0) for row in rows)


def foreign(job: Job) -> bool:
    """Returns whether an FMU is not this project's, so that it is not known whether it resets itself."""
    return any(is_path(entry.fmu) for entry in job.opened.plan.scenario.blocks.values())
