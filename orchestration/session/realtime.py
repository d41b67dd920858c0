"""The pacer of a run, as its scenario states it."""

from __future__ import annotations

from collections.abc import Callable

from ..master.pacing import Pacer
from ..scenario.scenario import Scenario

PYTHON_LOOP = (
    "real time: the step loop in Python makes the base steps; the compiled loop gives the same bits without waiting"
)


def pacer(scenario: Scenario, keys: Callable[[], str] | None = None) -> Pacer | None:
    """None for a scenario that states no real time.

    `keys` gives the keys that were pressed since it was called last.
    """
    stated = scenario.realtime
    return None if stated is None else Pacer(stated.factor, stated.tolerance, stated.late == "stop", keys)
