"""Reads the keys that are pressed at a terminal during a run, without waiting for one and without an echo.

Tests: tests/orchestration/cli/test_realtime.py.
"""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from .console import is_terminal

if sys.platform == "win32":
    import msvcrt
else:
    import termios
    import tty

Keys = Callable[[], str]
"""Gives the keys that were pressed since it was called last."""
KEYS = "real time: the space bar pauses and goes on, s makes one base step, Ctrl-C ends the run"


@contextmanager
def keyboard() -> Iterator[Keys | None]:
    """The keys; None without a terminal. Ctrl-C stays a signal, and the terminal is left as it was."""
    if not is_terminal(sys.stdin):
        yield None
    elif sys.platform == "win32":
        yield _of_windows
    else:
        yield from _of_terminal(sys.stdin.fileno())


if sys.platform == "win32":

    def _of_windows() -> str:
        keys = ""
        while msvcrt.kbhit():
            keys += msvcrt.getwch()
        return keys

else:

    def _of_terminal(terminal: int) -> Iterator[Keys | None]:
        def in_front() -> bool:
            """Returns whether the terminal is this program's; in the background it would be stopped for using it."""
            try:
                return os.tcgetpgrp(terminal) == os.getpgrp()
            except OSError:
                return False

        def pressed() -> str:
            with suppress(OSError, ValueError):
                if select.select([terminal], [], [], 0)[0] and in_front():
                    return os.read(terminal, 64).decode("ascii", "replace")
            return ""

        if not in_front():
            yield None
            return
        before = termios.tcgetattr(terminal)
        tty.setcbreak(terminal)
        try:
            yield pressed
        finally:
            if in_front():
                with suppress(termios.error):
                    termios.tcsetattr(terminal, termios.TCSADRAIN, before)
