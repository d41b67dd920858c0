"""Flies a loop and looks for causes in a process of its own, so that another team's FMU may crash there.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import ParamSpec, TypeVar

from ...errors import BlockError
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
