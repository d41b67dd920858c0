"""Ctrl-C and its like as flags, so that they end a run between two steps and never inside an FMU."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""What ends a run: Ctrl-C, a `kill`, a terminal that is closed."""


class Stopped(KeyboardInterrupt):
    """A signal asks the program to end."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


class Abandoned(Stopped):
    """A run was to end and the call of a block did not, so the block was ended."""


_latest: list[int] = []


def latest() -> list[int]:
    """The list of `interruptible` that was made last; a thread beside a run that waits may look at it."""
    return _latest


def is_asked(error: BaseException) -> bool:
    """Returns whether a signal may have raised this, and not the code of others that ran."""
    if not isinstance(error, KeyboardInterrupt):
        return False
    plain = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return isinstance(error, Stopped) or bool(_latest) or plain


def _stop(number: int, frame: FrameType | None) -> NoReturn:
    raise Stopped(number)


@contextmanager
def stoppable() -> Iterator[None]:
    """Lets the signals raise Stopped, where nobody has said what they do (nohup has)."""
    ours, usual = threading.current_thread() is threading.main_thread(), (signal.SIG_DFL, signal.default_int_handler)
    taken = {n: handler for n in SIGNALS if ours and (handler := signal.getsignal(n)) in usual}
    for number in taken:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in taken.items():
            signal.signal(number, handler)


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """A list that is empty until one of the signals comes, and then holds its number. The second raises as always.

    Without this, the interrupt would be raised in whatever Python code runs, that of a Python FMU
    included, which would report it as its own failure.
    """
    global _latest
    _latest = came = []

    def note(number: int, restore: Callable[[], None]) -> None:
        came.append(number)
        restore()

    with _handled(note, lambda handler: handler in (signal.default_int_handler, _stop)):
        yield came


@contextmanager
def held(firmly: bool = False) -> Iterator[None]:
    """Keeps the signals until the block of code is left, and obeys them then.

    A second one is obeyed at once, if not `firmly`.
    """
    came: list[int] = []

    def note(number: int, restore: Callable[[], None]) -> None:
        came.append(number)
        if len(came) > 1 and not firmly:
            came.clear()
            restore()
            signal.raise_signal(number)

    try:
        with _handled(note, lambda handler: handler not in (signal.SIG_IGN, None)):
            yield
    finally:
        if came:
            signal.raise_signal(came[0])


@contextmanager
def _handled(note: Callable[[int, Callable[[], None]], None], taken: Callable[[object], bool]) -> Iterator[None]:
    """Gives the signals to `note`, with what restores their handlers; only those whose handlers are `taken` over."""
    ours = threading.current_thread() is threading.main_thread()
    before = {n: handler for n in SIGNALS if ours and taken(handler := signal.getsignal(n))}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    for number in before:
        signal.signal(number, lambda number, frame: note(number, restore))
    try:
        yield
    finally:
        restore()
