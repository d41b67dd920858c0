"""The keyboard of a terminal during a run: the keys that were pressed, without waiting for one and without an echo."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from .console import is_terminal

KEYS = "real time: the space bar pauses and goes on, s makes one base step, Ctrl-C ends the run"


@contextmanager
def keyboard() -> Iterator[Callable[[], str] | None]:
    """A function that gives the keys pressed since it was called last; None without a terminal. Ctrl-C stays a signal."""
    if not is_terminal(sys.stdin):
        yield None
    elif sys.platform == "win32":
        yield _of_windows
    else:
        yield from _of_terminal(sys.stdin.fileno())


def _of_windows() -> str:
    import msvcrt  # here, since only Windows has it  # noqa: PLC0415

    keys = ""
    while sys.platform == "win32" and msvcrt.kbhit():
        keys += msvcrt.getwch()
    return keys


def _of_terminal(terminal: int) -> Iterator[Callable[[], str] | None]:
    import termios  # here, since Windows does not have them  # noqa: PLC0415
    import tty  # noqa: PLC0415

    def in_front() -> bool:
        """Whether the terminal is this program's; in the background it would be stopped for using it."""
        with suppress(OSError):
            return os.tcgetpgrp(terminal) == os.getpgrp()
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
