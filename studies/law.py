"""The law [8] with the gains [10], holding LVLH on a circular orbit, for many cases at once; components first.

It is controller/law.py for arrays, and tests/studies/test_loops.py holds it to that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import controller

from .vectors import Array, angle, cross, dot, norm, times


@dataclass
class Demand:
    """What the law makes of a state."""

    zeta: Array
    """|zeta|, rad."""
    omega: Array
    tau: Array
    V: Array
    dV: Array
    """-omega.L omega, W: dV/dt with constant gains and exact torque."""


class Law:
    """Controllers of many cases; remembers |zeta(0)| and |omega(0)| of the first demand."""

    def __init__(self, laws: Sequence[controller.Parameters]) -> None:
        self.J = stack([p.J_B for p in laws])
        self.K0 = stack([p.K0 for p in laws])
        self.L0 = stack([p.L0 for p in laws])
        self.constant = np.array([p.gain_schedule == "constant" for p in laws])
        self.schedule = {
            name: np.array([getattr(p, name) for p in laws]) for name in ("kappa0", "lambda0", "a1", "a2", "c1", "c2")
        }
        self.compensate = np.array([1.0 if p.compensate_gravity else 0.0 for p in laws])
        self.phi = np.array([p.phi for p in laws])
        self.phi_scale = np.array([p.phi_scale for p in laws])
        self.start: tuple[Array, Array] | None = None

    def __call__(self, Q: Array, Omega: Array, n: Array | float) -> Demand:
        """Q (3, 3, cases), Omega (3, cases) rad/s, orbital rate n rad/s."""
        W = Q[1] * -n
        omega = Omega - W
        zeta, rate = angle(Q), norm(omega)
        if self.start is None:
            self.start = zeta, rate
        zeta_0, rate_0 = self.start
        s = self.schedule
        k = np.where(self.constant, s["kappa0"], s["kappa0"] * (s["a1"] + zeta) / (s["a2"] + zeta_0))
        l = np.where(self.constant, s["lambda0"], s["lambda0"] * (s["c1"] + rate) / (s["c2"] + rate_0))  # noqa: E741
        K = k * self.K0
        x = np.maximum(K[0] * (1.0 - Q[0, 0]) + K[1] * (1.0 - Q[1, 1]) + K[2] * (1.0 - Q[2, 2]), 0.0)
        value, slope = self._phi(x)
        direction = np.array(
            (
                K[1] * Q[1, 2] - K[2] * Q[2, 1],
                K[2] * Q[2, 0] - K[0] * Q[0, 2],
                K[0] * Q[0, 1] - K[1] * Q[1, 0],
            )
        )
        M_g = (3.0 * n * n) * cross(Q[2], times(self.J, Q[2]))
        damping = -l * times(self.L0, omega)
        tau = damping + cross(W, times(self.J, W)) + slope * direction - self.compensate * M_g
        return Demand(zeta, omega, tau, 0.5 * dot(omega, times(self.J, omega)) + value, dot(omega, damping))

    def _phi(self, x: Array) -> tuple[Array, Array]:
        s = self.phi_scale
        logarithm, root = self.phi == "logarithm", self.phi == "square_root"
        if not (logarithm.any() or root.any()):
            return x, np.ones_like(x)
        r = np.sqrt(1.0 + x / s)
        value = np.where(logarithm, s * np.log1p(x / s), np.where(root, 2.0 * x / (r + 1.0), x))
        return value, np.where(logarithm, 1.0 / (1.0 + x / s), np.where(root, 1.0 / r, 1.0))


def stack(arrays: Sequence[Array]) -> Array:
    """Arrays of single cases with the cases as last axis."""
    return np.moveaxis(np.array(arrays), 0, -1).copy()
