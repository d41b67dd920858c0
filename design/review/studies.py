"""What a review flies: the tumbles, the holds of the pointing budget, slews, a station, and single failures.

Errors keep the size that the file states; their directions and signs are drawn.
Tests: tests/design/review/test_studies.py.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fmus import places
from orchestration.scenario.text import parse
from plant.so3 import Array

from .facts import Facts

VECTORS = {
    "plant": ("residual_dipole_B", "disturbance_torque_B"),
    "plant_sensors": ("rate_bias_B", "field_bias_B", "attitude_bias_B"),
}
MATRICES = {"plant": ("J_error_B",), "plant_sensors": ("rate_scale", "field_scale")}
"""Constant errors, whose directions, and signs, are drawn."""
CONTRIBUTORS: dict[str, tuple[str, dict[str, Any]]] = {
    "residual dipole": ("plant", {"residual_dipole_B": 3}),
    "constant torque": ("plant", {"disturbance_torque_B": 3}),
    "inertia not known": ("plant", {"J_error_B": 9}),
    "drag": ("plant", {"drag": False}),
    "sunlight": ("plant", {"solar_pressure": False}),
    "gravity gradient": ("plant", {"gravity_gradient": False}),
    "gyro": (
        "plant_sensors",
        {
            **dict.fromkeys(("rate_noise", "angle_random_walk", "rate_random_walk", "rate_instability"), 1),
            "rate_quantum": 1,
            "rate_bias_B": 3,
            "rate_scale": 9,
        },
    ),
    "magnetometer": (
        "plant_sensors",
        {"field_noise": 1, "field_quantum": 1, "field_bias_B": 3, "field_scale": 9, "field_rod_coupling": 9},
    ),
    "sun sensors": ("plant_sensors", {"sun_sensor_noise": 1, "fine_sun_noise": 1, "albedo": 1}),
    "field of view of sun sensors": ("plant_sensors", {"sun_sensor_half_angle": "90 deg"}),
    "star tracker": (
        "plant_sensors",
        {
            **dict.fromkeys(("attitude_noise", "attitude_noise_about", "attitude_outage_interval"), 1),
            "attitude_bias_B": 3,
        },
    ),
    "GNSS": ("plant_sensors", dict.fromkeys(("position_noise", "velocity_noise", "orbit_outage_interval"), 1)),
    "telemetry": ("plant_sensors", {"wheel_momentum_noise": 1, "dipole_noise": 1}),
}
"""By contributor of the budget: kind of block, and its start values with how many zeros, or which value, take it
away."""


def contributors(facts: Facts) -> list[str]:
    """Returns those that the file has: one of their values is not zero."""
    p = facts.satellite.p
    found = []
    for name, (kind, values) in CONTRIBUTORS.items():
        if kind == "plant":
            there = any(np.any(getattr(p, key)) for key in values)
        else:
            there = any(facts.size(kind, key) > 0.0 for key in values)
        there &= aboard(facts, name)
        if name.startswith("field of view"):
            there = 0.0 < facts.size(kind, "sun_sensor_half_angle") < math.radians(89.9)
        if there:
            found.append(name)
    return found


def aboard(facts: Facts, name: str) -> bool:
    """Returns whether the satellite has what a contributor is of; a star tracker that gives no attitude at any rate is
    none.
    """
    sensors = "plant_sensors"
    if CONTRIBUTORS[name][0] == sensors and sensors not in facts.blocks:
        return False
    return name != "star tracker" or not 0.0 < facts.size(sensors, "attitude_rate_max") < 1e-9


def without(facts: Facts, names: list[str]) -> dict[str, dict[str, Any]]:
    """Returns start values by block that take contributors away."""
    starts: dict[str, dict[str, Any]] = {}
    for name in names:
        kind, values = CONTRIBUTORS[name]
        block = facts.plant if kind == "plant" else facts.blocks[kind]
        for key, zeros in values.items():
            starts.setdefault(block, {})[key] = _zeros(zeros)
    return starts


def _zeros(count: Any) -> Any:
    if count is False or isinstance(count, str):
        return count
    return {1: 0, 3: [0, 0, 0], 9: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]}[count]


def drawn(facts: Facts, tumble: bool) -> dict[str, dict[str, Any]]:
    """Returns what varies, as a campaign's file has it; with `tumble` the attitude and the rate at the start, too."""
    vary: dict[str, dict[str, Any]] = {}
    p = facts.satellite.p
    if tumble:
        vary[f"{facts.plant}.Q0"] = {"rotation": "uniform"}
        if rate := float(np.linalg.norm(p.omega_B0)):
            vary[f"{facts.plant}.omega_B0"] = {"sphere": rate}
    for kind, names in VECTORS.items():
        for name in names:
            size = float(np.linalg.norm(getattr(p, name))) if kind == "plant" else facts.size(kind, name)
            if size > 0.0:
                vary[f"{_block(facts, kind)}.{name}"] = {"sphere": size}
    for kind, names in MATRICES.items():
        for name in names:
            M = getattr(p, name) if kind == "plant" else facts.start(kind, name, np.zeros(9))
            if np.any(M):
                matrix = np.asarray(M).reshape(3, 3)
                vary[f"{_block(facts, kind)}.{name}"] = {"choice": [matrix.tolist(), (-matrix).tolist()]}
    if "plant_sensors" in facts.blocks:
        vary[f"{facts.blocks['plant_sensors']}.seed"] = {"integers": [1, 1_000_000]}
    return vary


