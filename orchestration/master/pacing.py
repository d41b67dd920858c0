"""A run paced by wall time: the instant t of a run that began at the wall time T is due at T + t / factor.

The deadlines are absolute, on a monotonic clock, so what one step is late does not move those after it: the steps that
follow are made without waiting until the run is in time again. A pause moves all deadlines that follow it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from ..errors import BlockError
from ..system.clock import Clock
from .deadlines import Late, Pace, milliseconds

_SPIN = 0.2e-3
"""Seconds before a deadline at which the sleep ends; the rest is waited for with the processor busy."""
_SLICE = 0.05
"""Seconds that a sleep lasts at most, so that Ctrl-C and the keyboard are obeyed during a long one."""
PAUSE, STEP = " p", "s."
"""The keys that pause and go on, and those that make one base step."""


class Timepiece(Protocol):
    """A monotonic clock, and a sleep on it."""

    def now(self) -> float:
        """Seconds from any instant."""

    def sleep_until(self, due: float) -> None:
        """Returns when `now` is `due` or later."""


class Monotonic:
    """The monotonic clock of this machine."""

    def __init__(
        self, now: Callable[[], float] = time.perf_counter, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        self.now, self._sleep = now, sleep

    def sleep_until(self, due: float) -> None:
        """Sleeps until shortly before, since a sleep ends some 0.1 ms late, and looks at the clock from then on."""
        if (left := due - self.now() - _SPIN) > 0.0:
            self._sleep(left)
        while self.now() < due:
            pass


class Pacer:
    """Lets a master wait after each base step until the step's end is due, and keeps count of what was late."""

    def __init__(
        self,
        factor: float = 1.0,
        tolerance: float = 2e-3,
        stop: bool = False,
        keys: Callable[[], str] | None = None,
        timepiece: Timepiece | None = None,
        priority: int | None = None,
    ) -> None:
        """`factor` simulated seconds take a second. A step is late that ends more than `tolerance` s after it is due;
        `stop`: such a step ends the run. `keys` gives the keys that were pressed since it was called last.
        """
        self._factor, self._tolerance, self._stop, self._keys = factor, tolerance, stop, keys
        self._timepiece: Timepiece = timepiece or Monotonic()
        self._priority = priority
        self._took: dict[str, float] = {}
        self._paused = self._single = False
        self.pace: Pace | None = None
        """What has been counted, from the begin of the loop on."""

    def begin(self, clock: Clock, interrupted: Sequence[int], report: Callable[[int], None]) -> None:
        """The run's time 0 is now.

        It waits no longer once `interrupted` holds something; `report` is called where a pause begins or ends.
        """
        self.pace = self._pace = Pace(self._factor, self._tolerance, self._stop, clock, self._priority)
        self._interrupted, self._report = interrupted, report
        self._late = False
        self._origin = self._resumed = self._timepiece.now()

    def timed(self, block: str, call: Callable[..., Any]) -> Callable[..., None]:
        """The call, and its time is counted as that of the block."""
        now, took = self._timepiece.now, self._took

        def make(*arguments: Any) -> None:
            begun = now()
            call(*arguments)
            took[block] = took.get(block, 0.0) + now() - begun

        return make

    def hold(self, count: int) -> None:
        """Waits until the end of base step `count` is due. Raises BlockError for a late step that ends the run."""
        now, pace = self._timepiece.now, self._pace
        done = now()
        due = self._origin + pace.clock.time(count) / pace.factor
        if not self._wait(due):
            return
        waited, lateness = done < due, now() - due
        late = pace.add(count, lateness, done - self._resumed, self._took, waited)
        self._took.clear()
        if lateness > self._tolerance and self._stop:
            raise self._error(late)
        self._press()
        if self._paused:
            self._pause(count)
        self._resumed = now()

    def _wait(self, due: float) -> bool:
        """Returns whether the wait came to its end; an interrupt ends it before."""
        now, sleep_until = self._timepiece.now, self._timepiece.sleep_until
        while (slice_ := now() + _SLICE) < due:
            if self._interrupted:
                return False
            sleep_until(slice_)
            self._press()
        if now() < due:
            sleep_until(due)
        return True

    def _press(self) -> None:
        """Obeys the keys that were pressed."""
        for key in self._keys() if self._keys else "":
            if key in PAUSE:
                self._paused = not self._paused
            elif key in STEP:
                self._single, self._paused = self._paused, True

    def _pause(self, count: int) -> None:
        """Waits until a key ends the pause or asks for one step; the next step is due one base step after that."""
        now, pace = self._timepiece.now, self._pace
        begun = now()
        self._report(count)
        while self._paused and not self._single and not self._interrupted:
            self._timepiece.sleep_until(now() + _SLICE)
            self._press()
        if self._single:
            pace.single_steps += 1
        self._single = False
        pace.pause(count, now() - begun)
        self._origin = now() - pace.clock.time(count) / pace.factor
        self._report(count)

    def _error(self, late: Late) -> BlockError:
        pace = self._pace
        due = f"{milliseconds(late.lateness)} after it was due, tolerated are {milliseconds(pace.tolerance)}"
        if late.block is None:
            problem = f"the computer woke the run {due}; remedy: fewer other programs, or a larger tolerance"
            return BlockError("master", "wait", problem, late.time)
        problem = (
            f"took {milliseconds(late.block_took)} of a base step that took {milliseconds(late.took)} and has"
            f" {milliseconds(pace.period)}; the step ended {due}; remedy: a smaller factor, or a quicker block"
        )
        return BlockError(late.block, "step", problem, late.time)

    @property
    def status(self) -> str:
        """The pace in a few words, for a bar."""
        if self._paused:
            return "paused; space goes on, s makes one step"
        pace = self.pace
        if pace is None or not pace.lateness:
            return ""
        late = f" ({pace.late_steps} steps late so far)" if pace.late_steps else ""
        return f"{pace.factor:g} s/s, {milliseconds(pace.lateness[-1])} late{late}"
