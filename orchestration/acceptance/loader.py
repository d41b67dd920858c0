"""Finds what the loader of this machine would not find for a library, on Linux.

Tests: tests/orchestration/acceptance/test_check.py.
"""

from __future__ import annotations

import ctypes.util
import os
import platform
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from .binaries import Library, Unreadable, read


@dataclass
class Unresolved:
    """Libraries, symbols and versions that the loader of this machine would not find."""

    libraries: list[str] = field(default_factory=list)
    symbols: list[str] = field(default_factory=list)
    versions: list[str] = field(default_factory=list)
    host: list[str] = field(default_factory=list)
    """Symbols of Python, which this process has but another may not."""


def unresolved(library: Library, beside: dict[str, Path]) -> Unresolved:
    """Returns what a library of this machine would not find; `beside` are the files that lie in its folder."""
    left = Unresolved()
    if library.kind != "ELF" or not sys.platform.startswith("linux"):
        return left
    known, pending, seen = set(library.exported), list(library.needed), set(library.needed)
    while pending:
        name = pending.pop()
        inner = _needed(name, library.search, beside)
        if inner is None:
            left.libraries.append(name)
            continue
        known |= inner.exported
        fresh = [n for n in inner.needed if n not in seen]
        seen.update(fresh)
        pending += fresh
    if not left.libraries:  # without one of them nothing can be said of symbols
        symbols = sorted(library.undefined - known)
        left.host = [name for name in symbols if re.match(r"_?Py[A-Z_]", name)]
        left.symbols = [name for name in symbols if name not in left.host and name not in _OF_THE_LOADER]
    have = _version(platform.libc_ver()[1]) if platform.libc_ver()[0] == "glibc" else None
    for name in sorted(library.versions):
        if have and name.startswith("GLIBC_") and (wanted := _version(name[6:])) and wanted > have:
            left.versions.append(name)
    return left


_OF_THE_LOADER = {"__tls_get_addr", "_dl_find_object", "__gmon_start__", "calloc", "free", "malloc", "realloc"}
"""With what every process has, since its C library has it: a library of either C library asks for memory so."""


def _version(text: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", text))) if re.fullmatch(r"\d+(\.\d+)*", text) else ()


def _needed(name: str, search: list[str], beside: dict[str, Path]) -> Library | None:
    if any("$ORIGIN" in folder or "${ORIGIN}" in folder for folder in search) and name in beside:
        return _read_or_empty(beside[name].read_bytes())
    for folder in [f for f in search if f.startswith("/")]:
        if (Path(folder) / name).exists():
            return _library_at(Path(folder) / name)
    path = _system_library(name)
    return None if path is None else _library_at(path)


def _read_or_empty(data: bytes) -> Library:
    try:
        return read(data)
    except Unreadable:
        return Library("")


@lru_cache(maxsize=64)
def _library_at(path: Path) -> Library:
    return _read_or_empty(path.read_bytes())


@lru_cache(maxsize=64)
def _system_library(name: str) -> Path | None:
    for folder in _folders():
        if (folder / name).exists():
            return folder / name
    short = re.fullmatch(r"lib(.+?)\.so.*", name)
    other = ctypes.util.find_library(short[1]) if short else None
    return Path(other) if other and Path(other).is_absolute() else None


def _folders() -> Iterator[Path]:
    yield from (Path(f) for f in os.environ.get("LD_LIBRARY_PATH", "").split(":") if f)
    for file in [Path("/etc/ld.so.conf"), *sorted(Path("/etc/ld.so.conf.d").glob("*.conf"))]:
        if file.exists():
            yield from (Path(line.strip()) for line in file.read_text().splitlines() if line.startswith("/"))
    machine = platform.machine()
    for folder in (
        f"/lib/{machine}-linux-gnu",
        f"/usr/lib/{machine}-linux-gnu",
        "/lib64",
        "/usr/lib64",
        "/lib",
        "/usr/lib",
    ):
        yield Path(folder)
