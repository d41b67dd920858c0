"""The holds of docs/evidence/margins.md, and what is measured of one of them at a place of the orbit.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orchestration import load
from orchestration.margins.floquet import SEEN, Orbit, coordinates, orbit
from orchestration.margins.inject import Altered, Rig
from orchestration.margins.measure import measure
from orchestration.margins.report import Found
from orchestration.margins.site import site
from orchestration.session.open import open_scenario
from orchestration.session.session import Session

from ..paper import ROOT

RATE = math.sqrt(3.986004418e14 / 6.971e6**3)
TILT = math.radians(1.0)
ALIGNED = {
    "plant.Q0": [[1, 0, 0], [0, math.cos(TILT), -math.sin(TILT)], [0, math.sin(TILT), math.cos(TILT)]],
    "plant.omega_B0": [0.0, -RATE, 0.0],
}
"""A hold that begins 1 deg off, at the rate of LVLH."""
COMMANDS = ("plant.dipole_cmd", "plant.wheel_torque_cmd")
STATE = ("plant.R_NB", "plant.omega_B", "plant.h_w")
PLANNED = "planned, one wheel"
REPEATS = "repeats every 10 s"
PIECE, SPAN = 20, 400
"""Samples of 0.5 s: from plan to plan, and of the multipliers of a planned hold."""


@dataclass(frozen=True)
class Case:
    """A hold that is measured."""

    scenario: str
    ports: tuple[str, ...]
    """Where the loop is opened."""
    when: float
    """s from the start, by when it has settled."""
    window: float
    """Longest time that is looked at after a pulse, s."""
    values: Mapping[str, Any] = field(default_factory=dict)
    planned: bool = False
    """A loop that plans anew every 10 s: it repeats, and multipliers are measured, too."""


CASES = {
    "V.B, paper's law": Case("paper_no_singularity", ("allocator.tau_cmd_B",), 100.0, 410.0, ALIGNED),
    "usual law, four wheels": Case(
        "flight_pyramid", ("plant.wheel_torque_cmd",), 300.0, 600.0, {"plant.Q0": ALIGNED["plant.Q0"]}
    ),
    "usual law, three wheels, noise": Case(
        "flight_three_wheels", tuple(f"plant.wheel_torque_cmd[{i}]" for i in (1, 2, 3)), 3600.0, 600.0
    ),
    PLANNED: Case("flight_hold", COMMANDS, 600.0, 600.0, planned=True),
    "planned, no wheel": Case(
        "flight_hold", COMMANDS[:1], 600.0, 600.0, {"wheel_torque_max": 1e-9, "plant.h_w0": 0.0}, planned=True
    ),
    "planned, on star tracker": Case("flight_star_tracker", COMMANDS, 1500.0, 600.0, planned=True),
    "planned, on estimates": Case("flight_estimated", COMMANDS, 1500.0, 600.0, planned=True),
}


def opened(case: Case, place: int) -> tuple[Session, Rig]:
    """Returns a session of a case that starts so many degrees from the ascending node."""
    values = {**case.values, "plant.argument_of_latitude": math.radians(place)}
    session = Session(open_scenario(load(ROOT / "scenarios" / f"{case.scenario}.yaml", values)))
    plan = session.opened.plan
    return session, Rig(session, site(plan, case.ports), round(case.when / plan.clock.step))


def along_orbit(name: str, place: int) -> dict[str, Any]:
    """Returns the margins of a case at a place, or why it has none; of a planned one also the multipliers."""
    case = CASES[name]
    session, rig = opened(case, place)
    with session:
        if case.planned and place:
            return {"case": name, "place": place, "refused": REPEATS, **multipliers(multiplied(rig))}
        response = measure(rig, round(case.window / rig.period))
        found = Found.of(name, case.when, response)
        row: dict[str, Any] = {"case": name, "place": place, "refused": response.refused, "warnings": response.warnings}
        row["change"] = response.change
        if found.together is not None:
            m = found.together
            row |= {"disk": m.disk.value, "delay": m.delay.value, "phase": math.degrees(m.phase.value)}
            row |= {"up": 20 * math.log10(m.gain_up.value), "error": float(response.error.max())}
        if case.planned:
            row |= multipliers(multiplied(rig))
    return row


def multiplied(rig: Rig, samples: int = SPAN, delay: float = 0.0) -> Orbit:
    """Returns the transitions of a planned hold from plan to plan, with a delay, s, at the actuators."""
    plan = rig.session.opened.plan
    altered = Altered(delay=round(delay / plan.clock.step))
    found, size = None, 1e-4 * rig.scales
    for depth in (2, 3):
        more = orbit(rig, coordinates(plan, STATE), samples, size, PIECE, altered=altered, depth=depth)
        found = more if found is None or more.rest < found.rest else found
        if found.rest < SEEN:
            break
    assert found is not None
    return found


def multipliers(found: Orbit) -> dict[str, Any]:
    """Returns what is kept of multipliers."""
    largest = float(found.logs[0].real)
    return {"log": largest, "span": found.period, "rest": found.rest}


def equilibrium(turn: tuple[int, ...], place: int = 0) -> dict[str, Any]:
    """Returns the rates, 1/s, of the multipliers of the paper's law where R_LVLH^T R = diag(turn), without drag."""
    values: dict[str, Any] = {"plant.Q0": np.diag(turn).tolist(), "plant.omega_B0": [0.0, -RATE * turn[1], 0.0]}
    values |= {"plant.drag": False, "plant.argument_of_latitude": math.radians(place)}
    with Session(open_scenario(load(ROOT / "scenarios" / "paper_no_singularity.yaml", values))) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, COMMANDS), 0)
        size = np.array([6e-5, 6e-5, 6e-5, 1e-7] if turn == (-1, -1, 1) else [2e-4, 2e-4, 2e-4, 1e-8])
        found = orbit(rig, coordinates(plan, STATE), round(10.0 / rig.period), size, 100, more=12)
    rates = [log.real / found.period for log in found.logs]
    return {"turn": list(turn), "place": place, "rates": rates, "rest": found.rest, "seconds": found.period}
