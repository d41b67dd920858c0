"""A file that is written as a whole: the new one takes the place of an earlier one, or the earlier one stays.

Tests: tests/orchestration/results/test_place.py.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

PART = ".orchestrate-part-"
"""How the names of files and folders begin that are not yet in their place."""


def put(path: Path, text: str) -> None:
    """Writes a file as `putting` does."""
    with putting(path) as part, part.open("w", encoding="utf-8", errors="backslashreplace", newline="\n") as file:
        file.write(text)


@contextmanager
def putting(path: Path) -> Iterator[Path]:
    """The path of a file to write, which takes the place of an earlier one as a whole; not where it raises. Raises
    OSError.

    A link stays, and its file is replaced; a device is written itself.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
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
