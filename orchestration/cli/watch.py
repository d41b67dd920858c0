"""A run whose FMUs of others, or laws in Python, share its process is waited for: one that ends it does not end the run
with status 0.

Tests: tests/orchestration/instances/test_surroundings.py, tests/orchestration/results/test_endings.py.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NoReturn

from ..fmu.interfaces import is_path
from ..instances.confine import end_with
from ..instances.guest import TRACE
from ..instances.process import signal_name
from ..instances.record.recorder import complete
from ..scenario.scenario import Scenario
from ..session.limits import limits
from .console import complain
from .status import BLOCK_FAILED, INTERNAL

_LOST = "nothing of this run is written, earlier results are kept"
_WAITED = {getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGCHLD") if hasattr(signal, name)}


@contextmanager
def watched(scenario: Scenario, records: Iterable[Path] = (), lost: str = _LOST) -> Iterator[None]:
    """Goes on in a process of its own where FMUs of others or laws run in this one; this one waits for it.

    It says where one has ended the other and what is `lost`, and completes the records of calls. Only on Linux, and not
    where the command is called by another program's Python.
    """
    blocks = scenario.blocks.items()
    guests = [name for name, entry in blocks if entry.python or is_path(entry.fmu)]
    guests = [name for name in guests if limits(scenario, name) is None]
    if not guests or not hasattr(signal, "sigwaitinfo") or sys.stdout is not sys.__stdout__:
        yield
        return
    print(end="", flush=True)
    print(end="", flush=True, file=sys.stderr)
    master, before = os.getpid(), signal.pthread_sigmask(signal.SIG_BLOCK, _WAITED)
    if child := os.fork():
        _wait(child, before, records, lost, " or ".join(guests))
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    end_with(master)
    try:
        yield
    finally:
        TRACE.finish()


def _wait(child: int, before: set[int], records: Iterable[Path], lost: str, guests: str) -> NoReturn:
    """Ends as the child does, or with the status of an FMU that failed; passes on what other processes send.

    The terminal sends its signals to both. `before` is the mask of signals without those that are waited for here.
    """
    while (ended := os.waitpid(child, os.WNOHANG))[0] == 0:
        came = signal.sigwaitinfo(_WAITED)
        if came.si_signo != signal.SIGCHLD and came.si_code <= 0:  # from a process, not from the kernel
            with suppress(ProcessLookupError):
                os.kill(child, came.si_signo)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    status = os.waitstatus_to_exitcode(ended[1])
    for record in records:
        with suppress(OSError):
            complete(record)
    if status == INTERNAL:
        complain(f"{guests} shares this process and may have changed it; remedy: isolation: process")
        os._exit(BLOCK_FAILED)
    killed = -status == signal.SIGKILL
    if TRACE.done or killed or -status in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        if killed and not TRACE.done:
            complain(f"{TRACE.text}: the run was killed (SIGKILL, as the system does for want of memory); {lost}")
        if status < 0:
            with suppress(OSError):  # SIGKILL has no handler
                signal.signal(-status, signal.SIG_DFL)
            os.kill(os.getpid(), -status)
        os._exit(status)
    how = f"crashed with {signal_name(-status)}" if status < 0 else f"ended the run with exit status {status}"
    complain(f"{TRACE.text}: {how}; {lost}; remedy: isolation: process, which keeps what was computed")
    os._exit(BLOCK_FAILED)
