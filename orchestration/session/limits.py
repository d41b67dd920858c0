"""The limits of a block's process: what the scenario says of it, and what holds where it says nothing."""

from __future__ import annotations

import os

from ..errors import InputError
from ..fmu.interfaces import is_path
from ..instances.process import Limits
from ..scenario.scenario import Scenario

TIMEOUT = 60.0
"""Seconds that a call may take, where the scenario says nothing."""
MEMORY = 4 * 10**9
"""Bytes that an FMU may take, where the scenario says nothing and the machine has twice as many."""


def limits(scenario: Scenario, name: str) -> Limits | None:
    """The limits of a block's process; None where it has none of its own. Raises InputError."""
    entry = scenario.blocks[name]
    default = "process" if entry.python or is_path(entry.fmu) else "none"
    if (entry.isolation or scenario.isolation or default) == "process":
        return Limits(entry.timeout or TIMEOUT, entry.memory or _memory())
    for key in ("timeout", "memory"):
        if getattr(entry, key) is not None:
            message = "only an FMU or a law in a process of its own has this limit; remedy: isolation: process"
            raise InputError(scenario.error(("blocks", name, key), message))
    return None


def _memory() -> int:
    try:
        return min(MEMORY, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2)
    except (AttributeError, ValueError, OSError):
        return MEMORY
