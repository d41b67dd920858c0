"""The part of a campaign that runs in a worker of a Dask cluster: it takes in a job with its FMUs once, and then flies
batches of it.
"""

from __future__ import annotations

import hashlib
import pickle
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from distributed import WorkerPlugin

from ...errors import BlockError, InputError
from .batches import Batch
from .batches import fly as fly_batch
from .job import Job, Pilot, RunRows


class Given:
    """A job that this worker was given, and its pilots: one for each thread, since an instance of an FMU serves one."""

    def __init__(self, job: Job, folder: Path) -> None:
        """`folder` holds the job's FMUs that this machine had not; it goes with the pilots."""
        self._job, self._folder = job, folder
        self._pilots: dict[tuple[int, bool], Pilot] = {}
        self._lock, self._flying, self._ended = threading.Lock(), 0, False

    @contextmanager
    def pilot(self, anew: bool) -> Iterator[Pilot]:
        """The pilot of this thread. Raises RuntimeError where the job has ended."""
        with self._lock:
            if self._ended:
                raise RuntimeError("the campaign has ended")
            self._flying += 1
        try:
            own = threading.get_ident(), anew
            if own not in self._pilots:
                self._pilots[own] = Pilot(self._job, anew)
            yield self._pilots[own]
        finally:
            with self._lock:
                self._flying -= 1
            self._close()

    def end(self) -> None:
        """Ends the FMUs: now, or where threads are flying, when the last of them is done."""
        self._ended = True
        self._close()

    def _close(self) -> None:
        with self._lock:
            if not self._ended or self._flying:
                return
            while self._pilots:
                self._pilots.popitem()[1].close()
            shutil.rmtree(self._folder, ignore_errors=True)


_given: dict[str, Given] = {}
"""By the keys of the jobs."""


class Setup(WorkerPlugin):
    """Hands a job to every worker, also to one that takes the place of another that died."""

    idempotent = True

    def __init__(self, key: str, job: Job) -> None:
        self.key, self.name = key, f"campaign-{key}"
        self.version = version("attitude-cosim")
        self.fmus = {fmu.sha256: fmu.path.read_bytes() for fmu in job.opened.fmus.values()}
        self.paths = {fmu.sha256: str(fmu.path) for fmu in job.opened.fmus.values()}
        self.job = pickle.dumps(job)

    def setup(self, worker: Any) -> None:
        """Unpacks the job. Raises RuntimeError where the worker has another version of this program."""
        if (own := version("attitude-cosim")) != self.version:
            raise RuntimeError(f"this worker has attitude-cosim {own}, expected {self.version} as in the client")
        with suppress(ValueError):  # in a thread beside the main one
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the client, which then ends its workers
        folder = Path(tempfile.mkdtemp(prefix="campaign-", dir=worker.local_directory))
        files = {}
        for sha256, content in self.fmus.items():
            path = Path(self.paths[sha256])
            if not _is(path, sha256):
                path = folder / sha256 / path.name
                path.parent.mkdir()
                path.write_bytes(content)
            files[sha256] = path
        _given[self.key] = Given(pickle.loads(self.job).placed(files), folder)

    def teardown(self, worker: Any) -> None:
        """Ends the FMUs of this job. It waits for no run: Dask calls it in the loop that answers the scheduler."""
        if (given := _given.pop(self.key, None)) is not None:
            given.end()


def _is(path: Path, sha256: str) -> bool:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == sha256
    except OSError:
        return False


def _of(key: str) -> Given:
    if key not in _given:
        raise RuntimeError("this worker has not been given the campaign")
    return _given[key]


def fly(key: str, batch: Batch, anew: bool) -> tuple[RunRows, str]:
    """Returns the rows of a batch of the job under this key, and the name of the pilot that resets its FMUs."""
    with _of(key).pilot(anew) as pilot:
        return fly_batch(pilot, batch), "" if anew else pilot.name


def resets(key: str) -> bool:
    """Returns whether a reset brings the FMUs back to their first state."""
    try:
        with _of(key).pilot(False) as pilot:
            return pilot.resets()
    except (BlockError, InputError):
        return True  # whatever it is, the runs will say it
