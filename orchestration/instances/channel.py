"""What passes between the master and a block in a process of its own.

Calls and answers go through pipes; the values of a step lie in memory that both processes map. A step is
one byte there and one byte back: a blocking read of a pipe is the quickest wake-up there is without
keeping a processor busy, and it is the same on every system.

    master to worker    STEP, or CALL with its length and a pickled (method, arguments)
    worker to master    DONE, or ANSWER with its length and JSON, since nothing that it sends is to be trusted
"""

from __future__ import annotations

import mmap
import os
import struct
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..fmu.co_simulation import CoSimulation
from ..fmu.model import Floats, Model
from .record.recorder import Record

if sys.platform == "linux":
    import fcntl

STEP, CALL = b"s", b"c"
DONE, ANSWER = b"d", b"a"
MARK = b"\x00end of the log\x00"
"""A line by which the worker says that all that the FMU has printed until now stands before it."""

_LENGTH = struct.Struct("<Q")
_ANSWER_MAX = 64_000_000
_CALL_MAX = 200
_HEAD = 512
"""Bytes: time and step as doubles; at 16 the part of the step that runs; at 17 whether the worker has lost its pipes;
at 32 the call of FMI's that runs, empty between two."""

SETTING, STEPPING, GETTING = 1, 2, 3


@dataclass(frozen=True)
class Setup:
    """Data of its FMU that a worker needs."""

    name: str
    model: Model
    kind: CoSimulation
    library: str
    folder: Path
    """Where it has been unpacked."""
    memory: Path | int
    """The file that is mapped, or its descriptor."""
    bytes_max: int | None
    """How much memory it may take beyond what this process has; None for no limit."""
    master: int
    """The master's process."""
    record: Record | None = None
    """Where its calls are recorded."""


class Closed(Exception):
    """The other end is gone."""


class Memory:
    """Mapped by both processes; it outlives a crash, and tells then where it happened."""

    def __init__(self, source: Path | int, model: Model) -> None:
        """Maps the file, which is made where there is none, or that of a descriptor. Raises OSError where the disk has
        no room for it."""
        size = _size(model)
        if isinstance(source, int):
            self.map = mmap.mmap(source, size)
        else:
            with source.open("r+b" if source.exists() else "w+b") as file:
                if os.fstat(file.fileno()).st_size < size:
                    _reserve(file.fileno(), size)
                self.map = mmap.mmap(file.fileno(), size)
        self.clock = memoryview(self.map)[:16].cast("d")
        self.part = memoryview(self.map)[16:17]
        self.cut = memoryview(self.map)[17:18]

    def values(self, inputs: int, outputs: int) -> tuple[Floats, Floats]:
        """The inputs, and the outputs behind them."""
        values = np.frombuffer(self.map, np.float64, inputs + outputs, _HEAD)
        return values[:inputs], values[inputs:]

    @property
    def call(self) -> str:
        length = min(self.map[32], _CALL_MAX)
        return self.map[33 : 33 + length].decode("utf-8", "replace")

    @call.setter
    def call(self, name: str) -> None:
        text = name.encode()[:_CALL_MAX]
        self.map[33 : 33 + len(text)] = text
        self.map[32] = len(text)


def _size(model: Model) -> int:
    elements = sum(variable.size for variable in model.variables.values())
    return _HEAD + 2 * 8 * elements  # each may be set and be fetched


def sealed(model: Model) -> int | None:
    """The descriptor of a file of the right size that nobody can shorten, not even the FMU: a read behind the end of a
    mapped file ends the process that reads by SIGBUS. None on systems other than Linux. Raises OSError.
    """
    if sys.platform != "linux":
        return None
    descriptor = os.memfd_create("orchestrate", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        _reserve(descriptor, _size(model))
        fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _reserve(file: int, size: int) -> None:
    """Gives a file its size with room on the disk for all of it: a mapped page without room ends the process by
    SIGBUS."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file, 0, size)
    else:
        os.write(file, bytes(size))


def write(to: int, data: bytes) -> None:
    """Writes all of it. Raises Closed."""
    try:
        while data:
            data = data[os.write(to, data) :]
    except OSError:
        raise Closed from None


def send(to: int, kind: bytes, body: bytes) -> None:
    write(to, kind + _LENGTH.pack(len(body)) + body)


def receive(source: int) -> bytes:
    """Returns what follows CALL or ANSWER. Raises Closed."""
    (length,) = _LENGTH.unpack(_read(source, _LENGTH.size))
    if length > _ANSWER_MAX:
        raise Closed
    return _read(source, length)


def _read(source: int, length: int) -> bytes:
    data = bytearray()
    while len(data) < length:
        try:
            some = os.read(source, min(length - len(data), 1 << 20))
        except OSError:
            some = b""
        if not some:
            raise Closed
        data += some
    return bytes(data)