def _block(facts: Facts, kind: str) -> str:
    return facts.plant if kind == "plant" else facts.blocks[kind]


def hold(facts: Facts) -> dict[str, dict[str, Any]]:
    """Returns start values of the plant at rest in the attitude that is held."""
    return turned(facts, np.eye(3))


def turned(facts: Facts, turn: Array) -> dict[str, dict[str, Any]]:
    """The same, turned from the attitude that is held by a rotation (3,3), at rest relative to LVLH."""
    Q0 = facts.R_d0 @ turn
    rate = 2.0 * math.pi / facts.period
    start = {"initial_attitude": "Q0", "Q0": Q0.tolist(), "omega_B0": (Q0.T @ [0.0, -rate, 0.0]).tolist()}
    return {facts.plant: start}


def merged(*starts: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Returns the entry `blocks` of a scenario with start values of several, the last one's over the others'."""
    blocks: dict[str, Any] = {}
    for one in starts:
        for block, values in one.items():
            blocks.setdefault(block, {"start": {}})["start"].update(values)
    return blocks


def perfect(facts: Facts) -> list[dict[str, dict[str, Any]]]:
    """Returns start values with which sensors measure the attitude at any rate, and nothing else is wrong."""
    if not {"plant_sensors", "estimator"} <= facts.blocks.keys():
        return []
    path = places.shared("scenarios") / "templates" / "satellite" / "sensors_perfect.yaml"
    text = parse(path.read_text("utf-8"), str(path)).data["blocks"]
    sensors = [n for n in contributors(facts) if CONTRIBUTORS[n][0] == "plant_sensors"]
    free = dict.fromkeys(("attitude_rate_max", "attitude_sun_exclusion", "attitude_earth_exclusion"), 0)
    told = {facts.blocks["estimator"]: text["estimator"]["start"]}
    measured = {facts.blocks["plant_sensors"]: {**free, **text["sensors"]["start"]}}
    return [without(facts, sensors), measured, told]


def failures(facts: Facts) -> dict[str, dict[str, str]]:
    """Returns by name the single failures, each as the entry of a scenario's fault without its time."""
    p, plant = facts.satellite.p, facts.plant
    found: dict[str, dict[str, str]] = {}
    for i in range(3):
        found[f"rod {i + 1} dead"] = {"cut": f"{plant}.dipole_cmd[{i + 1}]"}
    motors = p.of_wheels(p.wheel_torque_max)
    for i, torque in enumerate(motors, start=1):
        if torque > 1e-8:
            element = f"[{i}]" if p.is_set else ""
            named = f"wheel {i} stuck" if p.is_set else "wheel stuck"
            found[named] = {"cut": f"{plant}.wheel_torque_cmd{element}"}
    sensors = facts.blocks.get("plant_sensors")
    fed = {str(c.source).partition("[")[0] for c in facts.scenario.connections}
    outputs = {
        "gyro frozen": "omega_B_measured",
        "magnetometer frozen": "b_B_measured",
        "sun sensors lost": "sun_B_measured",
        "star tracker lost": "R_NB_measured",
        "GNSS frozen": "r_N_measured",
    }
    if sensors and f"{sensors}.h_w_measured" in fed:
        for i in facts.wheels:
            of, element = (f"telemetry of wheel {i + 1}", f"[{i + 1}]") if p.is_set else ("telemetry of the wheel", "")
            found[f"{of} frozen"] = {"freeze": f"{sensors}.h_w_measured{element}"}
    for name, port in outputs.items():
        if sensors and f"{sensors}.{port}" in fed:
            if name.startswith("star") and "star tracker" not in contributors(facts):
                continue
            kind = "cut" if "lost" in name else "freeze"
            found[name] = {kind: f"{sensors}.{port}"}
    return found
