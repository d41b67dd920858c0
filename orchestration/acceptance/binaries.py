"""What the binaries of an FMU export and need, read from their tables without running them.

ELF (Linux) and PE (Windows) are read here, by the layouts of their formats; of Mach-O (macOS) only that
it is there is known. Needed libraries are looked for as the loader of this machine would, on Linux.
"""

from __future__ import annotations

import ctypes.util
import platform
import re
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

FUNCTIONS = tuple(
    "fmi2" + name
    for name in (
        "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode "
        "ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean "
        "SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate "
        "GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus "
        "GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus"
    ).split()
)
"""All functions that FMI 2.0 demands of a co-simulation FMU."""
CALLED = frozenset(
    "fmi2" + name
    for name in (
        "GetTypesPlatform GetVersion Instantiate FreeInstance SetupExperiment EnterInitializationMode "
        "ExitInitializationMode Terminate GetReal GetInteger GetBoolean SetReal SetInteger SetBoolean SetString DoStep"
    ).split()
)
"""Those of them without which an FMU does not run here."""


class Unreadable(ValueError):
    """The file is no library of a kind that is understood; the message says what it is."""


@dataclass
class Library:
    """The dynamic tables of a shared library."""

    kind: str
    machine: str
    exported: set[str] = field(default_factory=set)
    undefined: set[str] = field(default_factory=set)
    """Symbols that it must find elsewhere."""
    needed: list[str] = field(default_factory=list)
    """Libraries that it asks for by name."""
    search: list[str] = field(default_factory=list)
    """Folders in which it asks for them to be looked for."""
    versions: set[str] = field(default_factory=set)
    """Versions of symbols that it needs, such as GLIBC_2.17."""


def read(data: bytes) -> Library:
    """The tables of a library. Raises Unreadable."""
    try:
        if data[:4] == b"\x7fELF":
            return _elf(data)
        if data[:2] == b"MZ":
            return _pe(data)
    except (struct.error, IndexError, ValueError) as error:
        if isinstance(error, Unreadable):
            raise
        raise Unreadable("its tables are damaged") from None
    if data[:4] in (b"\xca\xfe\xba\xbe", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe"):
        return Library("Mach-O", "")
    raise Unreadable("it is no shared library")


def _text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode("utf-8", "replace")


# ---------------------------------------------------------------- ELF

_MACHINES = {62: "x86_64", 183: "aarch64", 3: "x86", 40: "arm", 243: "riscv64"}
_DYNSYM, _DYNAMIC, _VERNEED = 11, 6, 0x6FFFFFFE
_NEEDED, _RPATH, _RUNPATH = 1, 15, 29


def _elf(data: bytes) -> Library:
    if data[4] != 2 or data[5] != 1:
        raise Unreadable("it is an ELF library of 32 bits or of the other byte order")
    kind, machine = struct.unpack_from("<HH", data, 16)
    if kind != 3:
        raise Unreadable("it is an ELF file, but no shared library")
    (offset,) = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    # name, type, flags, addr, offset, size, link, info, align, entsize
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, offset + i * size) for i in range(count)]
    library = Library("ELF", _MACHINES.get(machine, str(machine)))
    for section in sections:
        strings = sections[section[6]][4] if section[6] < len(sections) else 0
        if section[1] == _DYNSYM:
            _elf_symbols(data, section, strings, library)
        elif section[1] == _DYNAMIC:
            _elf_dynamic(data, section, strings, library)
        elif section[1] == _VERNEED:
            _elf_versions(data, section, strings, library)
    return library


