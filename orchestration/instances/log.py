"""The last log messages of each FMU, kept for the moment when they are wanted."""

from __future__ import annotations

import ctypes as c
import os
import sys
import tempfile
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fmus import places
from fmus.versions import version_of

from ..errors import printable
from ..fmu.platforms import PLATFORM, SUFFIX

LINES_MAX = 20
_LENGTH_MAX = 500
_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_logs: dict[int, Log] = {}


_Logger2 = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p)
_Logger3 = c.CFUNCTYPE(None, c.c_void_p, c.c_int, c.c_char_p, c.c_char_p)


class _Callbacks2(c.Structure):
    _fields_ = (
        ("logger", _Logger2),
        ("allocateMemory", c.c_void_p),
        ("freeMemory", c.c_void_p),
        ("stepFinished", c.c_void_p),
        ("componentEnvironment", c.c_void_p),
    )


class Log:
    """An FMU's callbacks and what it has logged through them.

    FMPy's proxy in C puts the message's arguments in their places and passes it on to one function
    for all FMUs, which finds the right log by the component's environment.
    """

    def __init__(self, name: str, echo: bool | Callable[[str], None] = False) -> None:
        """`echo` prints each line, or does with it what it is."""
        self.name, self.echo = name, echo
        self.lines: deque[str] = deque(maxlen=LINES_MAX)
        self.folder: Path | None = None
        """Where the FMU is unpacked, for as long as it runs: its files are named as they stand in the archive."""
        self.key = max(_logs, default=0) + 1
        _logs[self.key] = self

    @cached_property
    def callbacks_2(self) -> _Callbacks2:
        """Those of FMI 2.0."""
        allocate, free = (c.cast(function, c.c_void_p) for function in _memory())
        callbacks = _Callbacks2(_logger, allocate, free, None, self.key)
        with suppress(OSError):  # FMPy has none for this platform: messages then come without their arguments
            _proxy().addLoggerProxy(c.byref(callbacks))
        return callbacks

    @cached_property
    def message_3(self) -> Any:
        """The one of FMI 3.0."""
        return _Logger3(self.receive)

    def receive(self, environment: Any, status: int, category: Any, message: bytes | None) -> None:
        """The callback of FMI 3.0, whose messages have their arguments in their places."""
        _receive(self.key, None, status, category, message)

    def close(self) -> None:
        _logs.pop(self.key, None)

    def add(self, status: int, message: str) -> None:
        within = message if self.folder is None else message.replace(f"{self.folder}{os.sep}", "")
        for line in within.rstrip().splitlines():
            line = shortened(line)
            self.lines.append(line if status == 0 else f"[{_STATUS[status] if status in range(6) else status}] {line}")
            if callable(self.echo):
                self.echo(self.lines[-1])
            elif self.echo:
                print(printable(f"{self.name}: {self.lines[-1]}"), file=sys.stderr)


def shortened(line: str) -> str:
    """The line, or the beginning of one that would fill the screen."""
    return line if len(line) <= _LENGTH_MAX else f"{line[:_LENGTH_MAX]} ..."


def _receive(environment: Any, instance: bytes | None, status: int, category: Any, message: bytes | None) -> None:
    log = _logs.get(environment or 0)
    if log is None:  # an FMU that does not hand the environment back
        name = (instance or b"").decode("utf-8", "replace")
        log = next((log for log in _logs.values() if log.name == name), None)
    if log is not None:
        log.add(status, (message or b"").decode("utf-8", "replace"))


_logger = _Logger2(_receive)


def _memory() -> tuple[Any, Any]:
    """calloc and free of the C library."""
    library = c.cdll.msvcrt if sys.platform == "win32" else c.CDLL(None)
    return library.calloc, library.free


@cache
def _proxy() -> c.CDLL:
    """FMPy's library of the proxy, as a copy: it passes all messages of a process to one function, and FMPy sets it to
    its own.

    The library is taken from FMPy's folder, since the import of FMPy takes 60 ms.
    """
    spec = find_spec("fmpy")
    source = Path(spec.origin if spec and spec.origin else "").parent / "logging" / PLATFORM / f"logging{SUFFIX}"
    path = places.work() / "loop" / f"fmpy-{version_of('fmpy')}-logging{SUFFIX}"
    try:
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
                file.write(source.read_bytes())
            os.replace(file.name, path)
        return c.CDLL(str(path))
    except OSError:  # a folder in which nothing can be written
        import fmpy.logging  # first, since it sets the function when it is imported  # noqa: F401, PLC0415

        return c.CDLL(str(source))
