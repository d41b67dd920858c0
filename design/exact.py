"""The closed loop under a torque that is given exactly, for many cases at once.

No block takes a torque, so the FMUs cannot fly this. The law [8] stands here for arrays of cases, and
tests/design/test_exact.py holds it to the controller's own functions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controller import Parameters, so3
from controller.gains import attitude_scale, rate_scale

Array = NDArray[Any]
ATTITUDE_TOLERANCE, RATE_TOLERANCE = math.radians(2.0), 1e-3
"""Settled: attitude error, rad, and rate error, rad/s, below these from then to the end."""


class Law:
    """The law [8] with the gains [10], holding LVLH on a circular orbit of rate n, for many cases; remembers their
    start."""

    def __init__(self, p: Parameters, n: float) -> None:
        """Raises ValueError for a bend of the attitude's error function, which is not written here."""
        if p.phi != "linear":
            raise ValueError(f"phi: expected 'linear', found {p.phi!r}: the law for many cases has no other")
        self.p, self.n = p, n
        self.start: tuple[Any, Any] | None = None

    def __call__(self, Q: Array, Omega: Array) -> Demand:
        """Q (cases, 3, 3), Omega (cases, 3) rad/s."""
        p = self.p
        W = -self.n * Q[:, 1]  # Q^T Omega_d with Omega_d = (0, -n, 0)
        omega = Omega - W
        zeta: Any = _angle(Q)
        rate: Any = np.linalg.norm(omega, axis=1)
        if self.start is None:
            self.start = zeta, rate
        k: Any = np.full(len(Q), p.kappa0)
        l: Any = np.full(len(Q), p.lambda0)  # noqa: E741
        if p.gain_schedule == "error":  # the controller's own formulas serve arrays as well as floats
            k = attitude_scale(p.kappa0, p.a1, p.a2, zeta, self.start[0])
            l = rate_scale(p.lambda0, p.c1, p.c2, rate, self.start[1])  # noqa: E741
        K = k[:, None] * p.K0
        x = (K * (1.0 - np.diagonal(Q, axis1=1, axis2=2))).sum(axis=1)
        attitude = np.cross(np.eye(3), Q * K[:, :, None]).sum(axis=1)  # sum k_i e_i x Q^T e_i
        damping = -l[:, None] * (omega @ p.L0.T)
        gravity = -gravity_gradient(p.J_B, Q, self.n) if p.compensate_gravity else 0.0
        tau = damping + np.cross(W, W @ p.J_B) + attitude + gravity
        V = 0.5 * (omega * (omega @ p.J_B)).sum(axis=1) + x
        return Demand(zeta, rate, tau, V, (omega * damping).sum(axis=1))


@dataclass
class Demand:
    """Demands of the law in the states of many cases."""

    zeta: Array
    """|zeta|, rad."""
    rate: Array
    """|omega|, rad/s."""
    tau: Array
    V: Array
    dV: Array
    """-omega.L omega, W: dV/dt with constant gains and exact torque."""


def gravity_gradient(J: Array, Q: Array, n: float) -> Array:
    """3 n^2 r x J r (cases, 3), N m, r = -Q^T e3 the unit position in body axes; J (3, 3) or (cases, 3, 3)."""
    r = -Q[:, 2]
    return 3.0 * n * n * np.cross(r, _times(J, r))


def _times(M: Array, x: Array) -> Array:
    """M x of each case."""
    return np.asarray((M @ x[:, :, None])[:, :, 0])


def _angle(Q: Array) -> Array:
    """Principal angle of each Q, from sine and cosine together."""
    sine = 0.5 * np.sqrt(
        (Q[:, 2, 1] - Q[:, 1, 2]) ** 2 + (Q[:, 0, 2] - Q[:, 2, 0]) ** 2 + (Q[:, 1, 0] - Q[:, 0, 1]) ** 2
    )
    return np.arctan2(sine, 0.5 * (np.trace(Q, axis1=1, axis2=2) - 1.0))


