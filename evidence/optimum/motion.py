"""The satellite's motion relative to LVLH as a step of CasADi (evidence/motion.py), under the field of an orbit, and
its task.

The field along the orbit is the plant's, as Chebyshev series of time. Gravity gradient and the constant disturbance
act; drag, of some 1e-7 N m, is left to the check by the plant (check.py).
Tests: tests/evidence/optimum/test_least_time.py.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.polynomial.chebyshev import Chebyshev

import controller.reference
import plant

from ..motion import SECONDS, advanced, matrix
from ..paper import Array
from .problem import DEGREE, HOLD, MARGIN, REST, UNLOADED
from .transcription import Task

SAMPLE, FIELD = 5.0, 1e-5
"""s between the samples of the field, and its unit, T."""


class Motion:
    """Motion of a satellite from its start until `longest`, s; tolerances of angle, rad, and rate, rad/s."""

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

    def step(self) -> ca.Function:
        """x, u, t and h to the x at t + h, both in SECONDS, by the classical Runge-Kutta method."""
        n = self.plant.wheels
        x, u, t, h = ca.SX.sym("x", 7 + n), ca.SX.sym("u", 3 + n), ca.SX.sym("t"), ca.SX.sym("h")
        fields = [self._field(SECONDS * (t + share * h)) for share in (0.0, 0.5, 1.0)]
        return ca.Function("step", [x, u, t, h], [advanced(self.plant, self.turn, x, u, h, fields)])

    def task(self, angle: float, rate: float) -> Task:
        """To be within these tolerances, rad and rad/s, in the least time, and to stay there for HOLD."""
        x = ca.SX.sym("x", 7 + self.plant.wheels)
        q, omega = x[:4], x[4:7] / SECONDS - matrix(x[:4]).T @ self.turn
        slow = ca.sumsqr(omega) / (MARGIN * rate) ** 2
        near = ca.sumsqr(q[1:]) / math.sin(0.5 * MARGIN * angle) ** 2
        l_max = SECONDS * np.array(self.plant.of_wheels(self.plant.wheel_momentum_max))
        return Task(
            self.step(),
            ca.Function("within", [x], [ca.vertcat(near, slow)]),
            ca.Function("rest", [x], [ca.vertcat(slow / REST**2, (x[7:] / (UNLOADED * l_max)) ** 2)]),
            np.concatenate(([np.inf] * 7, l_max)),
            HOLD / SECONDS,
            self.longest / SECONDS,
        )
