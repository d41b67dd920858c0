"""One hash of all sources of an FMU: an FMU is built again when it has changed. Tests: tests/fmus/test_build.py."""

from __future__ import annotations

import ast
import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar, cast

from . import places
from .block import Block, files_of, inside, is_block, lenders, natives
from .kept import kept, seen
from .versions import version_of

T = TypeVar("T")

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


_looked: dict[object, str] | None = None


def fingerprint(block: Block, flavour: str) -> str:
    """A hash of all that an FMU is made of: files by their content, packages by their versions.

    The files are read anew only where one of their names, sizes or times has changed, since this process or another
    read them.
    """
    there = [path.stat() for path in map(places.shared, _SHARED) if path.exists()]
    shared = tuple((file.st_size, file.st_mtime_ns) for file in there)
    within = inside(block.folder)
    other = None if within is None else (within.interface.source, _state(within.folder))
    own = block.name, flavour, block.interface.source, shared, _state(_HERE, flavour), _state(block.folder), other
    owners = _remembered(("owners", own), tuple, lambda: tuple(lenders(block.folder).values()))
    files = own, *map(_state, owners)
    packages = _remembered(("packages", files), list, lambda: data_packages(block.folder))
    versions = [(name, version_of(name) or "none") for name in ("pythonfmu", "ziglang", *packages)]
    return _remembered(("fingerprint", files, *versions), str, lambda: _of_content(block, flavour, versions))


def _remembered(made_of: object, kind: type[T], make: Callable[[], T]) -> T:
    """Returns what `make` gives for the same sources, from this process or from disk."""
    if made_of not in _known:
        _known[made_of] = kept(kind, made_of, make)
    return cast(T, _known[made_of])


_known: dict[object, object] = {}


def _state(folder: Path, flavour: str = "") -> str:
    """A hash that changes with the files of a block's folder, or, with a flavour, of those here that make
    it, as `seen` has them."""
    looked = {} if _looked is None else _looked
    key = folder, flavour
    if key not in looked:
        files = seen(folder, lambda inside, names: _makes(inside, flavour) if flavour else not is_block(names))
        if _states.get(key, (None,))[0] != files:
            _states[key] = files, hashlib.sha256(repr(files).encode()).hexdigest()
        looked[key] = _states[key][1]
    return looked[key]


_states: dict[object, tuple[object, str]] = {}


def _makes(folder: str, flavour: str) -> bool:
    """Returns whether FMUs of this flavour are made by what stands in a folder of this package."""
    return folder[len(str(_HERE)) + 1 :].partition(os.sep)[0] in (*_ALWAYS, "interfaces", flavour)


_ALWAYS = "contents", "native"
_SHARED = "LICENSE", "CITATION.cff"


def _of_content(block: Block, flavour: str, versions: Iterable[tuple[str, str]]) -> str:
    makers = [*sorted(_HERE.glob("*.py")), *sorted((_HERE / "interfaces").glob("*.svg"))]
    makers += [path for folder in sorted({*_ALWAYS, flavour}) for path in _files(_HERE / folder)]
    digest = hashlib.sha256()
    _add(digest, [*map(places.shared, _SHARED), *makers])
    digest.update(block.interface.source.encode())
    _add(digest, files_of(block.folder))
    if flavour == "native":
        for native in natives(block.folder):
            _add(digest, _files(native))
        if (within := inside(block.folder)) is not None:
            digest.update(within.interface.source.encode())
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


def data_packages(folder: Path) -> list[str]:
    """The literals `PACKAGES` of the tables of a block and of those that lend to it. Read without importing them."""
    found: dict[str, None] = {}
    for owner in (folder, *lenders(folder).values()):
        for path in (owner / "tables" / "__init__.py", owner / "native" / "tables.py"):
            for literal in _PACKAGES.findall(path.read_text("utf-8")) if path.exists() else ():
                found |= dict.fromkeys(ast.literal_eval(literal))
    return list(found)
