"""Single flights of a review: slews, a station that is tracked, and each single failure.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestration.results.settling import settling
from plant.orbit import earth_fixed, geodetic
from plant.so3 import Array

from . import studies
from .content import Curves, Section, Table, number
from .facts import Facts
from .flights import Flight, Flown
from .power import commands

ANGLES = (10, 30, 90, 180)
"""deg"""
FAILS, ENDS = 1.0, 3.0
"""Orbits after which a part fails, and the flight ends; the last orbit is looked at."""
ASIDE, PASS, HORIZON, TURN = 5.0, 1.3, 10.0, 0.3
"""Station aside the track, deg of arc; orbits until it is nearest; least elevation that counts, deg; deg/s of slews."""
HEALTH = {"gyro": 0, "magnetometer": 1, "GNSS": 2, "star tracker": 3, "sun sensors": 4}
"""Places in the estimator's `health`."""


def _signals(facts: Facts) -> tuple[str, ...]:
    return f"{facts.blocks['plant_judge']}.attitude_error", f"{facts.plant}.h_w"


def slews(facts: Facts) -> list[Flight]:
    """Returns flights from rest at some angles about each body axis, on an attitude that is measured to 0.01 deg."""
    made = []
    for angle in ANGLES:
        for i, axis in enumerate("xyz"):
            turn = studies.turned(facts, _turn(i, math.radians(angle)))
            blocks = studies.merged(*studies.perfect(facts), turn)
            made.append(
                Flight(f"slew-{angle}-{axis}", {"duration": f"{facts.period:.6g} s", "blocks": blocks}, _signals(facts))
            )
    return made


def _turn(axis: int, angle: float) -> Array:
    """Returns the rotation (3,3) about a body axis."""
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = math.cos(angle)
    R[j, i], R[i, j] = math.sin(angle), -math.sin(angle)
    return R


LOST = 90.0
"""deg: a satellite that is farther off in the orbit that is looked at does not hold its attitude."""
Worst = tuple[float, str]
"""A metric, and the flight that has it."""


def agility(facts: Facts, flown: Mapping[str, Flown]) -> tuple[Section, Worst]:
    """Returns times and momenta of the slews, and the longest time until 5 deg, s."""
    judge, h_w = _signals(facts)
    rows = []
    longest: Worst = (0.0, "")
    for angle in ANGLES:
        for axis in "xyz":
            name = f"slew-{angle}-{axis}"
            one = flown[name]
            within = [settling(one.time, one[judge], math.radians(level)).time for level in (5.0, 1.0)]
            longest = max(longest, (math.inf if within[0] is None else within[0], name))
            momentum = float(np.abs(one[h_w]).max())
            told = [number(t, 4) if t is not None else "not within an orbit" for t in within]
            rows.append([f"{angle} deg", axis, *told, number(1e3 * momentum), one.failure or ""])
    columns = ["slew", "about", "below 5 deg after, s", "below 1 deg after, s", "largest momentum, mN.m.s", "failed"]
    note = (
        "From rest relative to the orbit, on an attitude that is measured to 0.01 deg at any rate: what actuators and "
        "law give. The tumbles have the times on the satellite's own sensors."
    )
    return Section("Agility", [Table("Slews", columns, rows, note)]), longest


def station(facts: Facts) -> tuple[list[Flight], str]:
    """Returns the flight that tracks a station beside the ground track, or why there is none."""
    kind = facts.controller
    if kind != "controller_planned":
        this = kind or "no controller"
        return [], f"A station is not tracked: it is with controller_planned alone, and this is {this}."
    if not {"plant_sensors", "estimator"} <= facts.blocks.keys():
        return [], "A station is not tracked: the scenario has no sensors or no estimator."
    p = facts.satellite.p
    at = PASS * facts.period
    latitude, longitude = _place(facts, at)
    e, c, j, plant = (facts.blocks[k] for k in ("estimator", kind, "plant_judge", "plant"))
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
    added = [f"supervisor.{name} -> {c}.{name}" for name in names]
    added += [f"{e}.{name} -> supervisor.{name}" for name in ("R_NB", "omega_B", "r_N", "v_N", "attitude_valid")]
    added += [f"supervisor.R_ref -> {j}.R_d", f"supervisor.Omega_ref -> {j}.Omega_d"]
    changes = {
        "duration": f"{at + 600.0:.6g} s",
        "blocks": blocks,
        "connections": {"add": added},
        "timeline": [{"at": f"{max(at - 300.0 - slew, 0.0):.6g} s", "set": {"supervisor.command": 6}}],
    }
    told = [f"supervisor.{name}" for name in ("mode", "destination", "target_elevation")]
    signals = (*_signals(facts), *told, f"{plant}.omega_B")
    return [Flight("station", changes, signals)], ""


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
    judge, h_w = _signals(facts)
    turned = (one["supervisor.destination"] == 6) & np.isin(one["supervisor.mode"], (2, 6))  # acquiring or there
    seen = turned & (one["supervisor.target_elevation"] > math.radians(HORIZON))
    if one.failure or not seen.any():
        why = one.failure or "The station was never tracked above the horizon."
        return Section("Station tracking", notes=[why]), (math.inf, "station")
    error = one[judge][seen]
    rate = np.linalg.norm(one[f"{facts.plant}.omega_B"][seen], axis=1)
    rows = [
        ["time above 10 deg of elevation, tracked", f"{one.time[seen][-1] - one.time[seen][0]:.0f} s"],
        ["highest elevation", f"{math.degrees(one['supervisor.target_elevation'][seen].max()):.1f} deg"],
        ["error, median", f"{math.degrees(np.median(error)):.3g} deg"],
        ["error, rms", f"{math.degrees(math.sqrt(float(np.mean(error**2)))):.3g} deg"],
        ["error, largest", f"{math.degrees(error.max()):.3g} deg"],
        ["largest body rate", f"{math.degrees(rate.max()):.3g} deg/s"],
        ["largest momentum of a wheel", f"{number(1e3 * float(np.abs(one[h_w][seen]).max()))} mN.m.s"],
    ]
    minutes = one.time / 60.0
    late = one.time > one.time[-1] - 1800.0
    curves = Curves(
        "Error to the line of sight",
        minutes[late].tolist(),
        "time, min",
        "error, deg",
        {"attitude error": np.degrees(one[judge][late]).tolist()},
        log=True,
    )
    note = f"A station {ASIDE:g} deg of arc beside the ground track; replay: orchestrate flights/station.yaml"
    section = Section("Station tracking", [Table("Tracking of a station", ["", "value"], rows, note)], [curves])
    return section, (float(error.max()), "station")


