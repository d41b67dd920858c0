"""A file that is written as a whole: the new one takes the place of an earlier one, or the earlier one stays. And read
as a whole, whatever lies in its place.

Tests: tests/orchestration/results/test_place.py.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

PART = ".orchestrate-part-"
"""How the names of files and folders begin that are not yet in their place."""
BYTES_MAX = 256_000_000
"""Of a file of data that is read as a whole."""


def content(path: Path) -> bytes:
    """Returns what a file of ours holds. Raises OSError, or ValueError where it is a pipe, a device or too large."""
    if path.exists() and not path.is_file():
        raise ValueError(f"{path.name} is no regular file")
    if (size := path.stat().st_size) > BYTES_MAX:
        raise ValueError(f"{path.name} holds {size / 1e6:.3g} MB, more than {BYTES_MAX / 1e6:g}")
    return path.read_bytes()


def parsed(path: Path) -> Any:
    """Returns the data of a file of JSON. Raises OSError, or ValueError where it is none or nested too deep."""
    try:
        return json.loads(content(path).decode("utf-8"))
    except RecursionError:
        raise ValueError(f"{path.name} is nested too deep") from None


def put(path: Path, text: str) -> None:
    """Writes a file as `putting` does."""
    with putting(path) as part, part.open("w", encoding="utf-8", errors="backslashreplace", newline="\n") as file:
        file.write(text)


@contextmanager
def putting(path: Path) -> Iterator[Path]:
    """The path of a file to write, which takes the place of an earlier one as a whole; not where it raises. Raises
    OSError.

    A link stays, and its file is replaced; a device is written itself, and a pipe that somebody reads.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        if target.is_fifo():
            os.close(os.open(target, os.O_WRONLY | os.O_NONBLOCK))  # fails where nobody reads, and waits for nobody
        yield target
        return
    part = target.with_name(f"{PART}{uuid4().hex}")
    try:
        yield part
        sync(part)
        os.replace(part, target)
    except OSError as error:
        error.filename = str(path)
        raise
    finally:
        part.unlink(missing_ok=True)


def sync(path: Path) -> None:
    """Lets what was written reach the disk."""
    if os.name == "nt" and path.is_dir():
        return  # Windows opens no folders
    descriptor = os.open(path, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
