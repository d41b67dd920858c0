"""Single flights of a review: slews, and each single failure.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestration.results.settling import settling
from plant.so3 import Array

from ..plausible import gyro
from . import studies
from .content import Section, Table, number
from .facts import Facts
from .flights import Flight, Flown
from .power import commands

ANGLES = (10, 30, 90, 180)
"""deg"""
FAILS, ENDS = 1.0, 3.0
"""Orbits after which a part fails, and the flight ends; the last orbit is looked at."""
HEALTH = {"gyro": 0, "magnetometer": 1, "GNSS": 2, "star tracker": 3, "sun sensors": 4}
"""Places in the estimator's `health`."""


def signals(facts: Facts) -> tuple[str, ...]:
    """Returns the names of what each manoeuvre is seen by."""
    return f"{facts.blocks['plant_judge']}.attitude_error", f"{facts.plant}.h_w"


def slews(facts: Facts) -> list[Flight]:
    """Returns flights from rest at some angles about each body axis, on an attitude that is measured to 0.01 deg."""
    made = []
    for angle in ANGLES:
        for i, axis in enumerate("xyz"):
            turn = studies.turned(facts, _turn(i, math.radians(angle)))
            blocks = studies.merged(*studies.perfect(facts), turn)
            made.append(
                Flight(f"slew-{angle}-{axis}", {"duration": f"{facts.period:.6g} s", "blocks": blocks}, signals(facts))
            )
    return made


def _turn(axis: int, angle: float) -> Array:
    """Returns the rotation (3,3) about a body axis."""
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = math.cos(angle)
    R[j, i], R[i, j] = math.sin(angle), -math.sin(angle)
    return R


LAW = 1.5
"""Least times beyond which not the actuators limit a slew."""
LOST = 90.0
"""deg: a satellite that is farther off in the orbit that is looked at does not hold its attitude."""
SETS = "allocator_bounded_wheels"
"""Finds wheels of a set that fail."""
Worst = tuple[float, str]
"""A metric, and the flight that has it."""


def agility(facts: Facts, flown: Mapping[str, Flown]) -> tuple[Section, Worst]:
    """Returns times and momenta of the slews beside the least, and the longest time until 5 deg, s."""
    judge, h_w = signals(facts)
    rows, ratios = [], []
    longest: Worst = (0.0, "")
    for angle in ANGLES:
        for axis in "xyz":
            name = f"slew-{angle}-{axis}"
            one = flown[name]
            within = [settling(one.time, one[judge], math.radians(level)).time for level in (5.0, 1.0)]
            longest = max(longest, (math.inf if within[0] is None else within[0], name))
            momentum = float(np.abs(one[h_w]).max())
            least = least_time(facts, "xyz".index(axis), math.radians(angle))
            ratios.append((math.inf if within[1] is None else within[1]) / least)
            told = [number(t, 4) if t is not None else "not within an orbit" for t in within]
            gathered = number(1e3 * momentum) if facts.wheels else "–"
            rows.append([f"{angle} deg", axis, *told, number(least, 4), gathered, one.failure or ""])
    columns = ["slew", "about", "below 5 deg after, s", "below 1 deg after, s", "least, s"]
    columns += ["largest momentum, mN.m.s", "failed"]
    middle = float(np.median(ratios))
    took = f"At the median the slews take {middle:.1f} times it to 1 deg"
    if math.isinf(middle):
        took = "Half of the slews do not come to 1 deg within an orbit"
    if facts.satellite.p.is_set:
        by = "the wheels' torques and momenta"
        took += f": {'the wheels' if middle < LAW else 'the law, not the wheels,'} set their time"
    else:
        by = f"{'wheel and ' * bool(facts.wheels)}rods, the field across it at its strongest, which it seldom is"
    note = (
        f"Times in steps of 2 s. Least: about that axis from rest to rest by {by}. {took}. "
        "From rest relative to the orbit, on an attitude that is measured to 0.01 deg at any rate: what actuators and "
        "law give. The tumbles have the times on the satellite's own sensors."
    )
    return Section("Agility", [Table("Slews", columns, rows, note)]), longest


