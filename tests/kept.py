"""What the tests compile, kept in out/tests/ by a hash of all that it is made of. One process compiles, the others wait."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

from filelock import FileLock

from fmus import places

FOLDER = places.work() / "tests"


def kept(name: str, made_of: Iterable[str | Path], make: Callable[[Path], object]) -> Path:
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
