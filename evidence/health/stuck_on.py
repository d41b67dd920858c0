"""What a hold can be with one rod stuck on: the least largest angle that any use of other rods and wheel leaves.

With theta, the small turn from LVLH, the rate w relative to it, body axes along LVLH, and the field B there,

    J dw/dt = d + (m + sum_j m_j u_j) x B - m x (theta x B) - dl/dt a - n x a l,    dtheta/dt = w - n x theta,

to first order in theta, where the dipole m of the stuck rod turns with the body. The dipoles m_j, the wheel's torque
and momentum l are within their limits; attitude, rate and l at the beginning are free, and all that comes is known.
The least angle, of which the parts along 13 directions are no larger, is then a linear programme; a controller has no
such foresight. It is no proof: the products of dipoles m_j and theta, of second order, are left out. So is the gravity
gradient: 3 n^2 J theta is a hundredth of m x B. Angles beyond 30 deg say only that they are large.
Tests: tests/evidence/health/test_stuck_on.py.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import yaml
from scipy.optimize import linprog

import controller.reference
import plant
from controller.so3 import hat
from orchestration import InputError

from ..flight.bound import loop
from ..markdown import degrees, table
from ..paper import ORBIT, ROOT, Array

INTERVAL = 30.0
"""s; the field turns by 4 deg in it at most."""
DISTURBANCE = [6e-6, -5e-6, 6e-6]
"""N m, that of scenarios/flight_estimated.yaml."""
DUTY = 0.8
"""The share of each half second in which the rods are on."""
STATE = 7
"""theta, w, l; behind them in each interval the dipoles and the wheel's torque."""


ALONG = np.array([v for v in itertools.product((-1, 0, 1), repeat=3) if v > (0, 0, 0)], float)
ALONG /= np.linalg.norm(ALONG, axis=1, keepdims=True)
"""(13, 3) unit vectors to faces, edges and corners of a cube: of an angle the part along each is no larger."""


@dataclass(frozen=True)
class Held:
    """A satellite that is held: J (3,3) kg m2, rods that work (k,3), their limit, the wheel's axis (3,) and its limits
    of torque and momentum, the orbital rate (3,) rad/s and a disturbance (3,) N m, both in body axes."""

    J: Array
    rods: Array
    dipole_max: float
    axis: Array
    torque_max: float
    momentum_max: float
    n: Array
    disturbance: Array


def least_angle(s: Held, B: Array, m: Array, dt: float) -> float:
    """The least largest part of theta, rad, with a dipole m (3,), A m2, in the field B (N,3), T, each for dt, s.

    Raises InputError where none is found.
    """
    count, k = len(B), len(s.rods)
    width = STATE + k + 1
    scaled = dt * np.linalg.inv(s.J)
    step, given = np.zeros((count, STATE, width)), np.zeros((count, STATE))
    step[:, :, :STATE] = np.eye(STATE)
    step[:, 3:6, 6] = -scaled @ np.cross(s.n, s.axis)
    step[:, 3:6, -1] = -scaled @ s.axis
    step[:, 6, -1] = dt
    step[:, :3, :3] -= dt * hat(s.n)
    for i, b in enumerate(B):
        step[i, 3:6, :3] = scaled @ hat(m) @ hat(b)
        step[i, 3:6, STATE : STATE + k] = scaled @ np.cross(s.rods, b).reshape(k, 3).T
        given[i, 3:6] = scaled @ (s.disturbance + np.cross(m, b))
    step[:, :3] += 0.5 * dt * step[:, 3:6]  # the mean rate over the interval
    step[:, :3, 3:6] += 0.5 * dt * np.eye(3)
    given[:, :3] += 0.5 * dt * given[:, 3:6]
    ends = sp.kron(sp.eye(count, count + 1, 1), sp.eye(STATE, width))
    A = sp.hstack(
        (ends - sp.block_diag((sp.block_diag(step), sp.csr_matrix((0, width)))), sp.csr_matrix((given.size, 1)))
    )
    turn = sp.kron(sp.eye(count + 1), sp.hstack((sp.csr_matrix(ALONG), sp.csr_matrix((len(ALONG), width - 3)))))
    most = sp.csr_matrix(np.ones((turn.shape[0], 1)))
    limits = np.tile([*[np.inf] * 6, s.momentum_max, *[s.dipole_max] * k, s.torque_max], count + 1)
    cost = np.zeros(width * (count + 1) + 1)
    cost[-1] = 1.0
    programme = (
        cost,
        sp.vstack((sp.hstack((turn, -most)), sp.hstack((-turn, -most)))),
        np.zeros(2 * turn.shape[0]),
        A,
        given.ravel(),
        np.column_stack((-np.append(limits, 0.0), np.append(limits, np.inf))),
    )
    for method in ("highs", "highs-ipm"):  # the first one now and then ends without an answer
        found = linprog(*programme, method=method)
        if found.status == 0:
            return float(found.fun)
    raise InputError(f"the least angle was not found: {found.message}")


def held(
    p: plant.Parameters,
    works: Sequence[int],
    disturbance: Sequence[float] = DISTURBANCE,
    wheel: bool = True,
    begin: float = 0.0,
) -> tuple[Held, Array]:
    """The plant with the rods that work, 0 to 2, with its wheel or without one, and the field (N,3) that it meets in
    LVLH along an orbit and a half from `begin`, s, on; disturbance (3,) N m."""
    times = begin + np.arange(0.0, 1.5 * ORBIT, INTERVAL)
    frames = [controller.reference.lvlh(*p.orbit.position_velocity(t)) for t in times]
    B = np.array([frame.R_d.T @ p.field.at(t) for frame, t in zip(frames, times, strict=True)])
    axis, n = np.asarray(p.wheel_axes[0], float), np.array(frames[0].Omega_d)
    J, rods = np.asarray(p.body.J), np.asarray(p.rod_axes)[list(works)]
    torque, momentum = (p.wheel_torque_max, p.wheel_momentum_max) if wheel else (0.0, 0.0)
    return Held(J, rods, DUTY * p.dipole_max, axis, torque, momentum, n, np.array(disturbance)), B


def of_satellite(name: str, changes: Mapping[str, float] | None = None) -> plant.Parameters:
    """The plant of scenarios/satellites/NAME.yaml, with other shared values."""
    shared = yaml.safe_load((ROOT / "scenarios" / "satellites" / f"{name}.yaml").read_text())["shared"]
    return loop({"blocks": {"plant": {"fmu": "plant"}}, "shared": shared | dict(changes or {})}).plant


def make() -> str:
    """A Markdown table of the 50 kg satellite: the least angle with each rod stuck on at shares of its limit."""
    p = of_satellite("paper_50kg")
    shares = (0.05, 0.1, 0.2)
    rows = []
    for stuck in range(3):
        satellite, B = held(p, [i for i in range(3) if i != stuck])
        dipole = p.dipole_max * np.asarray(p.rod_axes)[stuck]
        angles = [math.degrees(least_angle(satellite, B, share * dipole, INTERVAL)) for share in shares]
        rows.append([f"rod {stuck + 1}", *map(degrees, angles)])
    return table(rows, "|".join(("stuck on", *(f"at {share:.0%}" for share in shares))))
