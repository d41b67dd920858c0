"""Flies a loop and looks for causes in a process of its own, so that another team's FMU may crash there.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar, cast

from ...errors import BlockError, InputError
from ...fmu.interfaces import is_path
from ...scenario.source import Source
from .fly import Found, Loop

P = ParamSpec("P")
T = TypeVar("T")


def apart(block: str, task: Callable[P, T], *args: P.args, **named: P.kwargs) -> T:
    """Returns what a task gives in a process of its own. Raises BlockError where that ends."""
    try:
        with ProcessPoolExecutor(1) as pool:
            return pool.submit(task, *args, **named).result()
    except BrokenProcessPool:
        raise BlockError(block, "a run alone", "ended the process in which it ran; the FMU has crashed") from None


def within(seconds: float, task: Callable[P, T], *args: P.args, **named: P.kwargs) -> T | None:
    """Returns what a task gives in a process of its own; None where it fails, or takes longer: then it is ended with
    all that it has started."""
    source, into = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.Process(target=_send, args=(into, task, args, named))
    process.start()
    into.close()
    try:
        return cast(T, source.recv()) if source.poll(seconds) else None
    except EOFError:
        return None
    finally:
        if process.is_alive() and process.pid is not None and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
        process.kill()
        process.join()


def _send(into: Connection, task: Callable[..., Any], args: Sequence[Any], named: Mapping[str, Any]) -> None:
    if hasattr(os, "setsid"):
        os.setsid()
    result = None
    with suppress(BlockError, InputError, ValueError):
        result = task(*args, **named)
    into.send(result)


def flown(source: Source) -> tuple[Found | None, BlockError | None]:
    """Returns the first that a loop does not meet, None where it meets all, and what ended the run early.

    Raises InputError and BlockError.
    """
    return apart("polarity", _fly, source)


def _fly(source: Source) -> tuple[Found | None, BlockError | None]:
    loop = Loop(inside(source))
    found, _ = loop.fly()
    return found, loop.failure


def inside(source: Source) -> Source:
    """Returns the scenario with its one FMU of another team in the process that flies it, which is its own already.

    Where there are more, each keeps its own process: modules of one name would get in each other's way.
    """
    blocks = source.data["blocks"]
    foreign = [name for name, entry in blocks.items() if is_path(str(entry.get("fmu", "")))]
    if len(foreign) != 1:
        return source
    for key, value in (("isolation", "none"), ("timeout", None), ("memory", None)):
        source = source.with_entry(("blocks", foreign[0], key), value)
    return source
