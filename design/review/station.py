"""A station beside the ground track, which a review tracks by the supervisor's references.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from fmus.interface import load as interface
from plant.orbit import earth_fixed, geodetic

from . import studies
from .content import Curves, Section, Table, number
from .facts import Facts
from .flights import Flight, Flown
from .manoeuvres import Worst, signals

ASIDE, PASS, HORIZON, TURN = 5.0, 1.3, 10.0, 0.3
"""Station aside the track, deg of arc; orbits until it is nearest; least elevation that counts, deg; deg/s of slews."""


def station(facts: Facts) -> tuple[list[Flight], str]:
    """Returns the flight that tracks a station beside the ground track, or why there is none."""
    kind = facts.controller
    if kind not in ("controller_planned", "controller_planned_wheels"):
        this = kind or "no controller"
        return [], f"A station is not tracked: {this} takes no reference from a supervisor."
    if not {"plant_sensors", "estimator"} <= facts.blocks.keys():
        return [], "A station is not tracked: the scenario has no sensors or no estimator."
    p = facts.satellite.p
    at = PASS * facts.period
    latitude, longitude = _place(facts, at)
    e, c, j = (facts.blocks[k] for k in ("estimator", kind, "plant_judge"))
    every = facts.scenario.blocks[c].every
    torque = 0.2 * facts.satellite.rods
    slew = 180.0 / TURN + math.radians(TURN) * float(np.linalg.eigvalsh(p.J_B)[2]) / torque  # no turn takes longer
    start = {
        "target_latitude": f"{math.degrees(latitude):.4f} deg",
        "target_longitude": f"{math.degrees(longitude):.4f} deg",
        "target_height": 0,
        "slew_rate_max": f"{TURN} deg/s",
        "slew_torque_max": torque,
        "settled_angle": facts.goal,
        "epoch": p.epoch,
        "J_B": p.J_B.tolist(),
    }
    blocks = studies.merged(studies.hold(facts))
    blocks["supervisor"] = {"fmu": "supervisor", "every": every, "start": start}
    names = ["R_ref", "Omega_ref", "dOmega_ref", "t_ahead", "turn_ahead", "Omega_ahead"]
    added = [f"supervisor.{name} -> {c}.{name}" for name in names if name in interface(kind).variables]
    added += [f"{e}.{name} -> supervisor.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N", "attitude_valid")]
    added += [f"supervisor.R_ref -> {j}.R_d", f"supervisor.Omega_ref -> {j}.Omega_d"]
    changes = {
        "duration": f"{at + 600.0:.6g} s",
        "blocks": blocks,
        "connections": {"add": added},
        "timeline": [{"at": f"{max(at - 300.0 - slew, 0.0):.6g} s", "set": {"supervisor.command": 6}}],
    }
    told = [f"supervisor.{name}" for name in ("mode", "destination", "target_elevation")]
    recorded = (*signals(facts), *told, f"{facts.plant}.omega_B")
    return [Flight("station", changes, recorded)], ""


def _place(facts: Facts, t: float) -> tuple[float, float]:
    """Returns latitude and longitude, rad, of a point beside the ground track at a time."""
    p = facts.satellite.p
    r, v = p.orbit.position_velocity(t)
    along = v / np.linalg.norm(v)
    angle = math.radians(ASIDE)
    up = r / np.linalg.norm(r)
    beside = math.cos(angle) * up + math.sin(angle) * np.cross(along, up)
    latitude, longitude, _ = geodetic(earth_fixed(t, p.gmst0).T @ (6.371e6 * beside))
    return latitude, longitude


def tracking(facts: Facts, flown: Mapping[str, Flown], why: str) -> tuple[Section, Worst]:
    """Returns how well the station is tracked, and the largest error, rad."""
    if why:
        return Section("Station tracking", notes=[why]), (math.nan, "")
    one = flown["station"]
    judge, h_w = signals(facts)
    turned = (one["supervisor.destination"] == 6) & np.isin(one["supervisor.mode"], (2, 6))  # acquiring or there
    seen = turned & (one["supervisor.target_elevation"] > math.radians(HORIZON))
    if one.failure or not seen.any():
        why = one.failure or "The station was never tracked above the horizon."
        return Section("Station tracking", notes=[why]), (math.inf, "station")
    error = one[judge][seen]
    rate = np.linalg.norm(one[f"{facts.plant}.omega_B"][seen], axis=1)
    rows = [
        [f"time above {HORIZON:g} deg of elevation, tracked", f"{one.time[seen][-1] - one.time[seen][0]:.0f} s"],
        ["highest elevation", f"{math.degrees(one['supervisor.target_elevation'][seen].max()):.1f} deg"],
        ["error, median", f"{math.degrees(np.median(error)):.3g} deg"],
        ["error, rms", f"{math.degrees(math.sqrt(float(np.mean(error**2)))):.3g} deg"],
        ["error, largest", f"{math.degrees(error.max()):.3g} deg"],
        ["largest body rate", f"{math.degrees(rate.max()):.3g} deg/s"],
        ["largest momentum of a wheel", f"{number(1e3 * float(np.abs(one[h_w][seen]).max()))} mN.m.s"],
    ]
    minutes = one.time / 60.0
    curves = Curves(
        "Error to the line of sight, while it is tracked",
        minutes[seen].tolist(),
        "time, min",
        "error, deg",
        {"attitude error": np.degrees(error).tolist()},
        log=True,
    )
    note = f"A station {ASIDE:g} deg of arc beside the ground track; replay: orchestrate flights/station.yaml"
    section = Section("Station tracking", [Table("Tracking of a station", ["", "value"], rows, note)], [curves])
    return section, (float(error.max()), "station")
