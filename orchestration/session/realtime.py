"""The pacer of a run, as its scenario states it, and the priority of its process.

Tests: tests/orchestration/session/test_priority.py, tests/orchestration/master/test_pacing.py.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..errors import InputError
from ..master.pacing import Pacer
from ..scenario.scenario import Scenario

PYTHON_LOOP = (
    "real time: the step loop in Python makes the base steps; the compiled loop gives the same bits without waiting"
)
PRIORITIES = range(1, 100)
"""Of SCHED_FIFO; the kernel's own threads have 50 as a rule."""
_LOCK_CURRENT_AND_FUTURE = 1 | 2


def pacer(scenario: Scenario, keys: Callable[[], str] | None = None, priority: int | None = None) -> Pacer | None:
    """None for a scenario that states no real time. `keys` gives the keys that were pressed since it was called last;
    `priority` is that of `prioritized`, for the report. Raises InputError for a priority without real time.
    """
    stated = scenario.realtime
    if stated is None:
        if priority is not None:
            raise InputError("--realtime-priority: only a run in real time has one; remedy: --realtime")
        return None
    return Pacer(stated.factor, stated.tolerance, stated.late == "stop", keys, priority=priority)


@contextmanager
def prioritized(priority: int | None) -> Iterator[None]:
    """Lets this thread and what it starts run before all of ordinary priority (SCHED_FIFO), with its memory locked, so
    that no page is fetched from the disk during a step. None: leaves all as it is.

    Raises InputError where the system does not permit it.
    """
    if priority is None:
        yield
        return
    if sys.platform != "linux":
        raise InputError("--realtime-priority: this system has no SCHED_FIFO for programs; expected Linux")
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    libc = ctypes.CDLL(None, use_errno=True)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        raise InputError(
            f"--realtime-priority {priority}: this user may not have it; remedy: a line "
            f"'@GROUP - rtprio {priority}' and '@GROUP - memlock unlimited' in /etc/security/limits.conf and a new "
            "login, or in a container --cap-add "
            "SYS_NICE --cap-add IPC_LOCK"
        ) from None
    try:
        if libc.mlockall(_LOCK_CURRENT_AND_FUTURE) != 0:
            raise InputError(
                f"--realtime-priority {priority}: the memory cannot be locked: "
                f"{os.strerror(ctypes.get_errno())}; remedy: '@GROUP - memlock unlimited' in "
                "/etc/security/limits.conf and a new login, or in a container --cap-add IPC_LOCK"
            )
        yield
    finally:
        libc.munlockall()
        os.sched_setscheduler(0, *before)