def least_time(facts: Facts, axis: int, angle: float) -> float:
    """Returns the time, s, of a turn about a body axis by an angle, rad, from rest to rest: J e Omega grows by what the
    actuators give along e at most, and a set of wheels holds it; one wheel has rods beside it, which take momentum."""
    p = facts.satellite.p
    e = np.eye(3)[axis]
    J = float(e @ p.J_B @ e)
    along = [(abs(float(e @ a)), wheel) for a, wheel in zip(p.wheel_axes, p.wheel_list, strict=True)]
    torque = sum(share * wheel.torque_max for share, wheel in along)
    if not p.is_set:
        torque += float(np.linalg.norm(p.dipole_limit)) * 2.0 * facts.satellite.field
        return 2.0 * math.sqrt(angle * J / torque) if torque > 0.0 else math.inf
    rate = sum(share * wheel.momentum_max for share, wheel in along) / J
    a = torque / J
    return 2.0 * math.sqrt(angle / a) if angle < rate * rate / a else angle / rate + rate / a


def failing(facts: Facts) -> list[Flight]:
    """Returns a hold without a failure, and one with each."""
    found: list[tuple[str, list[dict[str, Any]]]] = [("none", [])]
    at = f"{FAILS * facts.period:.6g} s"
    found += [(name, [{"at": at, **fault}]) for name, fault in studies.failures(facts).items()]
    recorded = [*signals(facts)]
    if facts.controller == "controller_planned":
        recorded += [
            f"{facts.blocks[facts.controller]}.{name}" for name in ("rod_failed", "wheel_failed", "h_w_frozen")
        ]
    if SETS in facts.blocks:
        recorded += [f"{facts.blocks[SETS]}.wheel_failed", f"{facts.blocks[SETS]}.h_w_failed"]
    if "estimator" in facts.blocks:
        recorded.append(f"{facts.blocks['estimator']}.health")
    recorded += commands(facts)
    blocks = studies.merged(studies.hold(facts))
    duration = f"{ENDS * facts.period:.6g} s"
    return [
        Flight(
            f"failure-{name.replace(' ', '_')}",
            {"duration": duration, "blocks": blocks, "faults": faults},
            tuple(dict.fromkeys(recorded)),
        )
        for name, faults in found
    ]


def failures(facts: Facts, flown: Mapping[str, Flown]) -> tuple[Section, Worst]:
    """Returns what is held after each failure and when it is found; the largest error after any of them, rad."""
    judge, h_w = signals(facts)
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
        told = [number(float(value)) for value in (since, rms, error.max())]
        told.append(number(float(momentum)) if facts.wheels else "–")
        goal = math.degrees(facts.goal)
        remark = "beyond the goal" if error.max() > goal else "beyond the goal for a while" if since > goal else ""
        remark = f"lost: beyond {LOST:g} deg" if error.max() > LOST else remark
        rows.append([name, _found(facts, name, one, at), *told, remark])
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
    if "estimator" in facts.blocks:
        notes += _of_estimator(facts, [name for name in studies.failures(facts) if name.endswith("lost")])
    return Section("Single failures", [Table("Single failures", columns, rows, note)], notes=notes), worst


def _of_estimator(facts: Facts, lost: list[str]) -> list[str]:
    """Returns what its flags do not tell, and what it is not told."""
    estimator = facts.blocks["estimator"]
    fed = {(c.target.block, c.target.variable) for c in facts.scenario.connections}
    notes = []
    if lost:
        notes.append(
            f"{', '.join(lost)}: a sensor that gives nothing is no failure to the estimator, as where it is blinded or "
            f"in eclipse. {estimator}.health stays good; {estimator}.attitude_bound, the bound on its error, grows."
        )
    if "gyro frozen" in studies.failures(facts) and (without := gyro.lost(facts.satellite)):
        notes.append(f"gyro frozen: {without}.")
    if facts.wheels and not {(estimator, "h_w"), (estimator, "wheel_torque")} & fed:
        notes.append(
            "gyro frozen: without its gyro the estimator follows the equations of motion, but it is not told the "
            f"momenta of the wheels, and takes their torques for disturbances: connect {estimator}.h_w and "
            f"{estimator}.dipole."
        )
    return notes


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
    if name.startswith("telemetry") and facts.controller == "controller_planned":
        flag = one[f"{facts.blocks[facts.controller]}.h_w_frozen"] > 0
    for start, output in (("wheel", "wheel_failed"), ("telemetry", "h_w_failed")):
        if name.startswith(start) and SETS in facts.blocks:
            flag = one[f"{facts.blocks[SETS]}.{output}"][:, int(re.findall(r"\d+", name)[0]) - 1] > 0
    if flag is None:
        return "no block looks for it"
    raised = np.flatnonzero(flag & later)
    if not len(raised):
        return "no flag: gives nothing" if name.endswith("lost") else "not found"
    return f"{one.time[raised[0]] - at:.0f} s"
