"""A thread beside the master's loop that ends an isolated FMU's process where a call of it takes too long."""

from __future__ import annotations

import threading
from math import inf
from time import monotonic

from .. import interrupt
from .process import GRACE, Process


class Watchdog:
    """Watches a process until `ended` is set."""

    def __init__(self, process: Process, timeout: float) -> None:
        self._process, self._timeout = process, timeout
        self._earlier = interrupt.latest()
        self.deadline, self.overdue = inf, False
        """When the call that runs has to be over, and whether it was not; infinite where none runs."""
        self.stop_by, self.abandoned = inf, False
        """The same for a run that is to end."""
        self.ended = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def interrupted(self) -> bool:
        """Returns whether the run has been interrupted since this began."""
        return interrupt.latest() is not self._earlier and bool(interrupt.latest())

    def _watch(self) -> None:
        """Ends the process where a call takes too long, and where it has ended but for what it has started."""
        while not self.ended.wait(min(0.2, self._timeout / 4)):
            now = monotonic()
            if self.stop_by == inf and self.interrupted():
                self.stop_by = now + GRACE
            self.abandoned = self.abandoned or (self.stop_by < now and self.deadline < inf)
            if self.abandoned or now > self.deadline:
                self.overdue = not self.abandoned
                self._process.kill()
            elif self._process.gone(0.0):
                self._process.kill_group()
