"""The satellite's motion relative to LVLH as a step of CasADi, from the plant's parameters.

x = (q, 50 s Omega, 50 s l / kg m2): attitude as a quaternion, scalar first, body rate and wheel momentum; u: the rods' dipoles and
the wheel's torque as shares of their limits. The field along the orbit is the plant's, as Chebyshev series of time. Gravity
gradient and the constant disturbance act; drag, of some 1e-7 N m, is left to the check by the plant (check.py).
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.polynomial.chebyshev import Chebyshev

import controller.reference
import plant

from ..paper import Array
from .problem import DEGREE, HOLD, MARGIN, REST, UNLOADED
from .transcription import Task

SECONDS = 50.0
"""The unit of time: rates, momenta and T are of the order of one in it."""
SAMPLE, FIELD = 5.0, 1e-5
"""s between the samples of the field, and its unit, T."""


class Motion:
    """Of a satellite from its start until `longest`, s; tolerances of angle, rad, and rate, rad/s."""

    def __init__(self, p: plant.Parameters, longest: float, begin: float = 0.0) -> None:
        """`begin`: the plant's time at which the motion's own begins, s."""
        self.plant, self.longest, self.begin = p, longest, begin
        times = np.arange(0.0, longest + HOLD + SAMPLE, SAMPLE)
        field = np.array([self.lvlh(t).T @ p.field.at(begin + t) for t in times.tolist()]) / FIELD
        self._span = float(times[-1])
        self._series = [Chebyshev.fit(times, field[:, i], DEGREE, domain=[0.0, self._span]) for i in range(3)]
        self.field_error = FIELD * max(float(np.abs(c(times) - field[:, i]).max()) for i, c in enumerate(self._series))
        """Largest difference from the plant's field, T."""
        self.turn = np.array(controller.reference.lvlh(*p.orbit.position_velocity(begin)).Omega_d)

    def lvlh(self, t: float) -> Array:
        """R_d (3,3) at the motion's time t, s."""
        return controller.reference.lvlh(*self.plant.orbit.position_velocity(self.begin + t)).R_d

    def _field(self, t: ca.SX) -> ca.SX:
        """In LVLH (3,), T, by Chebyshev's recursion; t in s."""
        s = 2.0 * t / self._span - 1.0
        terms = [ca.SX(1.0), s]
        for _ in range(DEGREE - 1):
            terms.append(2.0 * s * terms[-1] - terms[-2])
        return FIELD * ca.vertcat(*(ca.dot(ca.vertcat(*terms), ca.DM(c.coef)) for c in self._series))

    def _rates(self, x: ca.SX, u: ca.SX, field: ca.SX) -> ca.SX:
        """dx/dt in SECONDS."""
        p, J = self.plant, ca.DM(self.plant.body.J)
        q, Omega, l_w = x[:4], x[4:7] / SECONDS, x[7] / SECONDS
        Q_T = matrix(q).T
        omega = Omega - Q_T @ self.turn
        dipole_B = ca.DM(p.rods_to_body * p.rod_gain) @ (p.dipole_max * u[:3]) + p.residual_dipole_B
        down = -Q_T[:, 2]
        gravity = 3.0 * float(self.turn @ self.turn) * ca.cross(down, J @ down)
        tau_w = p.wheel_torque_max * u[3]
        tau = ca.cross(dipole_B, Q_T @ field) + gravity + p.disturbance_torque_B
        tau -= tau_w * p.body.wheel_axis + ca.cross(Omega, J @ Omega + l_w * p.body.wheel_axis)
        dq = 0.5 * ca.vertcat(-ca.dot(q[1:], omega), q[0] * omega + ca.cross(q[1:], omega))
        return ca.vertcat(SECONDS * dq, SECONDS**2 * (ca.DM(p.body.J_inverse) @ tau), SECONDS**2 * tau_w)

    def step(self) -> ca.Function:
        """x, u, t and h to the x at t + h, both in SECONDS, by the classical Runge-Kutta method."""
        x, u, t, h = ca.SX.sym("x", 8), ca.SX.sym("u", 4), ca.SX.sym("t"), ca.SX.sym("h")
        first, middle, last = (self._field(SECONDS * (t + share * h)) for share in (0.0, 0.5, 1.0))
        a = self._rates(x, u, first)
        b = self._rates(x + 0.5 * h * a, u, middle)
        c = self._rates(x + 0.5 * h * b, u, middle)
        d = self._rates(x + h * c, u, last)
        return ca.Function("step", [x, u, t, h], [x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)])

    def task(self, angle: float, rate: float) -> Task:
        """To be within these tolerances, rad and rad/s, in the least time, and to stay there for HOLD."""
        x = ca.SX.sym("x", 8)
        q, omega = x[:4], x[4:7] / SECONDS - matrix(x[:4]).T @ self.turn
        slow = ca.sumsqr(omega) / (MARGIN * rate) ** 2
        near = ca.sumsqr(q[1:]) / math.sin(0.5 * MARGIN * angle) ** 2
        l_max = SECONDS * self.plant.wheel_momentum_max
        return Task(
            self.step(),
            ca.Function("within", [x], [ca.vertcat(near, slow)]),
            ca.Function("rest", [x], [ca.vertcat(slow / REST**2, (x[7] / (UNLOADED * l_max)) ** 2)]),
            np.array([np.inf] * 7 + [l_max]),
            HOLD / SECONDS,
            self.longest / SECONDS,
        )


def matrix(q: ca.SX) -> ca.SX:
    """The rotation (3,3) of a unit quaternion (4,), scalar first."""
    v = q[1:]
    return (q[0] ** 2 - ca.dot(v, v)) * ca.SX.eye(3) + 2.0 * v @ v.T + 2.0 * q[0] * ca.skew(v)
