"""What docs/evidence/flight.md flies, as campaigns: tumbles drawn at random, V.B and V.C from every node, long holds,
each pairing.

All are scenarios/flight_*.yaml with other start values, or with other blocks in the same places. Each lasts three
orbits. Tests: tests/evidence/flight/test_flight.py.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from orchestration.campaign.case import Case

from .. import crew
from ..paper import INERTIA, ORBIT
from .schemes import NO_ERRORS, SCHEMES, Data, base, change, fit, tuned

SEEDS = {"nominal": 100, "errors": 200, "tried": 300}
"""Of each set of random tumbles. Run i depends on the seed and i alone, so all schemes fly the same ones."""
RATE_MAX = math.radians(6.0)
J = np.diag(INERTIA)
EARLY, LONG = 1.1 * ORBIT, 3.0 * ORBIT
"""After this time, s, it is told apart what becomes of a flight; how long it lasts, s."""
HOLD = 2000.0
"""The hold's error is that of so many last seconds."""
ALARMS = ("rod_failed", "wheel_failed", "attitude_frozen", "field_failed")
"""What the planned controller says of failures."""
LOST = 5.0
"""deg, within which a satellite is held."""
RATE = 1e-3
"""Settled: below the angle and this rate, rad/s, from then to the end of the flight."""


@dataclass(frozen=True)
class Group:
    """Flights of one kind: a campaign."""

    name: str
    scenario: Data = field(hash=False)
    runs: int = 1
    seed: int = 0
    draw: Data = field(default_factory=dict, hash=False)
    vary: Data = field(default_factory=dict, hash=False)
    """Start values as expressions of what is drawn."""
    duration: float = LONG
    early: float = EARLY
    slow: float = RATE

    @cached_property
    def case(self) -> Case:
        """The campaign, checked. Raises InputError."""
        grid = any("grid" in entry for entry in self.draw.values())
        campaign = {
            "name": re.sub(r"\W+", "_", self.name),
            "scenario": {**self.scenario, "duration": self.duration},
            "draw": self.draw,
            "vary": {name: {"expression": text} for name, text in self.vary.items()},
            "sampling": "grid" if grid else "random",
            "runs": self.runs,
            "seed": self.seed,
            "metrics": metrics(self.duration, self.early, self.scenario, self.slow),
        }
        return crew.case(campaign, Path(__file__).parent)

    def drawn(self) -> list[Data]:
        """Start values of each run by `block.parameter`."""
        return drawn(self.case, self.runs)


def drawn(case: Case, runs: int) -> list[Data]:
    """Start values of a campaign's first runs by `block.parameter`."""
    job = case.job
    return [job.draws.texts(job.draws.at(point)) for point in job.design.points(range(runs)).tolist()]


def metrics(duration: float, early: float, scenario: Data, settled_rate: float = RATE) -> list[Data]:
    """Returns the measures of each flight, all of the plant's truth; it is settled from when both errors are."""
    angle = {"signal": "judge.attitude_error"}
    rate = {"signal": "judge.rate_error_B", "measure": "norm"}
    slow = {"settles": {"below": f"{settled_rate} rad/s"}}
    last, later = {"after": max(0.0, duration - HOLD)}, {"after": min(early, duration)}
    found: dict[str, Data] = {
        "angle_5": {**angle, "settles": {"below": "5 deg"}},
        "angle_1": {**angle, "settles": {"below": "1 deg"}},
        "rate": {**rate, **slow},
        "early_angle_5": {**angle, "settles": {"below": "5 deg"}, "before": early},
        "early_rate": {**rate, **slow, "before": early},
        "hold_rms": {**angle, "statistic": "rms", **last},
        "hold_max": {**angle, "statistic": "maximum", **last},
        "later_rms": {**angle, "statistic": "rms", **later},
        "later_max": {**angle, "statistic": "maximum", **later},
        "later_wheel": {"signal": "plant.h_w", "statistic": "peak", **later},
        "end_angle": {**angle, "statistic": "final"},
        "end_rate": {**rate, "statistic": "final"},
        "initial_rate": {**rate, "statistic": "maximum", "before": 0.0},
        "wheel_max": {"signal": "plant.h_w", "statistic": "peak"},
        "wheel_full": {"signal": "plant.wheel_momentum_saturated", "share": {"equals": True}},
    }
    if scenario["blocks"]["controller"]["fmu"] == "controller_planned":
        found["steered"] = {"signal": "controller.phase", "reaches": {"above": 1}}
        found |= {name: {"signal": f"controller.{name}", "reaches": {"equals": True}} for name in ALARMS}
    return [{"name": name, **metric} for name, metric in found.items()]


