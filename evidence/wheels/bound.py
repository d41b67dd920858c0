"""The least time of a tumble with a set of wheels by the balance of momentum (design/momentum.py), s, and how far the
field lets the rods empty the wheels.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import controller
import plant
from controller.reference import lvlh
from controller.so3 import hat
from design.loop import parameters
from design.momentum import MomentumBalance, Tolerance
from fmus.interface import load

from ..flight.schemes import Data
from .cases import CONDITIONS, RATE, Flights, scenario

HORIZON = 6000.0
"""s"""


def of_plant(shared: Mapping[str, Any], start: Mapping[str, Any]) -> plant.Parameters:
    """The parameters of start values of a plant_wheels, those of `shared` beside them."""
    given: dict[tuple[str, int], Any] = {}
    for name, value in {**shared, **start}.items():
        v = load("plant_wheels").variables.get(name)
        if isinstance(value, Mapping):
            value = np.diag(value["diagonal"])
        elif v is not None and v.type == "enumeration":
            value = v.items.index(value) + 1
        given |= {(name, i): one for i, one in enumerate(np.ravel(value).tolist())}
    found: plant.Parameters = parameters("plant_wheels", given, plant)
    return found


def least_time(p: plant.Parameters) -> float | None:
    """To 5 deg and RATE, s; None beyond HORIZON."""
    law = parameters("controller", {}, controller)
    return MomentumBalance(p, law, None, Tolerance(math.radians(5.0), RATE), HORIZON).least_time(1.0).least


def fullest_wheel(p: plant.Parameters, begin: float, end: float, interval: float = 60.0) -> float:
    """The least share of its limit that the fullest wheel comes to between two times, s, in a hold of LVLH without
    error, by a linear programme: rods within their limits, any momentum at its begin.

    h' = m x b + d - Omega x h in LVLH for the wheels' momentum h, with dipoles that are constant over the intervals;
    the disturbance is the constant one, without drag.
    """
    from scipy.optimize import linprog  # optional, for this command alone  # noqa: PLC0415
    from scipy.sparse import csr_array, lil_array  # noqa: PLC0415

    times = np.arange(begin, end, interval) + 0.5 * interval
    n, wheels = len(times), p.wheels
    axes, limits = p.wheel_axes[:wheels].T, np.array(p.of_wheels(p.wheel_momentum_max)[:wheels])
    rods = (p.rods_to_body * p.rod_gain * p.dipole_limit).T
    size = 3 * n + wheels * (n + 1) + 1
    balance, full = lil_array((3 * n, size)), lil_array((2 * wheels * (n + 1), size))
    for k, t in enumerate(times.tolist()):
        target = lvlh(*p.orbit.position_velocity(t))
        turn = 0.5 * interval * hat(target.Omega_d) @ axes
        balance[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = -interval * np.cross(rods, target.R_d.T @ p.field.at(t)).T
        at = 3 * n + wheels * k
        balance[3 * k : 3 * k + 3, at : at + wheels] = turn - axes
        balance[3 * k : 3 * k + 3, at + wheels : at + 2 * wheels] = turn + axes
    for row, at in enumerate(range(3 * n, size - 1)):
        for sign in (0, 1):
            full[2 * row + sign, at] = (1.0 - 2.0 * sign) / limits[row % wheels]
            full[2 * row + sign, size - 1] = -1.0
    cost = np.zeros(size)
    cost[-1] = 1.0
    bounds = [(-1.0, 1.0)] * (3 * n) + [(None, None)] * (wheels * (n + 1)) + [(0.0, None)]
    pushed = np.tile(interval * np.asarray(p.disturbance_torque_B), n)
    found = linprog(cost, csr_array(full), np.zeros(full.shape[0]), csr_array(balance), pushed, bounds)
    return float(found.fun)


def plants(flights: Flights, runs: int) -> list[plant.Parameters]:
    """Of the first runs of a campaign."""
    data: Data = scenario(flights, CONDITIONS[flights.condition])
    shared = {**data["shared"], "rod_gain": data["blocks"]["plant"]["start"]["rod_gain"], "drag": True}
    found = []
    for values in flights.drawn(runs):
        start = {name.removeprefix("plant."): value for name, value in values.items() if name.startswith("plant.")}
        found.append(of_plant(shared, start))
    return found


def of_draws(flights: Flights, runs: int) -> list[float | None]:
    """Least times of the first runs of a campaign."""
    return [least_time(p) for p in plants(flights, runs)]
