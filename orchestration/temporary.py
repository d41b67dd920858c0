"""Folders for temporary files; what a run that was killed has left is removed by the next.

Each holds a file that its process keeps locked: the system gives a lock back when the process ends, however it ends. So
a folder whose lock is free is nobody's. On Windows, where no lock is taken, folders of killed runs stay.

Tests: tests/orchestration/test_temporary.py.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from .interrupt import held

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PREFIX = "orchestrate-"
_LOCK, _NEW = ".lock", ".lock.new"
_locks: dict[Path, int] = {}
"""The locked file of each folder of this process."""


@contextmanager
def temporary(prefix: str = PREFIX) -> Iterator[Path]:
    """Makes a folder that is removed, also where a signal comes meanwhile."""
    folder = make(prefix)
    try:
        yield folder
    finally:
        with held():
            remove(folder)


def make(prefix: str = PREFIX) -> Path:
    """Makes a folder, which `remove` takes away."""
    _clear(tempfile.gettempdir())
    with held():
        folder = Path(tempfile.mkdtemp(prefix=prefix))
        with suppress(OSError):  # a file system without locks: nobody removes the folder but this process
            _lock(folder)
    return folder


def remove(folder: Path) -> None:
    """Removes a folder of `make`, and gives its lock back; never raises."""
    _delete(folder)
    if (lock := _locks.pop(folder, None)) is not None:
        with suppress(OSError):  # an FMU has closed it
            os.close(lock)


def _lock(folder: Path) -> None:
    """Locks a new folder. The file gets its name when it is locked, so nobody meets one that is not locked yet."""
    if fcntl is None:
        return
    lock = os.open(folder / _NEW, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        (folder / _NEW).rename(folder / _LOCK)
    except OSError:
        os.close(lock)
        raise
    _locks[folder] = lock


@cache
def _clear(place: str) -> None:
    """Removes this user's folders whose process has ended; once in a process."""
    if fcntl is None:
        return
    for folder in Path(place).glob(f"{PREFIX}*"):
        with suppress(OSError):
            there = folder.lstat()
            if stat.S_ISDIR(there.st_mode) and there.st_uid == os.getuid() and _is_left(folder):
                _delete(folder)


def _delete(folder: Path) -> None:
    """Deletes the lock last, so that the next finds what is left where this is killed meanwhile."""
    with suppress(OSError):
        for entry in list(os.scandir(folder)):
            if entry.is_dir(follow_symlinks=False):
                shutil.rmtree(entry.path, ignore_errors=True)
            elif entry.name != _LOCK:
                with suppress(OSError):
                    os.unlink(entry.path)
    shutil.rmtree(folder, ignore_errors=True)


def _is_left(folder: Path) -> bool:
    """Returns whether its lock is free. Raises OSError where it has none, or another process holds it."""
    lock = os.open(folder / _LOCK, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    finally:
        os.close(lock)
    return True
