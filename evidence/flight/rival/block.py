"""Non-monotonic detumbling (Willis, Fisch, Seletskiy and Manchester, arXiv 2407.02724), then a
proportional-derivative law.

Detumbling: with dipoles m1 now and m2 after `look_ahead` the momentum h = J Omega becomes h1 = h - b1 x m1, and then
h2 = h1 - b2 x m2 (b1, b2: directions of the field, momentum in units of the product). Of all dipoles those are sought
for which

    |h1|^2 + alpha |h2|^2 + |m1|^2 + |m2|^2

is least; m1, within the limit, is applied. So h1 may grow where h2 falls the more. The field b2 is the measured one
plus the change of a dipole field along the orbit. Not in that paper: the wheel is at rest while the rods detumble,
and the second law. Tests: tests/evidence/flight/test_rival.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIPOLE = -3.0e-5 * 6.371e6**3
"""T m3: that of the Earth, along its axis."""


@dataclass(frozen=True)
class Parameters:
    J_B: Array
    dipole_max: float
    look_ahead: float
    alpha: float
    detumble_gain: float
    slow: float
    K: float
    L: float


@dataclass(frozen=True)
class Inputs:
    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array


@dataclass(frozen=True)
class State:
    t: float
    """s"""
    detumbling: bool
    """Whether the last sample did."""


@dataclass(frozen=True)
class Outputs:
    tau_cmd_B: Array
    detumbling: bool


def check(p: Parameters) -> None:
    """Raises ValueError where the inertia is none."""
    if not (np.linalg.eigvalsh(p.J_B) > 0.0).all():
        raise ValueError(f"J_B is {p.J_B.tolist()}; expected a positive definite matrix")


def start(p: Parameters, u: Inputs) -> State:
    return State(0.0, True)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The torque of these inputs; changes no memory."""
    Q, omega_d = _lvlh(u)
    omega = u.omega_B - omega_d
    rate = math.sqrt(omega @ omega)
    detumbling = rate > (2.0 if not x.detumbling else 1.0) * p.slow
    if detumbling:
        return Outputs(np.cross(detumble(u, p), u.b_B), True)
    # The error is the axial vector of the antisymmetric part, grown to that of the rotation's axis past 90 deg.
    s = 0.5 * np.array((Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]))
    half = math.sqrt(max(0.5 * (1.0 + 0.5 * (Q[0, 0] + Q[1, 1] + Q[2, 2] - 1.0)), 1e-12))
    tau = -p.K * s / half - p.L * omega + np.cross(u.omega_B, p.J_B @ u.omega_B)
    return Outputs(tau, False)


def detumble(u: Inputs, p: Parameters) -> Array:
    """The dipole (3,), A m2, of least norm after two steps."""
    now = u.b_B / math.sqrt(u.b_B @ u.b_B)
    r = math.sqrt(u.r_N @ u.r_N)
    up, along = u.r_N / r, u.v_N / math.sqrt(u.v_N @ u.v_N)
    angle = p.look_ahead * math.sqrt(u.v_N @ u.v_N) / r
    later = math.cos(angle) * up + math.sin(angle) * along
    ahead = u.b_B + u.R_NB.T @ (_dipole(later, r) - _dipole(up, r))
    ahead /= math.sqrt(ahead @ ahead)
    h = p.J_B @ u.omega_B
    A = np.hstack((_hat(now), _hat(ahead)))
    first = np.hstack((_hat(now), np.zeros((3, 3))))
    M = np.eye(6) + first.T @ first + p.alpha * A.T @ A
    m = np.linalg.solve(M, first.T @ h + p.alpha * A.T @ h)[:3]
    return p.dipole_max * np.tanh(p.detumble_gain * m)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h, and the outputs there."""
    found = outputs(x, u, p)
    return replace(x, t=x.t + h, detumbling=found.detumbling), found


def _lvlh(u: Inputs) -> tuple[Array, Array]:
    """Attitude relative to LVLH (3,3), and the rate of LVLH in body axes (3,), rad/s."""
    h = np.cross(u.r_N, u.v_N)
    z = -u.r_N / math.sqrt(u.r_N @ u.r_N)
    y = -h / math.sqrt(h @ h)
    R_d = np.array((np.cross(y, z), y, z)).T
    return R_d.T @ u.R_NB, u.R_NB.T @ (h / (u.r_N @ u.r_N))


def _dipole(up: Array, r: float) -> Array:
    """Field (3,), T, of a dipole along the Earth's axis, at the direction `up` and r, m."""
    return DIPOLE / r**3 * (3.0 * up[2] * up - np.array((0.0, 0.0, 1.0)))


def _hat(a: Array) -> Array:
    return np.array(((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0)))
