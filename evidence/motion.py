"""The satellite's motion relative to LVLH in CasADi, from the plant's parameters, for the studies that optimise it.

x (7 + n,) = (q, 50 s Omega, 50 s l / kg m2): attitude as a quaternion, scalar first, body rate and momenta of n wheels;
u (3 + n,): the rods' dipoles and the wheels' torques as shares of their limits. Gravity gradient and the constant
disturbance act, drag does not. Tests: tests/evidence/optimum/test_least_time.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

import plant

from .paper import Array

SECONDS = 50.0
"""The unit of time: rates, momenta and T are of the order of one in it."""
IPOPT: dict[str, Any] = {
    "print_time": False,
    "ipopt": {
        "print_level": 0,
        "sb": "yes",
        "max_iter": 150,
        "tol": 1e-5,
        "acceptable_tol": 1e-3,
        "acceptable_constr_viol_tol": 1e-6,
        "acceptable_iter": 8,
        "mu_strategy": "adaptive",
    },
}


def matrix(q: ca.SX) -> ca.SX:
    """The rotation (3,3) of a unit quaternion (4,), scalar first."""
    v = q[1:]
    return (q[0] ** 2 - ca.dot(v, v)) * ca.SX.eye(3) + 2.0 * v @ v.T + 2.0 * q[0] * ca.skew(v)


def rates(p: plant.Parameters, turn: Array, x: ca.SX, u: ca.SX, field: ca.SX) -> ca.SX:
    """dx/dt in SECONDS under a field (3,) in LVLH, T, with LVLH's rate (3,), rad/s."""
    J = ca.DM(p.body.J)
    q, Omega, l_w = x[:4], x[4:7] / SECONDS, x[7:] / SECONDS
    Q_T = matrix(q).T
    omega = Omega - Q_T @ turn
    dipole_B = ca.DM(p.rods_to_body * p.rod_gain * p.dipole_limit) @ u[:3] + p.residual_dipole_B
    down = -Q_T[:, 2]
    gravity = 3.0 * float(turn @ turn) * ca.cross(down, J @ down)
    tau_w = ca.DM(p.of_wheels(p.wheel_torque_max)) * u[3:]
    axes = ca.DM(p.wheel_axes.T)
    tau = ca.cross(dipole_B, Q_T @ field) + gravity + p.disturbance_torque_B
    tau -= axes @ tau_w + ca.cross(Omega, J @ Omega + axes @ l_w)
    dq = 0.5 * ca.vertcat(-ca.dot(q[1:], omega), q[0] * omega + ca.cross(q[1:], omega))
    return ca.vertcat(SECONDS * dq, SECONDS**2 * (ca.DM(p.body.J_inverse) @ tau), SECONDS**2 * tau_w)


def advanced(p: plant.Parameters, turn: Array, x: ca.SX, u: ca.SX, h: ca.SX, fields: Sequence[ca.SX]) -> ca.SX:
    """x after h SECONDS by the classical Runge-Kutta method; fields at the begin, in the middle and at the end."""
    first, middle, last = fields
    a = rates(p, turn, x, u, first)
    b = rates(p, turn, x + 0.5 * h * a, u, middle)
    c = rates(p, turn, x + 0.5 * h * b, u, middle)
    d = rates(p, turn, x + h * c, u, last)
    return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
