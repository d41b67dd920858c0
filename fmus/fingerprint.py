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
from .block import LENT, Block, files_of, lenders
from .kept import kept, seen

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


_looked: dict[Path, str] | None = None


def fingerprint(block: Block, flavour: str) -> str:
    """A hash of all that an FMU is made of: files by their content, packages by their versions.

    The files are read anew only where one of their names, sizes or times has changed, since this process or another read them.
    """
    owners = (block.folder, *(Block.named(owner).folder for owner in LENT.values()))
    license_ = places.shared("LICENSE").stat()
    files = block.name, flavour, block.interface.source, license_.st_size, license_.st_mtime_ns, _state(_HERE)
    files = *files, *(_state(folder) for folder in owners)
    if files not in _known:
        packages = kept(tuple, ("packages", files), lambda: data_packages(block.folder))
        versions = [(name, _version(name)) for name in ("pythonfmu", "ziglang", *packages)]
        _known[files] = kept(str, ("fingerprint", files, versions), lambda: _of_content(block, flavour, versions))
    return _known[files]


_known: dict[object, str] = {}


def _state(folder: Path) -> str:
    """A hash that changes with the files of a folder: their names, sizes and times."""
    looked = {} if _looked is None else _looked
    if folder not in looked:
        looked[folder] = hashlib.sha256(repr(seen(folder)).encode()).hexdigest()
    return looked[folder]


def _of_content(block: Block, flavour: str, versions: Iterable[tuple[str, str]]) -> str:
    makers = [*sorted(_HERE.glob("*.py")), *sorted((_HERE / "interfaces").glob("*.svg"))]
    makers += [path for folder in sorted({"contents", "native", flavour}) for path in _files(_HERE / folder)]
    digest = hashlib.sha256()
    _add(digest, [places.shared("LICENSE"), *makers])
    digest.update(block.interface.source.encode())
    _add(digest, files_of(block.folder))
    if flavour == "native":
        _add(digest, _files(block.folder / "native"))
        for owner in lenders(block.folder).values():
            _add(digest, [*_files(owner / "tables"), *_files(owner / "native")])
    for name, version_ in versions:
        digest.update(f"\n{name} {version_}".encode())
    return digest.hexdigest()


def _add(digest: hashlib._Hash, paths: Iterable[Path]) -> None:
    for path in paths:
        digest.update(f"\n{path.name}\n".encode() + (path.read_bytes() if path.exists() else b""))


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")


_PACKAGES = re.compile(r"^PACKAGES = (\([^()]*\)|\[[^][]*\])", re.MULTILINE)


def data_packages(folder: Path) -> tuple[str, ...]:
    """The literals `PACKAGES` of the tables of a block and of those that lend to it. Read without importing them."""
    found: dict[str, None] = {}
    for owner in (folder, *lenders(folder).values()):
        for path in (owner / "tables" / "__init__.py", owner / "native" / "tables.py"):
            for literal in _PACKAGES.findall(path.read_text("utf-8")) if path.exists() else ():
                found |= dict.fromkeys(ast.literal_eval(literal))
    return tuple(found)


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
