"""What an FMU is made of, as one hash: an FMU is built again when it has changed."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from . import places
from .block import Block, files_of, lenders
from .kept import seen

_HERE = Path(__file__).parent


@contextmanager
def unchanging() -> Iterator[None]:
    """Within it, the files that FMUs are made of are looked at once only."""
    global _looked
    _looked = {}
    try:
        yield
    finally:
        _looked = None


_looked: dict[Path, int] | None = None


def fingerprint(block: Block, flavour: str) -> str:
    """A hash of all that an FMU is made of: files by their content, packages by their versions.

    Within a process the files are read anew only where one of their names, sizes or times has changed.
    """
    shared = hash((_state(_HERE), places.shared("LICENSE").stat().st_mtime_ns))
    if _makers.get(flavour, (None,))[0] != shared:
        _makers[flavour] = shared, _of_makers(flavour)
    seen = hash((shared, block.interface.source, _state(block.folder)))
    key = block.name, block.folder, flavour
    if key not in _known or _known[key][0] != seen:
        _known[key] = seen, _of_content(block, flavour, _makers[flavour][1].copy())
    return _known[key][1]


_makers: dict[str, tuple[int, hashlib._Hash]] = {}
_known: dict[tuple[str, Path, str], tuple[int, str]] = {}


def _state(folder: Path) -> int:
    """A number that changes with the files of a folder."""
    looked = {} if _looked is None else _looked
    if folder not in looked:
        looked[folder] = hash(tuple(seen(folder)))
    return looked[folder]


def _of_makers(flavour: str) -> hashlib._Hash:
    """Of what makes FMUs of blocks."""
    makers = [*sorted(_HERE.glob("*.py")), *sorted((_HERE / "interfaces").glob("*.svg"))]
    makers += [path for folder in sorted({"contents", "native", flavour}) for path in _files(_HERE / folder)]
    digest = hashlib.sha256()
    _add(digest, [places.shared("LICENSE"), *makers])
    return digest


def _of_content(block: Block, flavour: str, digest: hashlib._Hash) -> str:
    digest.update(block.interface.source.encode())
    _add(digest, files_of(block.folder))
    if flavour == "native":
        _add(digest, _files(block.folder / "native"))
        for owner in lenders(block.folder).values():
            _add(digest, [*_files(owner / "tables"), *_files(owner / "native")])
    for name in ("pythonfmu", "ziglang", *data_packages(block.folder)):
        digest.update(f"\n{name} {_version(name)}".encode())
    return digest.hexdigest()


def _add(digest: hashlib._Hash, paths: Iterable[Path]) -> None:
    for path in paths:
        digest.update(f"\n{path.name}\n".encode() + (path.read_bytes() if path.exists() else b""))


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")


_PACKAGES = re.compile(r"^PACKAGES = (\([^()]*\)|\[[^][]*\])", re.MULTILINE)


def data_packages(folder: Path) -> list[str]:
    """The literals `PACKAGES` of the tables of a block and of those that lend to it. Read without importing them."""
    found: dict[str, None] = {}
    for owner in (folder, *lenders(folder).values()):
        for path in (owner / "tables" / "__init__.py", owner / "native" / "tables.py"):
            for literal in _PACKAGES.findall(path.read_text("utf-8")) if path.exists() else ():
                found |= dict.fromkeys(ast.literal_eval(literal))
    return list(found)


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
