"""The holds of docs/evidence/margins.md, and what is measured of one of them at a place of the orbit.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from orchestration import load
from orchestration.fmu.model import Element
from orchestration.margins.floquet import coordinates, orbit
from orchestration.margins.inject import Altered, Rig
from orchestration.margins.measure import measure
from orchestration.margins.periods import LEAD, follow
from orchestration.margins.report import Found
from orchestration.margins.search import Change, expectations_are_met, lost, pulse_dies_out
from orchestration.margins.site import site
from orchestration.session.open import open_scenario
from orchestration.session.session import Session
from orchestration.system.wiring import Node

from ..paper import ROOT

RATE = math.sqrt(3.986004418e14 / 6.971e6**3)
TILT = math.radians(1.0)
ALIGNED = {
    "plant.Q0": [[1, 0, 0], [0, math.cos(TILT), -math.sin(TILT)], [0, math.sin(TILT), math.cos(TILT)]],
    "plant.omega_B0": [0.0, -RATE, 0.0],
}
"""A hold that begins 1 deg off, at the rate of LVLH."""
WITHOUT = {"wheel_torque_max": 1e-9, "wheel_momentum_max": 1e-9, "plant.h_w0": 0.0} | {
    f"plant.{name}": [0.0, 0.0, 0.0] for name in ("disturbance_torque_B", "residual_dipole_B")
}
"""Rods alone hold no disturbance of 6 uN m on this satellite."""
COMMANDS = ("plant.dipole_cmd", "plant.wheel_torque_cmd")
TOLD = ("plant.dipole_cmd", "allocator.wheel_torque_cmd")
"""The controller is told of the wheel's pulses: else they move its estimate of friction, which has a limit at 0."""
STATE = ("plant.R_NB", "plant.omega_B", "plant.h_w")

VB, USUAL, PLANNED = "V.B, paper's law", "usual law, four wheels", "planned, one wheel"
FOUR, THREE = "planned, four wheels", "planned, three wheels"
AT_FIRST = "pointing below 1.5 deg from the start"
"""The expectation of the planned hold that the first minutes may fail, in which a hold is not lost."""
PLACES = tuple(range(0, 360, 45))
"""deg"""
PIECE, FIFTH, SHORT, TURN = 20, 380, 400, 11580
"""Samples of 0.5 s: from plan to plan, of a fifth of a flight with a delay, of the answer at a place, of an orbit."""


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
    state: tuple[str, ...] = STATE
    followed: bool = False
    """Whether it has no margins of a moment, and the answers to pulses are followed over orbits instead."""


