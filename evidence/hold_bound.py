"""What no controller can hold: a proof by the angular momentum along the field.

Rods give no torque along the field, however strong they are. With h = Q (J Omega + l a), the angular momentum in LVLH
axes of a satellite whose attitude to LVLH is Q, b the field's direction and c its rate of change in N,

    q = b.h,    dq/dt = b.(Q tau_d + M_gg + M_drag) + c.h,

whatever rods and wheel do: the wheel only moves momentum between the body and its rotor, and its l is within l_max.
Where the error stays within an angle, and the rate within a limit, h and the torques are nearly known: with the
rotation vector theta and the rate nu of the body relative to LVLH, both in LVLH axes, and [theta, J] = theta^ J - J
theta^,

    h    = J Omega_d + J nu + [theta, J] Omega_d + l a + l theta x a + rest,
    M_gg = 3 n^2 e3 x (J e3 + [theta, J] e3) + rest,
    Q tau_d = tau_d + theta x tau_d + rest,    dtheta/dt = nu + rest,

and of drag, with the velocity v relative to the air, its density, and the matrix S of the plates that face the flow
(hold_course.py),

    M_drag = density v x (S v + [theta, S] v) + rest.

Each rest has a bound. With the means of theta, nu, l and l theta over short intervals as variables (the last within
McCormick's envelope of the product), all this is a linear programme. Its least violation of the balance of q is
torque along the field that is missing: where it is not zero, no motion at all stays within these limits, and so no
controller keeps the satellite there. What is returned is the value of the dual solution, which is a proof by itself,
to rounding and to differences over 10 s. The motion need not end as it began, and may begin with any attitude, rate
and wheel momentum within the limits. Orbits are circular. Decision 25 has the other side: the motion of the least
largest error that was found.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog

import plant
from controller.so3 import hat
from orchestration import InputError

from .hold_course import Course, by_turn, second, uneven
from .hold_course import drag as of_air
from .paper import Array

E3 = np.array([0.0, 0.0, 1.0])
ENDS, MEANS = 4, 10
"""Variables at an end of an interval, q and theta (3,); and means over it, theta (3,), nu (3,), l, l theta (3,)."""
ONE = np.eye(2 * ENDS + MEANS + 1)
"""A row's coefficients: at the beginning, of the means, at the end, of the missing torque."""
Q, Q_NEXT, THETA, THETA_NEXT = ONE[0], ONE[ENDS + MEANS], ONE[1:4], ONE[ENDS + MEANS + 1 : 2 * ENDS + MEANS]
OF_THETA, OF_NU, OF_L, OF_PRODUCT = np.split(ONE[ENDS : ENDS + MEANS], [3, 6, 7])
MISSING = ONE[-1]


def missing(p: plant.Parameters, begin: float, end: float, angle: float, rate: float) -> float:
    """Torque along the field, N m, without which no motion between these times, s, keeps within angle, rad, and rate,
    rad/s.

    Zero: nothing is proven. Raises InputError for an orbit that is not circular.
    """
    return programme(p, Course.of(p, begin, end), angle, rate).least()


def programme(p: plant.Parameters, course: Course, angle: float, rate: float) -> Programme:
    """The linear programme of the balance along the field."""
    J, a, tau = (np.asarray(x, float) for x in (p.body.J, p.wheel_axes[0], p.disturbance_torque_B))
    dt, b, c, Omega_d = course.interval, course.b, course.c, course.Omega_d
    l_max, n2 = p.wheel_momentum_max, float(Omega_d @ Omega_d)
    G0, h0 = tau + 3.0 * n2 * np.cross(E3, J @ E3), J @ Omega_d
    G_theta, h_theta = -hat(tau) + 3.0 * n2 * hat(E3) @ by_turn(J, E3), by_turn(J, Omega_d)
    drag, drag_theta, of_drag = of_air(p, course, angle)
    # Bounds of what is left out: of h, of the torque, of dtheta/dt; and of what h and the torque vary by.
    turned = second(angle) * uneven(J)
    of_h = turned * (math.sqrt(n2) + rate) + 2.0 * angle * uneven(J) * rate + 0.5 * angle**2 * l_max
    of_torque = 0.5 * angle**2 * float(np.linalg.norm(tau)) + 3.0 * n2 * turned + of_drag
    of_theta = 0.5 * angle * (1.0 + angle) * rate
    h_varies = np.linalg.norm(J, 2) * rate + np.linalg.norm(h_theta, 2) * angle + l_max * (1.0 + angle) + of_h
    torque_varies = (np.linalg.norm(G_theta, 2) + _largest(drag_theta)) * angle + of_torque
    turns, bends, shifts = (_largest(np.gradient(x, 0.5 * dt, axis=0)) for x in (b, c, drag_theta))
    steepest, known = _largest(c), b @ G0 + np.einsum("ki,ki->k", b, drag) + c @ h0
    # Within an interval b, c and the change of drag are those of its middle, to a quarter of what they change by.
    of_change = turns * torque_varies + bends * h_varies + shifts * angle
    of_balance = dt * (of_torque + steepest * of_h + 0.25 * dt * of_change)
    fastest = float(np.abs(known).max()) + torque_varies + steepest * h_varies
    of_mean = of_h + 0.25 * dt * (turns * h_varies + fastest)

    b, c = b[1::2], c[1::2]
    G = G_theta + drag_theta[1::2]
    ends = [float(np.abs(course.b @ h0).max() + h_varies), *[angle] * 3]
    means = [*[angle] * 3, *[rate] * 3, l_max, *[l_max * angle] * 3]
    found = Programme(len(b), np.array(ends), np.array(means), float(np.linalg.norm(tau)))
    # The balance of q, and what q is in the mean; the missing torque may also let q vary more within an interval.
    gained = dt * course.mean(known)
    balance = Q_NEXT - Q - dt * _of_h(np.einsum("ki,kij->kj", b, G) + c @ h_theta, c, J, a)
    found.add(balance, gained - of_balance, gained + of_balance, missing=dt)
    rest = -course.mean(course.b @ h0)
    found.add(_of_h(b @ h_theta, b, J, a) - 0.5 * (Q + Q_NEXT), rest - of_mean, rest + of_mean, missing=0.25 * dt)
    room = 0.25 * dt * (rate + of_theta)
    for now, then, theta, nu, product in zip(THETA, THETA_NEXT, OF_THETA, OF_NU, OF_PRODUCT, strict=True):
        found.add(then - now - dt * nu, -dt * of_theta, dt * of_theta)
        found.add(theta - 0.5 * (now + then), -room, room)
        for s, t in itertools.product((-1.0, 1.0), repeat=2):  # (l_max + s l) (angle + t theta) >= 0
            found.add(l_max * t * theta + s * angle * OF_L[0] + s * t * product, -l_max * angle)
    return found


