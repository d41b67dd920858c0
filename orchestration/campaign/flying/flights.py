"""The flights of a campaign: what is left is flown, rows go to the dataset, and flights on reset FMUs are checked.

Tests: tests/orchestration/campaign/flying/test_checks.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any

import numpy as np

from .batches import Batches, Crew, Progress, Tell, foreign
from .checks import Checks
from .dataset import Dataset
from .job import Job, RunRows, differing


class Flights:
    """The pilots, and the flights that have been checked."""

    def __init__(
        self,
        job: Job,
        data: Dataset,
        earlier: Mapping[str, Any],
        hire: Callable[[], Crew],
        remark: Callable[[str], None],
    ) -> None:
        """`earlier` is the manifest of an earlier start; `hire` is called when the first flight is due."""
        self._job, self._data, self._hire, self._remark = job, data, hire, remark
        self._crew: Crew | None = None
        self._there = int(data.done.sum())
        self._checks = Checks(job.design.seed, earlier.get("unchecked", ()))
        self._fresh = bool(earlier.get("fresh"))
        """Whether resets have been seen to leave something behind, so that each run has fresh instances."""

    @property
    def state(self) -> dict[str, Any]:
        """Returns the entries of the manifest that the next start needs."""
        return {"fresh": self._fresh, "unchecked": self._checks.unchecked}

    def crew(self) -> Crew:
        """Returns those who fly, hired at the first call."""
        if self._crew is None:
            self._crew = self._hire()
            self._crew.anew |= self._fresh
        return self._crew

    def up_to(self, look: int, tell: Tell | None) -> None:
        """Flies those of the first `look` runs that are not there yet."""
        data, design = self._data, self._job.design
        left = np.flatnonzero(~data.done[:look])
        if not len(left) and not self._checks.unchecked:
            return
        begun, crew = perf_counter(), self.crew()
        batches = Batches(left, design.points if design.early else None, crew.slots)
        checked = foreign(self._job) and not crew.anew
        while True:
            for flown in crew.fly(batches):
                indices = list(map(int, flown.batch.indices))
                if flown.batch.check:
                    self._compare(flown.rows, batches)
                elif checked and flown.pilot and crew.anew:  # it was sent before resets were seen to fail
                    batches.again(indices)
                else:
                    data.add(flown.rows)
                    if checked and flown.pilot:
                        batches.check(self._checks.took(flown.pilot, indices))
                if tell is not None:
                    there, failed = int(data.done.sum()), int(data.failed.sum())
                    tell(Progress(there, len(data.done), failed, there - self._there, perf_counter() - begun))
            last = self._checks.last() if checked and not crew.anew else []
            if not last and batches.over:
                break
            batches.check(last)
        data.flush()

    def _compare(self, rows: RunRows, batches: Batches) -> None:
        """Holds flights on fresh instances against those on instances that were reset. A difference ends the resets."""
        crew, names = self.crew(), [name for name, _ in self._job.columns]
        for row in rows:
            index = int(row[0] or 0)
            if crew.anew or not self._data.done[index]:
                continue
            differ = differing(names, self._data.row(index), row)
            if not differ:
                self._checks.sound(index)
                continue
            gone = self._checks.clear()
            self._data.withdraw(gone)
            batches.again(gone)
            crew.anew = self._fresh = True
            few = ", ".join(differ[:3]) + f" and {len(differ) - 3} more" * (len(differ) > 3)
            self._remark(
                f"run {index} on FMUs that were reset differs from the same run on fresh ones in {few}: fmi2Reset "
                "leaves "
                f"something behind; FMUs are instantiated for each run from now on, and {len(gone)} runs are "
                "flown again"
            )
