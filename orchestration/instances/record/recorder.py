"""The recorder before an FMU's library: its calls go through recorder.c, which writes them into a mapped file.

The file is complete to the last call whatever becomes of the process; calls.h describes it.
Requirement: RC-1. Tests: tests/orchestration/instances/record/test_play.py.
"""

from __future__ import annotations

import ctypes as c
import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ...errors import InputError, reason
from ...fmu.archive import Fmu
from ...fmu.model import Model
from ..compilation import compiled

FOLDER = Path(__file__).parent
FIRST = "FMI calls 1"
"""The first line of a record."""
_WINDOW = 1 << 16
"""Bytes of the window, which begins with where in the record it belongs."""
_OFFSET = struct.Struct("<Q")
_ROOM, _MEMORY = c.CFUNCTYPE(None, c.c_size_t), c.CFUNCTYPE(c.c_void_p, c.c_size_t)


class _Head(c.Structure):
    """What recorder.c's structure begins with."""

    _fields_ = (("at", c.c_void_p), ("end", c.c_void_p), ("room", _ROOM), ("memory", _MEMORY))


@dataclass(frozen=True)
class Record:
    """A record that is asked for."""

    path: Path
    head: str
    """What it says of the FMU, a line each."""


def record(path: Path, fmu: Fmu) -> Record:
    """Returns the record of an FMU's instance, whose file is made when the library is loaded. Raises InputError where
    nothing can be recorded here."""
    try:
        _library(c.CDLL)
    except (RuntimeError, OSError) as error:
        remedy = "pip install ziglang, or a C compiler"
        raise InputError(
            f"calls are recorded by a library in C, which is not there: {error}; remedy: {remedy}"
        ) from None
    lines = (FIRST, f"file {fmu.path.name}", f"sha256 {fmu.sha256}", f"library {fmu.library}", *_variables(fmu.model))
    return Record(path.absolute(), "".join(f"{line}\n" for line in lines) + "\n")


def _variables(model: Model) -> Iterator[str]:
    """The lines of the variables: type, value reference, number of values, name."""
    for variable in model.variables.values():
        if variable.native is None:
            continue
        for position, reference in enumerate(variable.references):
            size, name = (variable.size, variable.name) if variable.is_array else (1, variable.label(position))
            yield f"variable {variable.native.function} {reference} {size} {' '.join(name.splitlines())}"


@cache
def _library(kind: Any) -> c.CDLL:
    library = kind(str(compiled("recorder", FOLDER / "recorder.c", [FOLDER / "calls.h"])))
    library.recorder_size.restype = c.c_size_t
    library.recorder_name.restype = c.c_char_p
    return library


class Recorder:
    """Stands in the place of a library that is loaded.

    What is recorded goes to a small file that is mapped, `calls.tail`, and from there to the end of the record whenever
    it is full: so few pages are touched, and all of it is kept if the process ends.
    """

    def __init__(self, dll: c.CDLL, asked: Record) -> None:
        """Makes the file. Raises OSError."""
        kind: Any = type(dll)
        self._dll, self._own, self._path = dll, _library(kind), asked.path
        self._handle = dll._handle
        self._memory: list[Any] = [c.create_string_buffer(self._own.recorder_size())]
        self._head = _Head.from_buffer(self._memory[0])
        self._pointer = c.c_void_p(c.addressof(self._memory[0]))
        self._head.room, self._head.memory = _ROOM(self._room), _MEMORY(self._more)
        self._file = asked.path.open("wb", buffering=0)
        self._file.write(asked.head.encode())
        self._map(_WINDOW)
        number = 0
        while (name := self._own.recorder_name(number)) is not None:
            if name and hasattr(dll, text := name.decode()):
                self._own.recorder_take(self._pointer, number, c.cast(dll[text], c.c_void_p))
            number += 1

    def __getitem__(self, name: str) -> Any:
        """Returns the function that records; raises AttributeError for one that the library lacks."""
        self._dll[name]
        return self._own[f"recorded_{name}"]

    def next(self) -> None:
        """The instance that is made next is this one."""
        self._own.recorder_next(self._pointer)

    def _more(self, size: int) -> int:
        self._memory.append(c.create_string_buffer(size))
        return c.addressof(self._memory[-1])

    def _map(self, size: int) -> None:
        """Maps an empty window of this size. Raises OSError."""
        with _tail(self._path).open("w+b", buffering=0) as file:
            file.truncate(size)
            self._window = mmap.mmap(file.fileno(), size)
        self._base = c.addressof(c.c_char.from_buffer(self._window))
        self._begin()

    def _begin(self) -> None:
        _OFFSET.pack_into(self._window, 0, self._file.tell())
        self._head.at, self._head.end = self._base + _OFFSET.size, self._base + len(self._window)

    def _room(self, needed: int) -> None:
        """Empties the window into the record; the recording ends where the disk has no room for it."""
        used = self._head.at - self._base
        try:
            self._file.write(memoryview(self._window)[_OFFSET.size : used])
            if needed + _OFFSET.size > len(self._window):
                self._map(needed + _OFFSET.size)
            else:
                c.memset(self._base + _OFFSET.size, 0, used - _OFFSET.size)
                self._begin()
        except OSError:
            self._head.at = self._head.end = None

    def close(self) -> None:
        """Completes the record."""
        if self._head.at is not None:
            self._room(0)
        self._head.at = self._head.end = None
        self._file.close()
        _tail(self._path).unlink(missing_ok=True)


def _tail(record: Path) -> Path:
    return record.with_suffix(".tail")


def complete(record: Path) -> None:
    """Puts what a process that has ended left in the window behind the record. Raises OSError."""
    tail = _tail(record)
    if not tail.exists():
        return
    data = tail.read_bytes()
    with record.open("r+b") as file:
        file.seek(*_OFFSET.unpack_from(data))
        file.write(data[_OFFSET.size :])
    tail.unlink()


def recorded(dll: c.CDLL, asked: Record) -> Recorder:
    """Returns the recorder before a library. Raises InputError where its file cannot be made."""
    try:
        return Recorder(dll, asked)
    except OSError as error:
        raise InputError(f"{asked.path}: the calls cannot be recorded: {reason(error)}") from None