def _elf_symbols(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    for start in range(section[4] + 24, section[4] + section[5], 24):
        name, info, other, index, _, _ = struct.unpack_from("<IBBHQQ", data, start)
        text = _text(data, strings + name)
        weak = info >> 4 == 2
        if index == 0:
            if not weak and text:
                library.undefined.add(text)
        elif other & 3 in (0, 3):  # default or protected visibility
            library.exported.add(text)


def _elf_dynamic(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    for start in range(section[4], section[4] + section[5], 16):
        tag, value = struct.unpack_from("<QQ", data, start)
        if tag == _NEEDED:
            library.needed.append(_text(data, strings + value))
        elif tag in (_RPATH, _RUNPATH):
            library.search += _text(data, strings + value).split(":")


def _elf_versions(data: bytes, section: tuple[int, ...], strings: int, library: Library) -> None:
    at = section[4]
    for _ in range(section[7]):
        _, count, _, first, following = struct.unpack_from("<HHIII", data, at)
        entry = at + first
        for _ in range(count):
            _, _, _, name, after = struct.unpack_from("<IHHII", data, entry)
            library.versions.add(_text(data, strings + name))
            entry += after
        at += following


# ---------------------------------------------------------------- PE


def _pe(data: bytes) -> Library:
    (header,) = struct.unpack_from("<I", data, 60)
    if data[header : header + 4] != b"PE\0\0":
        raise Unreadable("it is no Windows library")
    machine, count = struct.unpack_from("<HH", data, header + 4)
    optional, magic = header + 24, struct.unpack_from("<H", data, header + 24)[0]
    directories = optional + (112 if magic == 0x20B else 96)
    sections = optional + struct.unpack_from("<H", data, header + 20)[0]
    spans = [struct.unpack_from("<IIII", data, sections + 40 * i + 8) for i in range(count)]

    def place(address: int) -> int:
        for size, start, raw_size, raw in spans:
            if start <= address < start + max(size, raw_size):
                return address - start + raw
        raise Unreadable("its tables are damaged")

    library = Library("PE", {0x8664: "x86_64", 0xAA64: "aarch64", 0x14C: "x86"}.get(machine, hex(machine)))
    exports, imports = (struct.unpack_from("<I", data, directories + 8 * i)[0] for i in range(2))
    if exports:
        table = place(exports)
        number, names = struct.unpack_from("<I", data, table + 24)[0], struct.unpack_from("<I", data, table + 32)[0]
        for i in range(number):
            (name,) = struct.unpack_from("<I", data, place(names) + 4 * i)
            library.exported.add(_text(data, place(name)))
    if imports:
        at = place(imports)
        while name := struct.unpack_from("<I", data, at + 12)[0]:
            library.needed.append(_text(data, place(name)))
            at += 20
    return library


# ---------------------------------------------------------------- what a library asks for, on Linux


@dataclass
class Unresolved:
    """What the loader of this machine would not find."""

    libraries: list[str] = field(default_factory=list)
    symbols: list[str] = field(default_factory=list)
    versions: list[str] = field(default_factory=list)
    host: list[str] = field(default_factory=list)
    """Symbols of Python, which this process has but another may not."""


def unresolved(library: Library, beside: dict[str, bytes]) -> Unresolved:
    """What a library of this machine would not find; `beside` are the files that lie in its folder."""
    found = Unresolved()
    if library.kind != "ELF" or not sys.platform.startswith("linux"):
        return found
    known, pending, seen = set(library.exported), list(library.needed), set(library.needed)
    while pending:
        name = pending.pop()
        inner = _needed(name, library.search, beside)
        if inner is None:
            found.libraries.append(name)
            continue
        known |= inner.exported
        fresh = [n for n in inner.needed if n not in seen]
        seen.update(fresh)
        pending += fresh
    if not found.libraries:  # without one of them nothing can be said of symbols
        left = sorted(library.undefined - known)
        found.host = [name for name in left if re.match(r"_?Py[A-Z_]", name)]
        found.symbols = [name for name in left if name not in found.host and name not in _OF_THE_LOADER]
    have = _version(platform.libc_ver()[1]) if platform.libc_ver()[0] == "glibc" else None
    for name in sorted(library.versions):
        if have and name.startswith("GLIBC_") and (wanted := _version(name[6:])) and wanted > have:
            found.versions.append(name)
    return found


_OF_THE_LOADER = {"__tls_get_addr", "_dl_find_object", "__gmon_start__"}


def _version(text: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", text))) if re.fullmatch(r"\d+(\.\d+)*", text) else ()


def _needed(name: str, search: list[str], beside: dict[str, bytes]) -> Library | None:
    if any("$ORIGIN" in folder or "${ORIGIN}" in folder for folder in search) and name in beside:
        return _read_or_empty(beside[name])
    for folder in [f for f in search if f.startswith("/")]:
        if (Path(folder) / name).exists():
            return _library_at(Path(folder) / name)
    path = _system_library(name)
    return None if path is None else _library_at(path)


def _read_or_empty(data: bytes) -> Library:
    try:
        return read(data)
    except Unreadable:
        return Library("", "")


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
    import os

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