# ---------------------------------------------------------------- groups

DRAWN: Data = {
    "attitude": {"rotation": "uniform"},
    "omega": {"sphere": {"uniform": ["0 deg/s", f"{math.degrees(RATE_MAX):g} deg/s"]}},
    "node": {"uniform": ["0 deg", "360 deg"]},
    "push": {"sphere": 1.0},
    "off": {"uniform": [[0.05, 0.05, 0.05], [0.1, 0.1, 0.1]]},
    **{f"side{i}": {"choice": [-1.0, 1.0]} for i in (1, 2, 3)},
    "field": {"sphere": 200e-9},
    "noise": {"integers": [1, 2**31 - 1]},
}
"""What every random tumble draws, in this order: what a group draws beside it comes after, so it changes none of it."""


def tumbles(
    name: str, seed: int, runs: int, errors: bool = False, scheme: str = "planned", data: Data | None = None
) -> Group:
    """Random tumbles by one of SCHEMES.

    Attitude uniform on SO(3), direction of the rate uniform, its size uniform in 0 to 6 deg/s, node uniform. Nominal: a
    disturbance of 1e-6 N m. Errors, all together: J 5 to 10% off in each axis, rods that give 0.9, a disturbance of
    1e-5 N m, noise of 0.01 deg, 1e-5 rad/s and 50 nT, an onboard field 200 nT off in its first three coefficients.
    """
    given = base() if data is None else data
    if not errors:
        change(given, NO_ERRORS)
    vary = {
        "plant.Q0": "attitude",
        "plant.omega_B0": "omega",
        "plant.node_longitude": "node",
        "plant.disturbance_torque_B": "1e-5 * push" if errors else "1e-6 * push",
        "sensors.seed": "noise",
    }
    if errors:
        vary["plant.J_error_B"] = f"diag({list(INERTIA)} * off * [side1, side2, side3])"
        if scheme == "planned":
            vary["controller.field_error"] = "field"
    return Group(name, SCHEMES[scheme](given), runs, seed, DRAWN, vary)


NODES, HOLD_NODES = 36, 6
"""At how many longitudes of the node the manoeuvres begin, and the long holds."""
HOLD_ORBITS = 20
BESIDE = 200
"""How many of the random tumbles the other schemes fly."""
TRIES = 50


def share(n: int, full: int) -> int:
    """Returns how many of a set that has `full` with 1000 random tumbles, with n of them."""
    return min(n, max(2, full * n // 1000))


def _nodes(name: str, data: Data, first: int, count: int, duration: float = LONG, early: float = EARLY) -> Group:
    """From nodes round the Earth, the first of them at so many deg."""
    drawn = {"node": {"grid": [f"{first + 360 * i / count} deg" for i in range(count)]}}
    return Group(name, data, count, 0, drawn, {"plant.node_longitude": "node"}, duration, early)


def manoeuvre(which: str, scheme: str = "planned", n: int = 1000) -> Group:
    """V.B ("vb") or V.C ("vc") from NODES, or their share."""
    name = which if scheme == "planned" else f"{which} {scheme}"
    return _nodes(name, SCHEMES[scheme](base(which)), 0, share(n, NODES))


def hold(n: int = 1000) -> Group:
    """flight_hold.yaml from HOLD_NODES, or their share."""
    return _nodes("hold", base("hold"), 8, share(n, HOLD_NODES), HOLD_ORBITS * ORBIT, ORBIT)


PAIRINGS = {
    ("controller_planned", "allocator_bounded"): "planned controller, bounded allocator",
    ("controller_planned", "allocator"): "planned controller, the paper's allocator",
    ("controller", "allocator_bounded"): "the paper's controller, bounded allocator",
    ("controller", "allocator"): "the paper's controller and allocator",
}


def pairings() -> list[Group]:
    """V.B from 158 deg E by each of PAIRINGS; the paper's controller with the gains tuned for SI units."""
    groups = []
    for law, allocator in PAIRINGS:
        data = base("vb")
        if law != "controller_planned":
            tuned(data)
        if allocator != "allocator_bounded":
            fit(data, "allocator", allocator)
        groups.append(_nodes(f"{law} + {allocator}", data, 158, 1))
    return groups
