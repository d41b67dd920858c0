"""The momentum bound of a flight: the least time that the balance of momentum allows for it.
Tests: tests/evidence/test_hold_bound.py."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from design.loop import Loop, read
from design.momentum import MomentumBalance, Tolerance
from orchestration.scenario.source import Source

from .cases import RATE, Group
from .schemes import Data, change


def starts(group: Group) -> list[Data]:
    """Returns what the bound needs of each flight: the plant with its start values, and what the blocks share."""
    found = []
    for values in group.drawn():
        data = {"blocks": {"plant": dict(group.scenario["blocks"]["plant"])}, "shared": group.scenario["shared"]}
        data["blocks"]["plant"]["start"] = dict(data["blocks"]["plant"]["start"])
        found.append(change(data, {name: value for name, value in values.items() if name.startswith("plant.")}))
    return found


def loop(data: Mapping[str, Any]) -> Loop:
    """The plant of one of `starts`, under the paper's controller and allocator."""
    wires = {
        "plant": {"R_NB": "controller", "omega_B": "controller", "r_N": "controller", "v_N": "controller"},
        "controller": {"tau_cmd_B": "allocator"},
        "allocator": {"dipole_cmd": "plant", "wheel_torque_cmd": "plant"},
    }
    connections = [f"{a}.{port} -> {b}.{port}" for a, ports in wires.items() for port, b in ports.items()]
    connections += [f"plant.{port} -> allocator.{port}" for port in ("b_B", "omega_B", "h_w")]
    blocks = {name: {"fmu": name} for name in wires} | {"plant": data["blocks"]["plant"]}
    scenario = {"name": "bound", "step": 0.1, "duration": 1.0, "shared": data["shared"]}
    return read(Source({**scenario, "blocks": blocks, "connections": connections})).loop


def bound(data: Mapping[str, Any], horizon: float = 3000.0) -> float | None:
    """The least time, s, from one of `starts` to 5 deg and RATE; None beyond the horizon, s."""
    around = loop(data)
    rods = around.plant.dipole_max * float(np.max(around.plant.rod_gain))
    balance = MomentumBalance(around.plant, around.controller, rods, Tolerance(math.radians(5.0), RATE), horizon)
    return balance.least_time().least
