"""Keeps on disk what takes long to read, so that the next process need not read it again.

Each file is named by a hash of all that it is made of, the code that makes it included, and is never out of date. It is
a pickle beside the libraries that are built: who can write there can run code here anyway.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from . import places

T = TypeVar("T")

_FILES_MAX = 200


def kept(kind: type[T], made_of: object, make: Callable[[], T], folder: str = "kept") -> T:
    """Returns what `make` gives, of this type, from disk where an earlier process made it of the same.

    `made_of` shows by its repr all that the result depends on. What cannot be read is made, and what cannot be written
    is made again by the next process.
    """
    key = repr((sys.platform, sys.version, kind.__module__, kind.__qualname__, made_of))
    path = places.work() / folder / f"{hashlib.sha256(key.encode()).hexdigest()}.pickle"
    found = _read(path)
    if isinstance(found, kind):
        return found
    value = make()
    with suppress(OSError):
        _write(path, pickle.dumps(value, pickle.HIGHEST_PROTOCOL))
    return value


def seen(
    folder: str | Path, counts: Callable[[str, list[str]], bool] = lambda folder, names: True
) -> list[tuple[str, int, int]]:
    """Name, size and time of each file in a folder, which tell whether they have changed.

    `counts`: whether a folder in it counts, of its path and the names in it.
    """
    files, folders = [], [str(folder)]
    for inside in folders:  # which grows meanwhile
        with os.scandir(inside) as listing:
            entries = list(listing)
        if inside is not folders[0] and not counts(inside, [entry.name for entry in entries]):
            continue
        for entry in entries:
            if not entry.is_dir():
                status = entry.stat()
                files.append((entry.path, status.st_size, status.st_mtime_ns))
            elif entry.name != "__pycache__":
                folders.append(entry.path)
    return files


@cache
def code(*folders: Path) -> list[tuple[str, int, int]]:
    """Returns what `seen` says at the first call of the files in these folders, whose code makes what is kept."""
    return [file for folder in folders for file in seen(folder)]


def _read(path: Path) -> Any:
    """None where there is no such file, or a damaged one."""
    try:
        return pickle.loads(path.read_bytes())
    except Exception:  # pickle raises what it pleases
        return None


def _write(path: Path, data: bytes) -> None:
    """Writes a temporary file and renames it, so that another process never reads an incomplete one;
    keeps the latest files."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(".tmp", dir=path.parent)
    with os.fdopen(descriptor, "wb") as file:
        file.write(data)
    os.replace(name, path)
    for old in sorted(path.parent.iterdir(), key=lambda file: file.stat().st_mtime_ns)[:-_FILES_MAX]:
        old.unlink(missing_ok=True)
