"""A Dask cluster as the crew of a campaign: workers of this machine, or those of a scheduler elsewhere.

A worker that dies is replaced, and the batches that it had are flown again. A batch whose workers die several times is
flown by itself in the end, then run by run, and a run that ends its worker each time becomes a failed row.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import Any
from unittest.mock import patch
from uuid import uuid4

import numpy as np

from ...errors import InputError
from .batches import Batch, Batches, CrewLost, Flown, foreign, seconds
from .job import Job, lost

try:
    import dask
    from distributed import Client, KilledWorker, LocalCluster, as_completed
    from distributed.comm import get_address_host_port

    from . import worker
except ImportError as error:
    missing = error.name or "distributed"
    raise InputError(
        f"a campaign on several workers needs the package {missing.partition('.')[0]!r}; "
        "remedy: pip install 'attitude-cosim[campaign]', or --workers 0"
    ) from None

_TRIES = 3
"""So many workers may die of a batch, or of a run flown alone. A scheduler elsewhere has a number of its own."""
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
        """Returns how many runs are flown at a time; it changes as workers come and go."""
        return max(1, sum(self._client.nthreads().values()))

    def check(self) -> None:
        """Finds out whether FMUs of others come back to their first state by a reset."""
        if foreign(self._job):
            with suppress(KilledWorker):
                try:
                    self.anew = not self._client.submit(worker.resets, self._key, pure=False).result()
                except (CancelledError, OSError) as error:
                    raise _lost(error) from None

    def fly(self, batches: Batches) -> Iterator[Flown]:
        """See `Crew.fly`. Raises CrewLost."""
        pending: dict[Any, Batch] = {}
        suspects: list[Batch] = []
        arriving = as_completed(loop=self._client.loop)

        def send() -> None:
            while len(pending) < _AHEAD * self.slots and (batch := batches.next()) is not None:
                future = self._sent(batch)
                pending[future] = batch
                arriving.add(future)

        send()
        try:
            while pending:
                future = next(arriving)
                batch = pending.pop(future)
                flown = self._flown(future, batch)
                del future
                if isinstance(flown, BaseException):
                    suspects.append(batch)
                else:
                    if not batch.check:
                        batches.took(len(flown.rows), seconds(flown.rows))
                    yield flown
                send()
            for batch in suspects:
                yield from self._alone(batch)
        finally:
            self._client.cancel(list(pending))

    def _sent(self, batch: Batch) -> Any:
        return self._client.submit(worker.fly, self._key, batch, self.anew or batch.check, pure=False)

    def _flown(self, future: Any, batch: Batch) -> Flown | BaseException:
        """Returns what came of a batch, or why there is nothing. Raises CrewLost."""
        try:
            rows, pilot = future.result()
        except CancelledError:
            raise _lost("the cluster gave up a batch") from None
        except Exception as error:  # of a worker that died, or of its code
            return error
        return Flown(rows, batch, pilot)

    def _alone(self, batch: Batch) -> Iterator[Flown]:
        """Flies a batch with nothing beside it, since Dask blames all that waits at a worker that dies; then run by
        run.
        """
        flown = self._flown(self._sent(batch), batch)
        if not isinstance(flown, BaseException):
            yield flown
        elif batch.check:
            return  # a check that cannot be made shows nothing
        elif len(batch.indices) > 1:
            for i in range(len(batch.indices)):
                points = None if batch.points is None else batch.points[i : i + 1]
                yield from self._alone(Batch(batch.indices[i : i + 1], points))
        else:
            point = self._job.design.points(batch.indices)[0] if batch.points is None else batch.points[0]
            reason = f"{type(flown).__name__}: {flown}"
            if isinstance(flown, KilledWorker):
                reason = "it ended the process of its worker, each time that it was flown"
            yield Flown([lost(self._job, int(batch.indices[0]), np.asarray(point), reason)], batch)


def _lost(why: object) -> CrewLost:
    return CrewLost(f"the workers are lost: {why or 'they ended'}; the same command goes on from what is written")


@contextmanager
def cluster(
    job: Job, workers: int | None, scheduler: str | None, dashboard: bool
) -> Iterator[tuple[Cluster, list[str]]]:
    """The crew of a cluster that has been given the job, and where its dashboard is. Raises InputError."""
    key = uuid4().hex
    for name in (
        "distributed",
        "distributed.worker",
        "distributed.scheduler",
        "distributed.nanny",
        "distributed.core",
        "distributed.client",
    ):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set(_settings(dashboard)), _client(workers, scheduler, dashboard) as client:
        setup = worker.Setup(key, job)
        for left in reversed(range(_TRIES)):  # a worker that dies while it starts is replaced
            try:
                client.wait_for_workers(1, timeout=_PATIENCE)
                client.register_plugin(setup)
                break
            except OSError as error:  # among them a TimeoutError, and a connection that broke off
                if isinstance(error, TimeoutError) and scheduler is not None:
                    raise InputError(
                        f"the scheduler {scheduler} has no worker; remedy: dask worker {scheduler}"
                    ) from None
                if not left:
                    raise _lost(error) from None
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
            _, port = get_address_host_port(scheduler)  # a Client would look for a minute for what is no address
        except ValueError:
            port = 0
        if not 0 < port < 2**16:
            raise InputError(f"--scheduler {scheduler}: expected tcp://HOST:PORT")
        try:
            client = Client(scheduler, timeout=_PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"the scheduler {scheduler} cannot be reached: {error}") from None
        with client:
            yield client
        return
    with local(workers, dashboard) as cluster, Client(cluster, set_as_default=False) as client:
        yield client


def _settings(dashboard: bool) -> dict[str, Any]:
    return {
        "distributed.scheduler.allowed-failures": _TRIES - 1,
        "distributed.comm.timeouts.connect": f"{_PATIENCE:g}s",
        "distributed.admin.large-graph-warning-threshold": "1GiB",
        # Dask keeps samples of each worker's stacks of 1000 s, which grow by 0.1 MB/s; only the dashboard shows them.
        "distributed.worker.profile.enabled": dashboard,
        "distributed.admin.low-level-log-length": 1000 if dashboard else 100,  # its messages hold batches, 17 kB each
    }


@contextmanager
def local(workers: int | None = None, dashboard: bool = False) -> Iterator[Any]:
    """Worker processes of this machine, one for each core unless `workers` says how many. Raises InputError.

    Several campaigns share them, each given their `scheduler_address` as its scheduler.
    """
    if dashboard and find_spec("bokeh") is None:
        raise InputError("Dask's dashboard needs the package 'bokeh'; remedy: pip install bokeh, or no --dashboard")
    if not dashboard:  # else Dask would serve pages about itself without one, too
        dask.config.set({"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []})
    # Else workers would import a `signal.py` of the working folder. Dask sets more for them, and leaves it set.
    environment, settings = patch.dict(os.environ, PYTHONSAFEPATH="1"), dask.config.set(_settings(dashboard))
    with environment, settings, _started(workers or os.cpu_count() or 1, dashboard) as cluster:
        yield cluster


def _started(workers: int, dashboard: bool) -> LocalCluster:
    """Starts so many workers; once more where one of them dies before it has started. Raises CrewLost."""
    for left in reversed(range(_TRIES)):
        try:
            return LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": dashboard},
                silence_logs=logging.CRITICAL,
            )
        except (RuntimeError, OSError) as error:
            if not left:
                raise _lost(error) from None
    raise AssertionError


def each(function: Callable[[Any], Any], items: Iterable[Any], scheduler: str) -> Iterator[tuple[int, Any]]:
    """Yields the results of a function of each item as the workers at an address give them, each with the place of its
    item.
    """
    with Client(scheduler, timeout=_PATIENCE, set_as_default=False) as client:
        places = {client.submit(function, item, pure=False): place for place, item in enumerate(items)}
        for future in as_completed(list(places), loop=client.loop):
            yield places.pop(future), future.result()
