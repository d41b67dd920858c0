"""What no controller can hold: a proof by the angular momentum along the field.

Rods give no torque along the field, however strong they are. With h = Q (J Omega + l a), the angular momentum in LVLH axes of a
satellite whose attitude to LVLH is Q, b the field's direction and c its rate of change in N,

    q = b.h,    dq/dt = b.(Q tau_d + M_gg) + c.h,

whatever rods and wheel do: the wheel only moves momentum between the body and its rotor, and its l is within l_max. Where the
error stays within an angle, and the rate within a limit, h and the torques are nearly known: with the rotation vector theta and
the rate nu of the body relative to LVLH, both in LVLH axes, and [theta, J] = theta^ J - J theta^,

    h    = J Omega_d + J nu + [theta, J] Omega_d + l a + l theta x a + rest,
    M_gg = 3 n^2 e3 x (J e3 + [theta, J] e3) + rest,    Q tau_d = tau_d + theta x tau_d + rest,    dtheta/dt = nu + rest.

Each rest has a bound. With the means of theta, nu, l and l theta over short intervals as variables (the last within McCormick's
envelope of the product), all this is a linear programme. Its least violation of the balance of q is torque along the field that
is missing: where it is not zero, no motion at all stays within these limits, and so no controller keeps the satellite there. The
motion need not end as it began, and may begin with any attitude, rate and wheel momentum within the limits. Drag is left out, as
it is in studies/hold.py, which has the other side: the best motion that was found.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog

import controller.reference
import plant

from .paper import Array

INTERVAL = 20.0
"""s, over which the means are taken, at most."""
E3 = np.array([0.0, 0.0, 1.0])
WIDTH = 10
"""Means over an interval: theta (3,), nu (3,), l, l theta (3,)."""


def hat(v: Array) -> Array:
    """The matrix (3,3) of v x."""
    return np.cross(v, np.eye(3)).T


def by_turn(J: Array, w: Array) -> Array:
    """The matrix (3,3) that takes theta to [theta, J] w."""
    return np.array([hat(e) @ J @ w - J @ hat(e) @ w for e in np.eye(3)]).T


@dataclass(frozen=True)
class Course:
    """Direction of the field and its rate of change in N, both in LVLH axes, at the ends and in the middle of n intervals (2n+1, 3)."""

    interval: float
    b: Array
    c: Array
    Omega_d: Array

    @classmethod
    def of(cls, p: plant.Parameters, begin: float, end: float) -> Course:
        """Along the plant's orbit between two of its times, s."""
        n = math.ceil((end - begin) / INTERVAL)
        h = 0.5 * (end - begin) / n
        lvlh = [controller.reference.lvlh(*p.orbit.position_velocity(begin + h * k)) for k in range(2 * n + 1)]
        to_N = np.array([frame.R_d for frame in lvlh])
        B = np.array([p.field.at(begin + h * k) for k in range(2 * n + 1)])
        b_N = B / np.linalg.norm(B, axis=1)[:, None]
        c_N = np.gradient(b_N, h, axis=0, edge_order=2)
        b, c = (np.einsum("kji,kj->ki", to_N, v) for v in (b_N, c_N))
        return cls(2.0 * h, b, c, np.array(lvlh[0].Omega_d))


def missing(p: plant.Parameters, begin: float, end: float, angle: float, rate: float) -> float:
    """Torque along the field, N m, without which no motion between these times, s, keeps within angle, rad, and rate, rad/s.

    Zero: nothing is proven.
    """
    return _missing(p, Course.of(p, begin, end), angle, rate)