def failing(facts: Facts) -> list[Flight]:
    """Returns a hold without a failure, and one with each."""
    found: list[tuple[str, list[dict[str, Any]]]] = [("none", [])]
    at = f"{FAILS * facts.period:.6g} s"
    found += [(name, [{"at": at, **fault}]) for name, fault in studies.failures(facts).items()]
    signals = [*_signals(facts)]
    if facts.controller == "controller_planned":
        signals += [f"{facts.blocks[facts.controller]}.{name}" for name in ("rod_failed", "wheel_failed")]
    if "estimator" in facts.blocks:
        signals.append(f"{facts.blocks['estimator']}.health")
    signals += commands(facts)
    blocks = studies.merged(studies.hold(facts))
    duration = f"{ENDS * facts.period:.6g} s"
    return [
        Flight(
            f"failure-{name.replace(' ', '_')}",
            {"duration": duration, "blocks": blocks, "faults": faults},
            tuple(dict.fromkeys(signals)),
        )
        for name, faults in found
    ]


def failures(facts: Facts, flown: Mapping[str, Flown]) -> tuple[Section, Worst]:
    """Returns what is held after each failure and when it is found; the largest error after any of them, rad."""
    judge, h_w = _signals(facts)
    at = FAILS * facts.period
    rows = []
    worst: Worst = (0.0, "")
    for name in ("none", *studies.failures(facts)):
        flight = f"failure-{name.replace(' ', '_')}"
        one = flown[flight]
        last = one.time >= (ENDS - 1.0) * facts.period
        if one.failure or not last.any():
            rows.append([name, "–", "–", "–", "–", "–", one.failure or "too short"])
            worst = (math.inf, flight)
            continue
        error = np.degrees(one[judge][last])
        if name != "none":
            worst = max(worst, (float(one[judge][last].max()), flight))
        rms = math.sqrt(float(np.mean(error**2)))
        momentum = 1e3 * np.abs(one[h_w][last]).max()
        since = np.degrees(one[judge][one.time >= at]).max()
        told = [number(float(value)) for value in (since, rms, error.max(), momentum)]
        rows.append(
            [name, _found(facts, name, one, at), *told, f"lost: beyond {LOST:g} deg" if error.max() > LOST else ""]
        )
    columns = ["failure", "found after", "largest since, deg"]
    columns += ["rms, deg", "largest, deg", "wheel, mN.m.s", "remark"]
    note = (
        f"Each fails {FAILS:g} orbit after the start and stays so. Largest since: from the failure on; the other "
        "errors are of the orbit that begins an orbit later. Replay: orchestrate flights/failure-NAME.yaml"
    )
    notes = []
    if (
        facts.controller == "controller_planned"
        and not facts.start(facts.controller, "find_failures", np.ones(1)).all()
    ):
        notes.append("Rods and wheel are not watched for failures: find_failures of the controller is false.")
    return Section("Single failures", [Table("Single failures", columns, rows, note)], notes=notes), worst


def _found(facts: Facts, name: str, one: Flown, at: float) -> str:
    """Returns after which time a failure is reported, by the flag that is meant for it."""
    if name == "none":
        return "–"
    later = one.time >= at
    flag = None
    for sensor, place in HEALTH.items():
        if name.startswith(sensor) and "estimator" in facts.blocks:
            flag = one[f"{facts.blocks['estimator']}.health"][:, place] > 1
    for part in ("rod", "wheel"):
        if name.startswith(part) and facts.controller == "controller_planned":
            flag = one[f"{facts.blocks[facts.controller]}.{part}_failed"] > 0
    if flag is None:
        return "no block looks for it"
    raised = np.flatnonzero(flag & later)
    return f"{one.time[raised[0]] - at:.0f} s" if len(raised) else "not found"
