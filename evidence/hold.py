"""How close to the target any motion can stay: the least largest error that IPOPT finds, with rods as strong as one likes.

Rods give no torque along the field. So the angular momentum along it has a balance that no controller changes, and across it rods
without a limit give whatever a motion needs. With the rotation vector theta from LVLH to body, Q = exp(theta^), the rate nu of the
body relative to LVLH, the momentum l of the wheel along a, the field's direction b and its rate of change c in N, all in LVLH axes:

    d(b.h)/dt = b.(Q tau_d + M_gg + Q M_drag) + c.h,    h = Q J Q^T (Omega_d + nu) + l Q a.

The motion may begin with any attitude, rate and wheel momentum. It knows the satellite, its orbit and all torques. But for what
happens within an interval it is free to do all that a real satellite may, so no flight is closer than the least optimum. What is
found is a local one. The rate follows from theta to the second order. evidence/hold_bound.py has the other side, a proof. Orbits are
circular.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

import plant

from .hold_bound import E3, Course
from .motion import IPOPT
from .paper import Array

INTERVAL = 40.0
"""s, in which the rate and the change of the wheel's momentum are constant, at most."""
EASES = (1e-1, 1e-2, 1e-3)
"""Weights of the mean squares of angle, wheel and rate beside the largest error: a search with each, since it ends at a local optimum."""
OF_RATE = 10.0
"""Weight of the rate's mean square over those of angle and wheel."""
SPEED, BLUNT = 7600.0, 1e-6
"""m/s; how blunt the edge is where a plate turns into the flow, of the square of its cosine."""
SEARCH = {**IPOPT, "ipopt": {**IPOPT["ipopt"], "max_iter": 500, "mu_strategy": "monotone", "mu_init": 1e-2}}


def least(p: plant.Parameters, begin: float, end: float, rate: float, repeats: bool = False) -> float:
    """The least largest error, rad, of a motion between two of the plant's times, s, at a rate below `rate`, rad/s; NaN without one.

    `repeats`: it goes on as it began, with attitude, rate and wheel momentum, in the interval after the end. A wheel without torque keeps
    its momentum `h_w0`. Raises InputError for an orbit that is not circular.
    """
    course = Course.of(p, begin, end, INTERVAL, more=int(repeats))
    n = course.count
    balance = _balance(p, course, rate).map(n)
    theta, l_w, largest = ca.MX.sym("theta", 3, n + 1), ca.MX.sym("l", 1, n), ca.MX.sym("largest")
    momentum, gain, nu = balance(theta[:, :-1], theta[:, 1:], l_w, *_middles(course))
    balanced = momentum[1:] - momentum[:-1] - 0.5 * (gain[1:] + gain[:-1])
    closed = ca.vertcat(ca.vec(theta[:, -2:] - theta[:, :2]), l_w[-1] - l_w[0]) if repeats else ca.MX(0, 1)
    within = ca.vertcat(ca.sum1(theta**2).T - largest**2, ca.sum1(nu**2).T - 1.0)
    uneasy = ca.sumsqr(theta) / n + ca.sumsqr(l_w) / n + OF_RATE * ca.sumsqr(nu) / n
    x = ca.vertcat(ca.vec(theta), l_w.T, largest)
    zero, turned, momenta = (
        balanced.numel() + closed.numel(),
        np.full(3 * n + 3, math.pi),
        np.full((2, n), [[-1.0], [1.0]]),
    )
    if p.wheel_torque_max == 0.0:
        momenta[:] = p.h_w0 / (p.wheel_momentum_max or 1.0)
    low, high = np.concatenate((-turned, momenta[0], [0.0])), np.concatenate((turned, momenta[1], [math.pi]))
    best = math.nan
    for ease in EASES:
        problem = {"x": x, "f": largest + ease * uneasy, "g": ca.vertcat(balanced.T, closed, within)}
        solver = ca.nlpsol("hold", "ipopt", problem, SEARCH)
        found = solver(
            x0=np.append(np.zeros(len(high) - 1), 0.5),
            lbx=low,
            ubx=high,
            lbg=np.append(np.zeros(zero), np.full(within.numel(), -np.inf)),
            ubg=0.0,
        )
        if solver.stats()["success"]:
            theta_found = np.asarray(found["x"]).ravel()[: 3 * n + 3].reshape(-1, 3)
            best = float(np.fmin(best, np.linalg.norm(theta_found, axis=1).max()))
    return best


def _balance(p: plant.Parameters, course: Course, rate: float) -> ca.Function:
    """Of an interval: its momentum along the field and what that gains, both in one unit, and nu over `rate`."""
    first, last, v, b, c = (ca.SX.sym(name, 3) for name in ("first", "last", "v", "b", "c"))
    l_w, density = ca.SX.sym("l"), ca.SX.sym("density")
    J, Omega_d, dt = ca.DM(p.body.J), ca.DM(course.Omega_d), course.interval
    theta, change = 0.5 * (first + last), (last - first) / dt
    Q = _turn(theta)
    nu = change + 0.5 * ca.cross(theta, change) + ca.cross(theta, ca.cross(theta, change)) / 6.0
    of_LVLH = Q @ J @ Q.T
    h = of_LVLH @ (Omega_d + nu) + l_w * p.wheel_momentum_max * (Q @ p.body.wheel_axis)
    gravity = 3.0 * p.gravity_gradient * ca.sumsqr(Omega_d) * ca.cross(E3, of_LVLH @ E3)
    torque = Q @ (p.disturbance_torque_B + _drag(p, Q.T @ v, density)) + gravity
    unit = max(p.wheel_momentum_max, 5.0 * dt * float(np.linalg.norm(p.disturbance_torque_B)))
    gain = dt * (ca.dot(b, torque) + ca.dot(c, h)) / unit
    return ca.Function("balance", [first, last, l_w, v, density, b, c], [ca.dot(b, h) / unit, gain, nu / rate])


def _turn(theta: ca.SX) -> ca.SX:
    """exp(theta^) (3,3)."""
    angle = ca.sqrt(ca.sumsqr(theta) + 1e-12)
    hat = ca.skew(theta)
    return ca.SX.eye(3) + ca.sin(angle) / angle * hat + (1.0 - ca.cos(angle)) / angle**2 * hat @ hat


def _drag(p: plant.Parameters, v_B: ca.SX, density: ca.SX) -> ca.SX:
    """Moment (3,) of plant/drag.py, N m, its edges a little blunt."""
    along = ca.DM(p.surface.normals) @ v_B / SPEED
    facing = 0.5 * SPEED * (along + ca.sqrt(along**2 + BLUNT))
    return ca.cross(ca.DM(p.surface.arms).T @ facing, -density * v_B)


def _middles(course: Course) -> tuple[Array, Array, Array, Array]:
    """In the middle of each interval v (3,n), density (1,n), b (3,n) and c (3,n)."""
    v, b, c = (x[1::2].T for x in (course.v, course.b, course.c))
    return v, course.density[None, 1::2], b, c
