"""The crew of a campaign: this process, or the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from .batches import Batches, Crew, Flown, fly, foreign, seconds
from .job import Job, Pilot


class Here:
    """This process, one run after the other."""

    slots = 1

    def __init__(self, job: Job, anew: bool) -> None:
        self.anew = anew
        self._pilots = {anew: Pilot(job, anew) for anew in (False, True)}

    def fly(self, batches: Batches) -> Iterator[Flown]:
        """See `Crew.fly`."""
        while (batch := batches.next()) is not None:
            pilot = self._pilots[anew := self.anew or batch.check]
            rows = fly(pilot, batch)
            if not batch.check:
                batches.took(len(rows), seconds(rows))
            yield Flown(rows, batch, "" if anew else pilot.name)

    def close(self) -> None:
        """Ends the FMUs."""
        for pilot in self._pilots.values():
            pilot.close()


@contextmanager
def crew(
    job: Job, workers: int | None = None, scheduler: str | None = None, dashboard: bool = False
) -> Iterator[tuple[Crew, list[str]]]:
    """A crew, and remarks on it. `workers` 0: this process; None: one for each core, or all of the cluster at
    `scheduler`.

    Raises InputError where the scheduler cannot be reached, or Dask is not installed.
    """
    if workers == 0 and scheduler is None:
        anew = False
        if foreign(job):
            pilot = Pilot(job)
            anew = not pilot.resets()
            pilot.close()
        here = Here(job, anew)
        try:
            yield here, _remarks(anew)
        finally:
            here.close()
        return
    from .cluster import cluster  # Dask, which takes 2 s to import and is an optional package  # noqa: PLC0415

    with cluster(job, workers, scheduler, dashboard) as (many, remarks):
        yield many, [*remarks, *_remarks(many.anew)]


def _remarks(anew: bool) -> list[str]:
    return ["fmi2Reset does not bring back an FMU's first state, so FMUs are instantiated for each run"] if anew else []
