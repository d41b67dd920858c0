"""A run whose FMUs of others share its process is waited for: one that ends the process does not end it with status 0.

Tests: tests/orchestration/cli/test_watch.py.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn

from ..fmu.interfaces import is_path
from ..instances.confine import end_with
from ..instances.guest import TRACE
from ..scenario.scenario import Scenario
from ..session.limits import limits
from .console import complain
from .status import BLOCK_FAILED


@contextmanager
def watched(scenario: Scenario) -> Iterator[None]:
    """Goes on in a process of its own where FMUs of others run in this one; this one waits for it, and says where an
    FMU has ended it. Not on Windows, and not where the command is called by another program's Python."""
    guests = any(is_path(entry.fmu) and limits(scenario, name) is None for name, entry in scenario.blocks.items())
    if not guests or not hasattr(os, "fork") or sys.stdout is not sys.__stdout__:
        yield
        return
    print(end="", flush=True)
    print(end="", flush=True, file=sys.stderr)
    master = os.getpid()
    if child := os.fork():
        _wait(child)
    end_with(master)
    try:
        yield
    finally:
        TRACE.finish()


def _wait(child: int) -> NoReturn:
    """Ends as the child does, or with the status of an FMU that failed."""

    def pass_on(number: int, frame: object) -> None:
        with suppress(ProcessLookupError):
            os.kill(child, number)

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal sends it to both
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, pass_on)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if TRACE.done or -status in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        if status < 0:
            signal.signal(-status, signal.SIG_DFL)
            os.kill(os.getpid(), -status)
        os._exit(status)
    how = f"crashed with {signal.Signals(-status).name}" if status < 0 else f"ended the run with exit status {status}"
    complain(
        f"{TRACE.text}: {how}; nothing of this run is written, earlier results are kept; remedy: "
        "isolation: process, which keeps what was computed"
    )
    os._exit(BLOCK_FAILED)
