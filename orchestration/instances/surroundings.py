"""What an FMU in this process may change for all others: rounding mode, flushing of small numbers to zero, working
folder, signal handlers, limits, open files, streams, threads that go on.

Each is compared with what it was, restored, and noted with the FMU's name. The rounding mode, whose look takes
nanoseconds, is looked at after each call of the step loop; the rest after the calls of initialization and at the end of
a flight.

Tests: tests/orchestration/instances/test_surroundings.py.
"""

from __future__ import annotations

import ctypes as c
import math
import os
import signal
import sys
import threading
from contextlib import suppress
from ctypes.util import find_library

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGPIPE", "SIGCHLD", "SIGALRM")
"""Those by which a run is ended, or that the FMU's handlers would take from it; a runtime keeps those of crashes."""
_STANDARD = range(3)
_ACTION = 512
"""Bytes; a struct sigaction has fewer everywhere."""
_ENVIRONMENT = 512
"""Bytes; an fenv_t has fewer everywhere."""
_HANDLER = c.sizeof(c.c_void_p)
"""Bytes of it that are compared: its first member. The C library leaves some of the others as they happen to be."""

left: list[threading.Thread] = []
"""The threads that flights have left, for which Python would wait at its end."""


class Surroundings:
    """As they are when this is made, before the first FMU of others is loaded."""

    def __init__(self, notes: list[str]) -> None:
        """`notes` is the list to which what is noted is added."""
        self.notes = notes
        self.watches = sys.platform != "win32"
        self._process, self._threads, self._streams = os.getpid(), set(_threads()), (sys.stdout, sys.stderr)
        if not self.watches:
            return
        libm = c.CDLL(find_library("m"))
        self.get_round, self.set_round = libm.fegetround, libm.fesetround
        self.mode = self.get_round()
        self._arithmetic, self._restore = c.create_string_buffer(_ENVIRONMENT), libm.fesetenv
        libm.fegetenv(self._arithmetic)
        self._libc = c.CDLL(None)
        limits = ("open files", resource.RLIMIT_NOFILE), ("a file's size", resource.RLIMIT_FSIZE)
        self._limits = {entry: resource.getrlimit(entry[1])[0] for entry in limits}
        self._folder = os.open(".", os.O_RDONLY | os.O_CLOEXEC)
        self._actions = {name: self._action(name) for name in SIGNALS}
        self._copies = {file: os.dup(file) for file in _STANDARD if _is_open(file)}
        self._files = _files()

    def _action(self, name: str) -> bytes:
        buffer = c.create_string_buffer(_ACTION)
        self._libc.sigaction(int(getattr(signal, name)), None, buffer)
        return buffer.raw

    def look_at_rounding(self, block: str, call: str) -> None:
        """Restores the rounding mode, and notes who changed it."""
        if self.watches and self.get_round() != self.mode:
            self.set_round(self.mode)
            self.note(block, call, "the rounding mode")

    def look(self, block: str, call: str) -> None:
        """Restores all of it, and notes what had been changed."""
        if not self.watches:
            return
        if os.getpid() != self._process:  # a copy that it has made by fork: one is enough to write results
            os._exit(0)
        self.look_at_rounding(block, call)
        if _flushes():
            self._restore(self._arithmetic)
            self.note(block, call, "the arithmetic, which took the smallest numbers for zero")
        for (what, limit), before in self._limits.items():
            soft, hard = resource.getrlimit(limit)
            if soft != (wanted := min(before, hard, key=_as_number)):
                resource.setrlimit(limit, (wanted, hard))
                self.note(block, call, f"the limit of {what}")
        if not self._is_here():
            os.fchdir(self._folder)
            self.note(block, call, "the working folder")
        for name, action in self._actions.items():
            if self._action(name)[:_HANDLER] != action[:_HANDLER]:
                self._libc.sigaction(int(getattr(signal, name)), action, None)
                self.note(block, call, f"the handler of {name}")
        for file, copy in self._copies.items():
            if not _is_open(file):
                with suppress(OSError):  # the copy has been closed, too
                    os.dup2(copy, file)
                self.note(block, call, f"the file {file} ({('input', 'output', 'errors')[file]}), which it closed")
        for name, stream in zip(("stdout", "stderr"), self._streams, strict=True):
            now = getattr(sys, name)
            if stream is not None and not stream.closed and (now is None or now.closed):
                setattr(sys, name, stream)
                self.note(block, call, f"sys.{name}")
        if going := set(_threads()) - self._threads - set(left):
            left.extend(going)
            names = ", ".join(sorted(thread.name for thread in going))
            self.notes.append(f"{block}: {call} left threads that go on ({names}); they end with this program")
        if closed := {file for file in self._files if not _is_open(file)}:
            self._files -= closed
            many = "files" if len(closed) > 1 else "file"
            self.note(block, call, f"{len(closed)} open {many} of this program, which it closed", restored=False)

    def _is_here(self) -> bool:
        try:
            return os.path.samestat(os.stat("."), os.fstat(self._folder))
        except OSError:  # the folder is gone, or its file has been closed
            return True

    def note(self, block: str, call: str, what: str, restored: bool = True) -> None:
        """Notes a change once for each block and call."""
        text = f"{block}: {call} changed {what}" + ("; it was restored" if restored else "")
        if text not in self.notes:
            self.notes.append(text)

    def close(self) -> None:
        """Gives back what the looks need."""
        if self.watches:
            for file in (self._folder, *self._copies.values()):
                with suppress(OSError):
                    os.close(file)
            self.watches = False


def _as_number(limit: int) -> float:
    return math.inf if limit == resource.RLIM_INFINITY else limit


def _flushes() -> bool:
    """Returns whether numbers below the smallest normal one are taken for zero."""
    least = sys.float_info.min
    return not least / 2 or not math.nextafter(0.0, 1.0) * 2


def _threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if not thread.daemon]


def _is_open(file: int) -> bool:
    try:
        os.fstat(file)
    except OSError:
        return False
    return True


def _files() -> set[int]:
    """The files that are open, but for standard ones."""
    try:
        names = os.listdir("/dev/fd")
    except OSError:
        return set()
    return {file for file in map(int, names) if file not in _STANDARD and _is_open(file)}
