"""The holds of docs/evidence/margins.md, and what is measured of one of them at a place of the orbit.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orchestration import load
from orchestration.errors import InputError
from orchestration.margins.floquet import SEEN, Orbit, Repeated, coordinates, orbit
from orchestration.margins.inject import Altered, Rig
from orchestration.margins.measure import measure
from orchestration.margins.report import Found
from orchestration.margins.search import Change, lost, pulse_dies_out
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
PLANNED, USUAL, NOISE = "planned, one wheel", "usual law, four wheels", "usual law, three wheels, noise"
PIECE, SPAN = 20, 400
"""Samples of 0.5 s: from plan to plan, and of the multipliers at a place."""
TURN, PLACES = 11580, tuple(range(0, 360, 45))
"""Samples of 0.5 s of an orbit, 579 plans, and the angles of places, deg."""


REPEATS = "a new plan every 10 s"
NOISY = "it damps along the axis of the present error, which noise turns from sample to sample"


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
    reason: str = ""
    """Why the loop has no margins of a moment; it has multipliers, and is lost in flights."""


CASES = {
    "V.B, paper's law": Case("paper_no_singularity", ("allocator.tau_cmd_B",), 100.0, 410.0, ALIGNED),
    USUAL: Case("flight_pyramid", ("plant.wheel_torque_cmd",), 300.0, 600.0, {"plant.Q0": ALIGNED["plant.Q0"]}),
    NOISE: Case(
        "flight_three_wheels", tuple(f"plant.wheel_torque_cmd[{i}]" for i in (1, 2, 3)), 3600.0, 600.0, reason=NOISY
    ),
    PLANNED: Case("flight_hold", COMMANDS, 600.0, 600.0, reason=REPEATS),
    "planned, no wheel": Case(
        "flight_hold", COMMANDS[:1], 600.0, 600.0, {"wheel_torque_max": 1e-9, "plant.h_w0": 0.0}, reason=REPEATS
    ),
    "planned, on star tracker": Case("flight_star_tracker", COMMANDS, 1500.0, 600.0, reason=REPEATS),
    "planned, on estimates": Case("flight_estimated", COMMANDS, 1500.0, 600.0, reason=REPEATS),
}


def opened(case: Case, place: int) -> tuple[Session, Rig]:
    """Returns a session of a case that starts so many degrees from the ascending node."""
    values = {**case.values, "plant.argument_of_latitude": math.radians(place)}
    session = Session(open_scenario(load(ROOT / "scenarios" / f"{case.scenario}.yaml", values)))
    plan = session.opened.plan
    return session, Rig(session, site(plan, case.ports), round(case.when / plan.clock.step))


def at_place(name: str, place: int) -> list[dict[str, Any]]:
    """Returns the margins of a case that starts at a place, or why it has none."""
    case = CASES[name]
    session, rig = opened(case, place)
    with session:
        response = measure(rig, round(case.window / rig.period))
    found = Found.of(name, case.when, response)
    row: dict[str, Any] = {"case": name, "place": place, "refused": response.refused, "warnings": response.warnings}
    row["change"] = response.change
    if found.together is not None:
        m = found.together
        row |= {"disk": m.disk.value, "delay": m.delay.value, "phase": math.degrees(m.phase.value)}
        row |= {"up": 20 * math.log10(m.gain_up.value), "error": float(response.error.max())}
    return [row]


def along_orbit(name: str) -> list[dict[str, Any]]:
    """Returns the multipliers of a case at places of one orbit, and between which delays and gains a pulse no longer
    dies out there."""
    session, rig = opened(CASES[name], 0)
    rows: list[dict[str, Any]] = []
    with session:
        for place in PLACES:
            if place:
                rig = rig.further(TURN // len(PLACES), Altered())
            row = {"case": name, "place": place, "refused": CASES[name].reason, **multipliers(multiplied(rig))}
            for change in ("delay=0..16", "gain=1..32"):
                try:
                    row |= {change.partition("=")[0]: lost(rig, Change.of(change), pulse_dies_out(rig, SPAN)).data()}
                except InputError as error:
                    row |= {change.partition("=")[0]: str(error)}
            rows.append(row)
    return rows


def whole_orbit(name: str, changed: Sequence[str] = ()) -> dict[str, Any]:
    """Returns the multipliers of a case over an orbit, and how the largest depends on parameters."""
    session, rig = opened(CASES[name], 0)
    with session:
        seen = coordinates(session.opened.plan, STATE)
        found = Repeated.of(rig, seen, TURN, 1e-4 * rig.scales, PIECE if "planned" in name else 200)
        slopes = {one: found.sensitivity(one) for one in changed}
    logs = [float(log.real) for log in found.nominal.logs]
    return {"case": name, "period": found.nominal.period, "logs": logs, "rest": found.nominal.rest, "slopes": slopes}


def multiplied(rig: Rig, samples: int = SPAN, delay: float = 0.0, gain: float = 1.0) -> Orbit:
    """Returns the transitions of a hold from plan to plan, with a delay, s, and a gain at the actuators."""
    plan = rig.session.opened.plan
    altered = Altered(gain=gain, delay=round(delay / plan.clock.step))
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
