"""The recorder before an FMU's library: its calls go through recorder.c, which writes them into a mapped file.

The file is complete to the last call whatever becomes of the process; calls.h describes it.
Requirement: RC-1. Tests: tests/orchestration/instances/record/test_play.py.
"""

from __future__ import annotations

import ctypes as c
import errno
import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any

from ...errors import InputError, reason
from ...fmu.archive import Fmu
from ...fmu.model import Model
from ..compilation import compiled

FOLDER = Path(__file__).parent
FIRST = "FMI calls 1"
"""The first line of a record."""
_WINDOW, _WINDOWS = 1 << 16, 4
"""Bytes of a window, which begins with where in the record it belongs, and how many there are."""
_OFFSET, _HEAD = struct.Struct("<Q"), struct.Struct("<QB")
_ROOM, _MEMORY = c.CFUNCTYPE(None, c.c_size_t), c.CFUNCTYPE(c.c_void_p, c.c_size_t)


class _Head(c.Structure):
    """Head of recorder.c's structure."""

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

    What is recorded goes to windows on a small file that is mapped, `calls.tail`, in turn. A thread writes a full one
    behind the record while the next is filled: so few pages are touched, the calls need not wait for the disk, and all
    of it is kept if the process ends.
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
        self._offset = self._file.write(asked.head.encode())
        self._ended = False
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
        """Maps empty windows of this size. Raises OSError."""
        with _tail(self._path).open("w+b", buffering=0) as file:
            file.truncate(_WINDOWS * size)
            mapped = mmap.mmap(file.fileno(), _WINDOWS * size)
        self._windows = [memoryview(mapped)[i * size : (i + 1) * size] for i in range(_WINDOWS)]
        self._full, self._free = SimpleQueue[tuple[int, int] | None](), SimpleQueue[int]()
        for i in range(1, _WINDOWS):
            self._free.put(i)
        self._begin(0)
        self._writer = Thread(target=self._write, daemon=True)
        self._writer.start()

    def _begin(self, number: int) -> None:
        window = self._windows[number]
        _HEAD.pack_into(window, 0, self._offset, 0)
        self._number, self._base = number, c.addressof(c.c_char.from_buffer(window))
        self._head.at, self._head.end = self._base + _OFFSET.size, self._base + len(window)

    def _write(self) -> None:
        """Writes full windows into the record, until there is none to come or the disk has no room for one."""
        while (full := self._full.get()) is not None:
            number, used = full
            try:
                self._file.write(self._windows[number][_OFFSET.size : used])
            except OSError:
                self._ended = True
            self._free.put(number)

    def _room(self, needed: int) -> None:
        """Hands the window to the thread that writes, and takes another one; the recording ends where the disk has no
        room for it."""
        try:
            self._hand_on()
            if needed + _OFFSET.size > len(self._windows[0]):
                self._finish()
                self._map(needed + _OFFSET.size)
            else:
                self._begin(self._free.get())
        except OSError:
            self._ended = True
        if self._ended:
            self._head.at = self._head.end = None

    def _hand_on(self) -> None:
        used = self._head.at - self._base
        self._offset += used - _OFFSET.size
        self._full.put((self._number, used))

    def _finish(self) -> None:
        self._full.put(None)
        self._writer.join()

    def close(self) -> None:
        """Completes the record."""
        if self._head.at is not None:
            self._hand_on()
        self._finish()
        self._head.at = self._head.end = None
        self._file.close()
        _tail(self._path).unlink(missing_ok=True)


def _tail(record: Path) -> Path:
    return record.with_suffix(".tail")


def complete(record: Path) -> None:
    """Puts what a process that has ended left in the windows behind the record. Raises OSError."""
    tail = _tail(record)
    if not tail.exists():
        return
    data = tail.read_bytes()
    size = len(data) // _WINDOWS
    windows = [data[i * size : (i + 1) * size] for i in range(_WINDOWS) if size > _OFFSET.size]  # none: it ended before
    end = record.stat().st_size + len(data)
    with record.open("r+b") as file:
        for window in sorted(windows, key=_OFFSET.unpack_from):
            if (at := _OFFSET.unpack_from(window)[0]) > 0:
                if at > end:
                    raise OSError(errno.EINVAL, "the record is damaged", str(tail))
                file.seek(at)
                file.write(window[_OFFSET.size :])
    tail.unlink()


def recorded(dll: c.CDLL, asked: Record) -> Recorder:
    """Returns the recorder before a library. Raises InputError where its file cannot be made."""
    try:
        return Recorder(dll, asked)
    except OSError as error:
        raise InputError(f"{asked.path}: the calls cannot be recorded: {reason(error)}") from None
