"""A Dask cluster as the crew of a campaign: workers of this machine, or those of a scheduler elsewhere.

A worker that dies is replaced, and the batches that it had are flown again. A batch whose workers die several times is flown run by
run, and a run that ends its workers again and again becomes a failed row.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import Any
from uuid import uuid4

import numpy as np

from ..errors import InputError
from .crew import Batch, Batches, CrewLost, foreign, seconds
from .job import Job, Rows, lost

try:
    import dask
    from distributed import Client, KilledWorker, LocalCluster, as_completed

    from . import worker
except ImportError as error:
    missing = error.name or "distributed"
    raise InputError(
        f"a campaign on several workers needs the package {missing.partition('.')[0]!r}; "
        "remedy: pip install 'attitude-cosim[campaign]', or --workers 0"
    ) from None

_TRIES = 3
"""So many workers may die of a batch before it is flown run by run, and of a run before it counts as failed."""
_AHEAD = 2
"""Batches in flight for each that can be flown at a time, so that no worker waits for the next."""
_PATIENCE = 30.0
"""Seconds in which a scheduler has to answer, and to have a worker."""


class Cluster:
    """The workers of a client's cluster."""

    def __init__(self, client: Any, key: str, job: Job) -> None:
        self._client, self._key, self._job = client, key, job
        self.anew = False
        """Whether FMUs are instantiated for each run."""

    @property
    def slots(self) -> int:
        """How many runs are flown at a time; it changes as workers come and go."""
        return max(1, sum(self._client.nthreads().values()))

    def check(self) -> None:
        """Finds out whether FMUs of others come back to their first state by a reset."""
        if foreign(self._job):
            with suppress(KilledWorker):
                self.anew = not self._client.submit(worker.resets, self._key, pure=False).result()

    def fly(self, batches: Batches) -> Iterator[Rows]:
        """See `Crew.fly`. Raises CrewLost."""
        pending: dict[Any, Batch] = {}
        again: list[Batch] = []
        arriving = as_completed(loop=self._client.loop)

        def send() -> None:
            while len(pending) < _AHEAD * self.slots:
                batch = again.pop() if again else batches.next()
                if batch is None:
                    return
                future = self._client.submit(worker.fly, self._key, batch, self.anew, pure=False)
                pending[future] = batch
                arriving.add(future)

        send()
        try:
            while pending:
                future = next(arriving)
                batch = pending.pop(future)
                if future.status == "finished":
                    rows: Rows = future.result()
                    batches.took(len(rows), seconds(rows))
                    yield rows
                elif future.status == "error":
                    rows = self._failed(batch, future.exception(), again)
                    if rows:
                        yield rows
                else:
                    raise CrewLost(
                        f"the cluster gave up a batch ({future.status}); the same command goes on from what is written"
                    )
                del future
                send()
        finally:
            self._client.cancel(list(pending))

    def _failed(self, batch: Batch, error: BaseException, again: list[Batch]) -> Rows:
        """What becomes of a batch that gave no rows: its runs one by one, or the failed row of the only one."""
        count = len(batch.indices)
        if count > 1:
            parts = [
                (batch.indices[i : i + 1], batch.points[i : i + 1] if batch.points is not None else None)
                for i in range(count)
            ]
            again += [Batch(indices, points) for indices, points in parts]
            return []
        reason = f"{type(error).__name__}: {error}"
        if isinstance(error, KilledWorker):
            reason = f"its worker died {_TRIES} times"
        index = int(batch.indices[0])
        point = self._job.design.points([index])[0] if batch.points is None else batch.points[0]
        return [lost(self._job, index, np.asarray(point), reason)]


@contextmanager
def cluster(
    job: Job, workers: int | None, scheduler: str | None, dashboard: bool
) -> Iterator[tuple[Cluster, list[str]]]:
    """The crew of a cluster that has been given the job, and where its dashboard is. Raises InputError."""
    key = uuid4().hex
    for name in ("distributed", "distributed.worker", "distributed.scheduler", "distributed.nanny", "distributed.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    settings = {
        "distributed.scheduler.allowed-failures": _TRIES - 1,
        "distributed.comm.timeouts.connect": f"{_PATIENCE:g}s",
        "distributed.admin.large-graph-warning-threshold": "1GiB",
    }
    with dask.config.set(settings), _client(workers, scheduler, dashboard) as client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError:
            raise InputError(
                f"the scheduler {scheduler or ''} has no worker; remedy: dask worker {scheduler or 'ADDRESS'}"
            ) from None
        setup = worker.Setup(key, job)
        try:
            client.register_plugin(setup)
        except Exception as error:
            raise InputError(f"a worker cannot take in the campaign: {type(error).__name__}: {error}") from None
        crew = Cluster(client, key, job)
        try:
            crew.check()
            yield crew, [f"dashboard: {client.dashboard_link}"] if dashboard else []
        finally:
            with suppress(Exception):  # a cluster that is gone
                client.unregister_worker_plugin(setup.name)


@contextmanager
def _client(workers: int | None, scheduler: str | None, dashboard: bool) -> Iterator[Any]:
    if scheduler is not None:
        try:
            client = Client(scheduler, timeout=_PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"the scheduler {scheduler} cannot be reached: {error}") from None
        with client:
            yield client
        return
    if dashboard and find_spec("bokeh") is None:
        raise InputError("Dask's dashboard needs the package 'bokeh'; remedy: pip install bokeh, or no --dashboard")
    local = LocalCluster(
        n_workers=workers or os.cpu_count() or 1,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0" if dashboard else None,
        worker_dashboard_address=None,
        silence_logs=logging.CRITICAL,
    )
    with local, Client(local, set_as_default=False) as client:
        yield client