def _missing(p: plant.Parameters, course: Course, angle: float, rate: float) -> float:
    J, a, tau = (np.asarray(x, float) for x in (p.body.J, p.body.wheel_axis, p.disturbance_torque_B))
    dt, b, c, Omega_d = course.interval, course.b, course.c, course.Omega_d
    l_max, n2 = p.wheel_momentum_max, float(Omega_d @ Omega_d)
    G0, h0 = tau + 3.0 * n2 * np.cross(E3, J @ E3), J @ Omega_d
    G_theta, h_theta = -hat(tau) + 3.0 * n2 * hat(E3) @ by_turn(J, E3), by_turn(J, Omega_d)
    # Bounds of what is left out: of h, of the torque, of dtheta/dt; and of what h and the torque vary by.
    uneven = float(np.abs(np.linalg.eigvalsh(J - np.trace(J) / 3.0 * np.eye(3))).max())
    second = 2.0 * angle**2 * math.exp(2.0 * angle) * uneven
    of_h = second * (math.sqrt(n2) + rate) + 2.0 * angle * uneven * rate + 0.5 * angle**2 * l_max
    of_torque = 0.5 * angle**2 * float(np.linalg.norm(tau)) + 3.0 * n2 * second
    of_theta = 0.5 * angle * (1.0 + angle) * rate
    h_varies = np.linalg.norm(J, 2) * rate + np.linalg.norm(h_theta, 2) * angle + l_max * (1.0 + angle) + of_h
    torque_varies = np.linalg.norm(G_theta, 2) * angle + of_torque
    turns, bends = (float(np.linalg.norm(np.gradient(v, 0.5 * dt, axis=0), axis=1).max()) for v in (b, c))
    steepest = float(np.linalg.norm(c, axis=1).max())
    known = b @ G0 + c @ h0
    gained = dt / 6.0 * (known[:-1:2] + 4.0 * known[1::2] + known[2::2])
    # Within an interval b and c are those of its middle, to a quarter of what they change by.
    of_balance = dt * (of_torque + steepest * of_h + 0.25 * dt * (turns * torque_varies + bends * h_varies))
    fastest = float(np.abs(known).max()) + torque_varies + steepest * h_varies
    of_mean = of_h + 0.25 * dt * (turns * h_varies + fastest)

    middle_b, middle_c = b[1::2], c[1::2]
    n = len(middle_b)
    rows = Rows(n, l_max, angle, rate, float(np.abs(b @ h0).max() + h_varies))
    rows.add(
        {rows.q(1): 1.0, rows.q(0): -1.0},
        -dt * _coefficients(middle_b @ G_theta + middle_c @ h_theta, middle_c, J, a),
        gained - of_balance,
        gained + of_balance,
        missing=dt,
    )
    rest = -(middle_b @ h0)
    rows.add(
        {rows.q(1): -0.5, rows.q(0): -0.5},
        _coefficients(middle_b @ h_theta, middle_b, J, a),
        rest - of_mean,
        rest + of_mean,
    )
    for i in range(3):
        theta, nu, product = np.eye(WIDTH)[[i, 3 + i, 7 + i]]
        wheel = np.eye(WIDTH)[6]
        rows.add({rows.theta(1, i): 1.0, rows.theta(0, i): -1.0}, -dt * nu, -dt * of_theta, dt * of_theta)
        room = 0.25 * dt * (rate + of_theta)
        rows.add({rows.theta(1, i): -0.5, rows.theta(0, i): -0.5}, theta, -room, room)
        for s, t in itertools.product((-1.0, 1.0), repeat=2):  # (l_max + s l) (angle + t theta) >= 0
            envelope = l_max * t * theta + s * angle * wheel + s * t * product
            rows.add({}, envelope, -l_max * angle, math.inf)
    return rows.least()


def _coefficients(of_theta: Array, along: Array, J: Array, a: Array) -> Array:
    """Of the means in along.h (n, WIDTH), with those of theta (n, 3) given."""
    return np.hstack((of_theta, along @ J, (along @ a)[:, None], np.cross(a, along)))


@dataclass
class Rows:
    """The linear programme: q and theta at the ends of the intervals, the means within them, and the missing torque."""

    n: int
    l_max: float
    angle: float
    rate: float
    q_max: float
    parts: list[sp.csr_matrix] = field(default_factory=list)
    lows: list[Array] = field(default_factory=list)
    highs: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        mean = [self.angle] * 3 + [self.rate] * 3 + [self.l_max] + [self.l_max * self.angle] * 3
        ends = self.n + 1
        self._limits = np.concatenate(
            (np.full(ends, self.q_max), np.full(3 * ends, self.angle), np.tile(mean, self.n), [self.q_max])
        )

    def q(self, end: int) -> Callable[[Array], Array]:
        """Columns of q at the beginning (0) or the end (1) of the intervals."""
        return lambda k: k + end

    def theta(self, end: int, i: int) -> Callable[[Array], Array]:
        """The same of an element of theta."""
        return lambda k: self.n + 1 + 3 * (k + end) + i

    def add(
        self,
        ends: dict[Callable[[Array], Array], float],
        means: Array,
        low: Array | float,
        high: Array | float,
        missing: float = 0.0,
    ) -> None:
        """A row for each interval: low <= ends + means (WIDTH,) or (n, WIDTH) <= high, to `missing` times the missing torque."""
        k, size = np.arange(self.n), len(self._limits)
        means = np.broadcast_to(means, (self.n, WIDTH))
        columns = [*(of(k) for of in ends), *(4 * (self.n + 1) + WIDTH * k + i for i in range(WIDTH))]
        values = [*(np.full(self.n, x) for x in ends.values()), *means.T]
        entries = np.concatenate(values), (np.tile(k, len(columns)), np.concatenate(columns))
        part = sp.csr_matrix(entries, shape=(self.n, size))
        last = sp.csr_matrix((np.full(self.n, missing), (k, np.full(self.n, size - 1))), shape=part.shape)
        for sign, limit in ((1.0, high), (-1.0, -np.asarray(low))):
            if np.all(np.isfinite(limit)):
                self.parts.append(sign * part - last)
                self.highs.append(np.broadcast_to(limit, self.n))

    def least(self) -> float:
        """The least missing torque, N m."""
        A = sp.vstack(self.parts) @ sp.diags(self._limits)
        size = abs(A).max(axis=1).toarray().ravel()
        bounds = np.column_stack((np.append(-np.ones(A.shape[1] - 1), 0.0), np.ones(A.shape[1])))
        cost = np.zeros(A.shape[1])
        cost[-1] = 1.0
        found = linprog(
            cost, sp.diags(1.0 / size) @ A, np.concatenate(self.highs) / size, bounds=bounds, method="highs"
        )
        return float(found.fun * self._limits[-1])
