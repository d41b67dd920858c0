"""Whether a satellite's values fit each other, before anything is flown.

A finding has a number, the bound and what to change. Nothing is refused: what is unusual may be meant.
Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

from collections.abc import Iterator

from orchestration import Scenario

from .body import of_body, of_inertia
from .finding import Finding
from .gyro import of_no_gyro
from .rods import of_rods
from .satellite import PLANTS, Satellite, goal, satellite
from .sensors import of_sensors
from .wheels import NONE, of_no_wheel, of_wheels

__all__ = ["NONE", "PLANTS", "Finding", "Satellite", "findings", "goal", "notes", "satellite"]


def findings(scenario: Scenario, mass: float | None = None) -> list[Finding]:
    """Returns what is not plausible of the satellite of a scenario; `mass` in kg, else that of the scenario's `data`.

    Raises InputError.
    """
    return list(_compared(satellite(scenario, mass)))


def notes(scenario: Scenario) -> list[str]:
    """Returns the findings as notes of a run; a scenario without a satellite has none."""
    if not any(entry.fmu in PLANTS for entry in scenario.blocks.values()):
        return []
    return [f"not plausible: {finding}" for finding in findings(scenario)]


def _compared(s: Satellite) -> Iterator[Finding]:
    yield from of_inertia(s)
    yield from of_body(s)
    yield from of_rods(s)
    yield from of_wheels(s)
    yield from of_no_wheel(s)
    yield from of_sensors(s)
    yield from of_no_gyro(s)
