"""Flies a loop and looks for causes in a process of its own, so that another team's FMU may crash there.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any, ParamSpec, TypeVar, cast

from ...errors import BlockError, InputError
from ...fmu.interfaces import is_path
from ...fmu.zipped import size_text
from ...instances import confine
from ...instances.guest import TRACE
from ...scenario.load import load
from ...scenario.source import Source
from ...session.limits import MEMORY, TIMEOUT, limits
from .fly import Found, Loop

P = ParamSpec("P")
T = TypeVar("T")


def apart(source: Source, task: Callable[P, T], *args: P.args, **named: P.kwargs) -> T:
    """Returns what a task gives in a process of its own, in which the FMU of another team of `source` runs. Raises
    BlockError where that ends, or a call takes too long."""
    with guarded(source, 1) as pool:
        return pool.submit(task, *args, **named).result()


@contextmanager
def guarded(source: Source, workers: int, begin: Callable[..., None] | None = None, *args: Any) -> Iterator[Executor]:
    """Gives processes in which the FMU of another team of `source` runs; each begins with `begin`.

    Raises BlockError where one of them ends, or a call of the FMU takes longer than it may.
    """
    told, into = multiprocessing.Pipe(duplex=False)
    name, (_, memory) = " or ".join(_foreign(source)) or "a block", bounds(source)
    try:
        with ProcessPoolExecutor(workers, initializer=_begin, initargs=(into, bounds(source), begin, args)) as pool:
            yield pool
    except MemoryError:
        problem = f"used up the {size_text(memory)} that the block's 'memory' allows"
        raise BlockError(name, "a run", problem, None) from None
    except BrokenProcessPool:
        if not told.poll():
            raise BlockError(name, "a run", "ended the process of its trials", None) from None
        call, seconds = told.recv()
        call, _, time = call.removeprefix(f"{name}: ").partition(" at ")
        problem = f"did not return within {seconds:.10g} s (the block's 'timeout'), so its process was ended"
        raise BlockError(name, call, problem, float(time.split()[0]) if time else None) from None
    finally:
        told.close()
        into.close()


def bounds(source: Source, block: str | None = None) -> tuple[float, int]:
    """Returns the seconds that a call may take, and the bytes that all may: of a block, or the most that one has."""
    scenario = load(source)
    names = scenario.blocks if block is None else [block]
    found = [one for name in names if (one := limits(scenario, name))]
    seconds = max((one.timeout for one in found), default=TIMEOUT)
    return seconds, max((one.memory for one in found if one.memory is not None), default=MEMORY)


def _begin(into: Connection, bounds: tuple[float, int], begin: Callable[..., None] | None, args: Sequence[Any]) -> None:
    bound(into, *bounds)
    if begin is not None:
        begin(*args)


def bound(into: Connection, seconds: float, memory: int) -> None:
    """Bounds the memory of this process, and ends it where a call of an FMU takes longer: `into` is told which."""
    TRACE.renew()
    confine.limit_memory(memory)
    threading.Thread(target=_watch, args=(into, seconds), daemon=True).start()


def _watch(into: Connection, seconds: float) -> None:
    """Ends this process where a call of an FMU takes too long, and tells which."""
    last, since = None, monotonic()
    while not threading.Event().wait(min(0.2, seconds / 4)):
        try:
            running = TRACE.running
        except ValueError:
            continue  # its text is being written
        if last is None or running != last:
            last, since = running, monotonic()
        elif monotonic() - since > seconds:
            into.send((last[1], seconds))
            os._exit(1)


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
    return apart(source, _fly, source)


def _fly(source: Source) -> tuple[Found | None, BlockError | None]:
    loop = Loop(inside(source))
    found, _ = loop.fly()
    return found, loop.failure


def inside(source: Source) -> Source:
    """Returns the scenario with its one FMU of another team in the process that flies it, which is its own already.

    Where there are more, each keeps its own process: modules of one name would get in each other's way.
    """
    foreign = _foreign(source)
    if len(foreign) != 1:
        return source
    for key, value in (("isolation", "none"), ("timeout", None), ("memory", None)):
        source = source.with_entry(("blocks", foreign[0], key), value)
    return source


def _foreign(source: Source) -> list[str]:
    """Returns the blocks that are FMUs of other teams."""
    return [name for name, entry in source.data["blocks"].items() if is_path(str(entry.get("fmu", "")))]
