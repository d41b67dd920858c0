"""Measures margins along the orbit, the equilibria of the paper's law and the changes that lose V.B, for
docs/evidence/margins.md.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orchestration import load
from orchestration.margins.floquet import coordinates, orbit
from orchestration.margins.inject import Rig
from orchestration.margins.measure import measure
from orchestration.margins.report import Found
from orchestration.margins.search import Change, lost, pulse_dies_out
from orchestration.margins.site import site
from orchestration.session.open import open_scenario
from orchestration.session.session import Session

from ..paper import ROOT

KEPT = ROOT / "docs" / "evidence" / "margins.json"
PLACES = tuple(range(0, 360, 45))
"""Angles from the ascending node at which a flight starts, deg."""
CHANGES = ("delay=0..20", "gain=1..0.02", "plant.J_B=1..30", "plant.rod_gain=1..0.05")


@dataclass(frozen=True)
class Case:
    """A hold that is measured."""

    scenario: str
    when: float
    """s from the start, by when it has settled."""
    window: float
    """Longest time that is looked at after a pulse, s."""
    values: Mapping[str, Any] = field(default_factory=dict)


CASES = {
    "V.B, paper's law": Case("paper_no_singularity", 400.0, 410.0),
    "planned hold, one wheel": Case("flight_hold", 600.0, 600.0),
    "planned hold, no wheel": Case("flight_hold", 600.0, 600.0, {"wheel_torque_max": 1e-9, "plant.h_w0": 0.0}),
    "planned hold on estimates": Case("flight_estimated", 1500.0, 600.0),
}


def along_orbit(name: str, place: int) -> dict[str, Any]:
    """Returns the margins at `allocator.tau_cmd_B` of a case that starts so many degrees from the node."""
    case = CASES[name]
    values = {**case.values, "plant.argument_of_latitude": math.radians(place)}
    with Session(open_scenario(load(ROOT / "scenarios" / f"{case.scenario}.yaml", values))) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, ["allocator.tau_cmd_B"]), round(case.when / plan.clock.step))
        response = measure(rig, round(case.window / rig.period))
        found = Found.of(name, case.when, response)
    row: dict[str, Any] = {"case": name, "place": place, "refused": response.refused, "warnings": response.warnings}
    if found.together is not None:
        m = found.together
        row |= {"disk": m.disk.value, "delay": m.delay.value, "phase": math.degrees(m.phase.value)}
        row |= {"up": 20 * math.log10(m.gain_up.value), "error": float(response.error.max())}
    return row


def equilibrium(turn: Sequence[int]) -> dict[str, Any]:
    """Returns the rates, 1/s, of the multipliers of the paper's law where R_LVLH^T R = diag(turn), without drag."""
    rate = math.sqrt(3.986004418e14 / 6.971e6**3)
    values = {"plant.Q0": np.diag(turn).tolist(), "plant.omega_B0": [0.0, -rate * turn[1], 0.0], "plant.drag": False}
    with Session(open_scenario(load(ROOT / "scenarios" / "paper_no_singularity.yaml", values))) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, ["plant.dipole_cmd", "plant.wheel_torque_cmd"]), 0)
        seen = coordinates(plan, ["plant.R_NB", "plant.omega_B", "plant.h_w"])
        size = 1e-2 * np.array([0.02, 0.02, 0.02, 1e-6])
        found = orbit(rig, seen, round(10.0 / rig.period), size, 100, more=12)
    rates = [log.real / found.period for log in found.logs]
    return {"turn": list(turn), "rates": rates, "rest": found.rest, "seconds": found.period}


def searched() -> list[dict[str, Any]]:
    """Returns what loses the hold of V.B."""
    case = CASES["V.B, paper's law"]
    with Session(open_scenario(load(ROOT / "scenarios" / f"{case.scenario}.yaml"))) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, ["allocator.tau_cmd_B"]), round(case.when / plan.clock.step))
        rig.fly(np.zeros((1, 3)))
        made = [lost(rig, Change.of(text), pulse_dies_out(rig, 6000)) for text in CHANGES]
    return [
        {"name": one.change.name, "holds": one.holds, "lost": one.lost if math.isfinite(one.lost) else None}
        for one in made
    ]


def make(jobs: int, cases: Sequence[str], places: Sequence[int]) -> None:
    """Measures these cases and keeps them beside those that are kept already."""
    kept = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {"places": []}
    with ProcessPoolExecutor(jobs) as pool:
        waits = [pool.submit(along_orbit, name, place) for name in cases for place in places]
        equilibria = [pool.submit(equilibrium, turn) for turn in ((1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1))]
        changes = pool.submit(searched)
        rows = {(row["case"], row["place"]): row for row in kept["places"]}
        rows |= {(row["case"], row["place"]): row for row in (wait.result() for wait in waits)}
        kept = {
            "places": list(rows.values()),
            "equilibria": [e.result() for e in equilibria],
            "changes": changes.result(),
        }
    KEPT.write_text(json.dumps(kept, indent=1) + "\n", "utf-8")