CASES = {
    VB: Case("paper_no_singularity", ("allocator.tau_cmd_B",), 100.0, 410.0, ALIGNED),
    USUAL: Case("flight_pyramid", ("plant.wheel_torque_cmd",), 300.0, 600.0, {"plant.Q0": ALIGNED["plant.Q0"]}),
    FOUR: Case("flight_pyramid_planned", ("plant.wheel_torque_cmd",), 1000.0, 600.0),
    THREE: Case(
        "flight_pyramid_planned",
        tuple(f"plant.wheel_torque_cmd[{i}]" for i in (1, 2, 3)),
        1000.0,
        600.0,
        {"wheels": 3, "wheel_axis": [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]]},
    ),
    "usual law, three wheels, noise": Case(
        "flight_three_wheels",
        tuple(f"plant.wheel_torque_cmd[{i}]" for i in (1, 2, 3)),
        3600.0,
        600.0,
        {},
        STATE[:2],
        True,
    ),
    PLANNED: Case("flight_hold", TOLD, 600.0, 600.0, followed=True),
    "planned, no wheel": Case("flight_hold", COMMANDS[:1], 6000.0, 600.0, WITHOUT, STATE[:2], True),
    "planned, on star tracker": Case("flight_star_tracker", TOLD, 1500.0, 600.0, followed=True),
    "planned, on estimates": Case("flight_estimated", TOLD, 1500.0, 600.0, followed=True),
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
    """Returns what is left of a disturbance after 200 s and after an orbit, from 8 places of the orbit on."""
    began = time.process_time()
    session, rig = opened(CASES[name], 0)
    rows: list[dict[str, Any]] = []
    at = rig.period * rig.first / rig.site.hold * 360.0 / (0.5 * TURN)
    with session:
        seen = coordinates(session.opened.plan, CASES[name].state)
        sizes: list[float] = []
        for place in sorted(PLACES, key=lambda place: (place - at) % 360.0):
            if rows:
                rig = rig.further(TURN // len(PLACES), Altered())
            else:
                rig = rig.further(round((place - at) % 360.0 / 360.0 * TURN) or 1, Altered())
                orbits = rig
            short = follow(rig, seen, SHORT, 2, PIECE)
            row = {"case": name, "place": place, "refused": short.refused, "left": short.left, "error": short.error}
            rows.append({**row, "size": short.size, "tried": short.tried})
            sizes.append(short.size)
        if not any(row["refused"] for row in rows):
            size = max(sizes)
            long = follow(orbits, seen, TURN, 3, PIECE, pulses=2, sizes=(10.0 * size, size))
            for row, begin in zip(rows, np.round(np.arange(len(PLACES)) * long.pieces / len(PLACES)), strict=True):
                one = long.window(int(begin))
                row |= {"orbit": one.ratio, "most": one.most, "rest": one.rest, "wrong": one.error}
        peak = Peak(Node("judge", Element("attitude_error", 0)))
        orbits.fly(np.zeros((TURN, len(rig.site.channels))), observers=[peak], nodes=[peak.node])
        rows = [{**row, "flown": math.degrees(peak.largest)} for row in rows]
    return [{**row, "seconds": (time.process_time() - began) / len(rows)} for row in rows]


def searched(name: str, text: str) -> list[dict[str, Any]]:
    """Returns between which values a change loses a hold: that of V.B by a pulse, a planned one by its expectations
    over an orbit, but for the one of how the hold is taken up."""
    case = CASES[name]
    if case.followed:
        case = replace(case, values={**case.values, "duration": 0.5 * TURN})
    session, rig = opened(case, 0)
    with session:
        checks = [check for check in session.opened.plan.checks if check.expectation.name != AT_FIRST]
        holds = expectations_are_met(rig, checks) if case.followed else pulse_dies_out(rig, 6000)
        found = lost(rig, Change.of(text), holds)
    return [{"case": name, **found.data(), "end": found.change.end}]


def delayed(name: str, values: Mapping[str, Any], delay: float) -> list[dict[str, Any]]:
    """Returns what is left of a disturbance of the planned hold after 1010 s with a delay at its actuators, s, and the
    largest attitude error, deg, of this flight."""
    session, rig = opened(replace(CASES[PLANNED], ports=COMMANDS, values=values), 0)
    with session:
        plan = session.opened.plan
        altered = Altered(delay=round(delay / plan.clock.step))
        found = follow(rig, coordinates(plan, STATE), FIFTH, 5, PIECE, altered, pulses=2, sizes=(1e-5,), moved=3)
        peak = Peak(Node("judge", Element("attitude_error", 0)))
        rig.fly(np.zeros((LEAD * PIECE + 5 * FIFTH, len(rig.site.channels))), altered, [peak], [peak.node])
    flown = math.degrees(peak.largest)
    return [{"name": name, "delay": delay, "left": found.left, "error": found.error, "flown": flown}]


class Peak:
    """An observer that keeps the largest value of a node."""

    def __init__(self, node: Node) -> None:
        self.node, self.largest = node, 0.0

    def see(self, time: Any, values: Mapping[Node, Any]) -> None:
        self.largest = max(self.largest, float(np.max(values[self.node])))


def equilibrium(turn: tuple[int, ...]) -> list[dict[str, Any]]:
    """Returns the rates, 1/s, of the multipliers of the paper's law where R_LVLH^T R = diag(turn), without drag."""
    values: dict[str, Any] = {"plant.Q0": np.diag(turn).tolist(), "plant.omega_B0": [0.0, -RATE * turn[1], 0.0]}
    values |= {"plant.drag": False, "plant.argument_of_latitude": 0.0}
    with Session(open_scenario(load(ROOT / "scenarios" / "paper_no_singularity.yaml", values))) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, COMMANDS), 0)
        size = np.array([6e-5, 6e-5, 6e-5, 1e-7] if turn == (-1, -1, 1) else [2e-4, 2e-4, 2e-4, 1e-8])

        found = orbit(rig, coordinates(plan, STATE), round(10.0 / rig.period), size, 100, None, more=12)
    rates = [log.real / found.period for log in found.logs]
    return [{"turn": list(turn), "rates": rates, "rest": found.rest, "seconds": found.period}]


def largest(rates: Iterable[float]) -> float:
    """Returns the largest rate but for the one nearest to zero, that of the wheel's momentum, which the law leaves as
    it is."""
    return max(sorted(rates, key=abs)[1:])