@dataclass(frozen=True)
class Flown:
    """Each (n,), of n cases."""

    initial_angle: Array
    converged: Array
    """When the errors are below 2 deg and 1e-3 rad/s for good, s; NaN where they are not at the end."""
    largest_torque: Array
    """Largest |tau| demanded, N m."""
    steps_up: Array
    """Samples at which V rose."""
    largest_rise: Array
    """Largest rise of V above its least value so far, over V(0)."""
    rate_error: float
    """Largest |dV/dt + omega.L omega|, W, over the largest omega.L omega, for constant gains; central differences."""


def fly(p: Parameters, J: Array, Q: Array, Omega: Array, duration: float, step: float, n: float) -> Flown:
    """The closed loop of each case with exact torque on a circular orbit, by RK4 on [1] and [2].

    J (3, 3) or (cases, 3, 3), kg m2, is the body's inertia; the law has its own. The gravity gradient acts. In LVLH the
    loop is autonomous: dQ/dt = Q Omega^ - Omega_d^ Q.
    """
    law = Law(p, n)
    J_inverse = np.linalg.inv(J)
    turn = so3.hat(np.array((0.0, -law.n, 0.0)))

    def slope(Q: Array, Omega: Array, tau: Array) -> tuple[Array, Array]:
        moment = tau + gravity_gradient(J, Q, law.n)
        # Rows of Q Omega^ are those of Q crossed with Omega.
        dQ = np.cross(Q, Omega[:, None, :]) - turn @ Q
        return dQ, _times(J_inverse, moment - np.cross(Omega, _times(J, Omega)))

    count = math.ceil(duration / step)
    first = law(Q, Omega)
    least, before = first.V, first.V
    up, rise = np.zeros(len(Q)), np.zeros(len(Q))
    converged, outside = np.full(len(Q), np.nan), np.ones(len(Q), bool)
    defect, largest = 0.0, 0.0
    torque = np.zeros(len(Q))
    earlier: list[tuple[Array, Array]] = []
    for i in range(count + 1):
        d = law(Q, Omega)
        now = (d.zeta >= ATTITUDE_TOLERANCE) | (d.rate >= RATE_TOLERANCE)
        converged = np.where(now, np.nan, np.where(outside, i * step, converged))
        outside = now
        torque = np.maximum(torque, np.linalg.norm(d.tau, axis=1))
        if i:
            up += before + 1e-12 * first.V < d.V
            rise = np.maximum(rise, (d.V - least) / first.V)
            least = np.minimum(least, d.V)
        before = d.V
        earlier = [*earlier[-4:], (d.V, d.dV)]
        if len(earlier) == 5 and i % 5 == 0:  # central difference of order 4 at the middle one
            V = [e[0] for e in earlier]
            slope_of_V = (V[0] - 8.0 * V[1] + 8.0 * V[3] - V[4]) / (12.0 * step)
            defect = max(defect, float(np.abs(slope_of_V - earlier[2][1]).max()))
            largest = max(largest, float(np.abs(earlier[2][1]).max()))
        if i == count:
            break
        k1 = slope(Q, Omega, d.tau)
        at = Q + 0.5 * step * k1[0], Omega + 0.5 * step * k1[1]
        k2 = slope(*at, law(*at).tau)
        at = Q + 0.5 * step * k2[0], Omega + 0.5 * step * k2[1]
        k3 = slope(*at, law(*at).tau)
        at = Q + step * k3[0], Omega + step * k3[1]
        k4 = slope(*at, law(*at).tau)
        Q = Q + step / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0])
        Omega = Omega + step / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1])
    return Flown(
        initial_angle=first.zeta,
        converged=converged,
        largest_torque=torque,
        steps_up=up,
        largest_rise=np.maximum(rise, 0.0),
        rate_error=defect / largest if largest else 0.0,
    )
