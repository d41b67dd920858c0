"""The last log messages of each FMU, kept for the moment when they are wanted."""

from __future__ import annotations

import ctypes as c
import sys
from collections import deque
from collections.abc import Callable
from typing import Any

from fmpy import calloc, free
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

from ..errors import printable

LINES_MAX = 20
_LENGTH_MAX = 500
_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_logs: dict[int, Log] = {}


class Log:
    """An FMU's callbacks and what it has logged through them.

    FMPy's proxy in C puts the message's arguments in their places and passes it on to one function
    for all FMUs, which finds the right log by the component's environment.
    """

    def __init__(self, name: str, echo: bool | Callable[[str], None] = False) -> None:
        """`echo` prints each line, or does with it what it is."""
        self.name, self.echo = name, echo
        self.lines: deque[str] = deque(maxlen=LINES_MAX)
        self.key = max(_logs, default=0) + 1
        _logs[self.key] = self
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = _logger
        self.callbacks.allocateMemory = _allocate
        self.callbacks.freeMemory = _free
        self.callbacks.componentEnvironment = c.c_void_p(self.key)
        addLoggerProxy(c.byref(self.callbacks))

    def receive(self, environment: Any, status: int, category: Any, message: bytes | None) -> None:
        """The callback of FMI 3.0, whose messages have their arguments in their places."""
        _receive(self.key, None, status, category, message)

    def close(self) -> None:
        _logs.pop(self.key, None)

    def add(self, status: int, message: str) -> None:
        for line in message.rstrip().splitlines():
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


_logger = fmi2CallbackLoggerTYPE(_receive)
_allocate = fmi2CallbackAllocateMemoryTYPE(calloc)
_free = fmi2CallbackFreeMemoryTYPE(free)