def _largest(values: Array) -> float:
    """Of the vectors or matrices along the first axis, the largest 2-norm; of a matrix the Frobenius norm, which is
    no smaller."""
    return float(np.linalg.norm(values.reshape(len(values), -1), axis=1).max())


def _of_h(of_theta: Array, along: Array, J: Array, a: Array) -> Array:
    """A row's coefficients (n, len(ONE)) of along.h, with those of theta (n, 3) given."""
    return of_theta @ OF_THETA + (along @ J) @ OF_NU + (along @ a)[:, None] @ OF_L + np.cross(a, along) @ OF_PRODUCT


class Programme:
    """Rows A x <= high on |x| <= 1: q and theta at the ends of n intervals, the means within them, and the missing
    torque, |x| >= 0."""

    def __init__(self, n: int, ends: Array, means: Array, torque: float) -> None:
        self.n, self.torque = n, torque
        self.limits = np.concatenate((np.tile([*ends, *means], n), ends, [torque]))
        self._parts: list[sp.csr_matrix] = []
        self._highs: list[Array] = []

    def add(self, row: Array, low: Array | float, high: Array | float = math.inf, missing: float = 0.0) -> None:
        """In each interval low <= row (len(ONE),) or (n, len(ONE)) <= high, to `missing` times the missing torque."""
        k = np.arange(self.n)[:, None]
        columns = np.hstack(((ENDS + MEANS) * k + np.arange(len(ONE) - 1), np.full_like(k, len(self.limits) - 1)))
        rows = np.broadcast_to(k, columns.shape)
        for sign, limit in ((1.0, np.asarray(high)), (-1.0, -np.asarray(low))):
            if np.isfinite(limit).all():
                values = np.broadcast_to(sign * row - missing * MISSING, columns.shape)
                entries = values.ravel(), (rows.ravel(), columns.ravel())
                self._parts.append(sp.csr_matrix(entries, shape=(self.n, len(self.limits))))
                self._highs.append(np.broadcast_to(limit, self.n))

    def excess(self, x: Array) -> Array:
        """By how much these values of the variables, in their units, exceed each row (rows,)."""
        return np.asarray(sp.vstack(self._parts) @ x - np.concatenate(self._highs))

    def least(self) -> float:
        """A lower bound of the missing torque, N m: the value of the dual solution.

        Raises InputError where none is found.
        """
        A = sp.vstack(self._parts) @ sp.diags(self.limits)
        size = sp.diags(1.0 / abs(A[:, :-1]).max(axis=1).toarray().ravel())
        A, high = (size @ A).tocsr(), size @ np.concatenate(self._highs)
        cost = np.zeros(A.shape[1])
        cost[-1] = 1.0
        bounds = np.column_stack((cost - 1.0, 1.0 + np.where(cost, np.inf, 0.0)))
        found = linprog(cost, A, high, bounds=bounds, method="highs")
        if found.status != 0:
            raise InputError(f"the bound of a hold was not found: {found.message}")
        weights = np.minimum(found.ineqlin.marginals, 0.0)
        weights /= max(1.0, float((A.T @ weights)[-1]))
        return self.torque * max(float(weights @ high - np.abs(A.T @ weights)[:-1].sum()), 0.0)
