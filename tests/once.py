"""What takes long to make and is made once for all processes of the tests: one makes it, the others wait."""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

import pytest
from filelock import FileLock

from fmus import places

T = TypeVar("T")
FOLDER = places.work() / "tests"
"""What is kept from one run of the tests to the next, by a hash of all that it is made of."""


def built(name: str, made_of: Iterable[str | Path], make: Callable[[Path], object]) -> Path:
    """The path of a file of this name, which `make(path)` writes unless it is there for the same `made_of`.

    `made_of` are texts (the compiler, its options, generated sources), files, and folders with all that is in them.
    """
    digest = hashlib.sha256()
    for part in made_of:
        for item in sorted(p for p in part.rglob("*") if p.is_file()) if _is_folder(part) else (part,):
            data = item.read_bytes() if isinstance(item, Path) else item.encode()
            digest.update(f"{item.name if isinstance(item, Path) else ''} {len(data)}\n".encode() + data)
    path = FOLDER / digest.hexdigest()[:16] / name
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(path.parent / ".lock"):
            if not path.exists():
                with tempfile.TemporaryDirectory(dir=path.parent) as folder:
                    made = Path(folder, name)
                    make(made)
                    os.replace(made, path)
    return path


def _is_folder(part: str | Path) -> bool:
    return isinstance(part, Path) and part.is_dir()


def once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """A folder of this run of the tests, which `make` fills in the first process that asks."""
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:  # each worker has a folder of its own below that of the run
        root = root.parent
    folder = root / name
    with FileLock(root / f".{name}.lock"):
        if not (folder / ".made").exists():
            shutil.rmtree(folder, ignore_errors=True)  # what a failed attempt has left
            folder.mkdir()
            make(folder)
            (folder / ".made").touch()
    return folder


def computed(factory: pytest.TempPathFactory, name: str, compute: Callable[[], T]) -> T:
    """What `compute` returns, for all processes of this run of the tests; the first that asks computes it."""
    folder = once(factory, name, lambda folder: (folder / "result").write_bytes(pickle.dumps(compute())))
    result: T = pickle.loads((folder / "result").read_bytes())
    return result
