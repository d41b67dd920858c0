"""What runs in a worker of a Dask cluster: it takes in a job with its FMUs once, and then flies batches of it."""

from __future__ import annotations

import hashlib
import pickle
import signal
import tempfile
import threading
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from distributed import WorkerPlugin

from ...errors import BlockError, InputError
from .crew import Batch
from .crew import fly as fly_batch
from .job import Job, Pilot, Rows

_jobs: dict[str, Job] = {}
"""By their keys."""
_mine = threading.local()
"""The pilots of a thread, by key; an instance of an FMU serves one thread."""
_pilots: list[Pilot] = []


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
        _jobs[self.key] = pickle.loads(self.job).placed(files)

    def teardown(self, worker: Any) -> None:
        """Ends the FMUs."""
        _jobs.pop(self.key, None)
        while _pilots:
            _pilots.pop().close()


def _is(path: Path, sha256: str) -> bool:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == sha256
    except OSError:
        return False


def _pilot(key: str, anew: bool) -> Pilot:
    known: dict[tuple[str, bool], Pilot] = _mine.__dict__.setdefault("pilots", {})
    if (key, anew) not in known:
        if key not in _jobs:
            raise RuntimeError("this worker has not been given the campaign")
        known[key, anew] = Pilot(_jobs[key], anew)
        _pilots.append(known[key, anew])
    return known[key, anew]


def fly(key: str, batch: Batch, anew: bool) -> Rows:
    """The rows of a batch of the job under this key."""
    return fly_batch(_pilot(key, anew), batch)


def resets(key: str) -> bool:
    """Whether a reset brings the FMUs back to their first state."""
    try:
        return _pilot(key, False).resets()
    except (BlockError, InputError):
        return True  # whatever it is, the runs will say it
