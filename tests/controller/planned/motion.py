"""The motion that the plan is made of: a rigid body, a wheel along e1, three rods, gravity gradient.

    dR/dt = R Omega^,  dh_w/dt = dl,
    J dOmega/dt = (J Omega + h_w e1) x Omega + m x R^T B + 3 mu/r^3 rho x J rho + d - dl e1,  rho = R^T r_hat,
    m = sum u_i m_i

The reference for `acceleration` of controller/planned/native/motion.c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
E1 = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Surroundings:
    """J (3, 3) kg m2, B_N (3,) T, r_hat_N (3,) unit, rate_squared mu/r^3 1/s2, d_B (3,) N m."""

    J: Array
    B_N: Array
    r_hat_N: Array
    rate_squared: float
    d_B: Array


def cross(a: Array, b: Array) -> Array:
    """a x b of (3,) and (3,): np.cross for stacks of vectors takes ten times as long, most of a flight of the truth."""
    (a1, a2, a3), (b1, b2, b3) = a.tolist(), b.tolist()
    return np.array((a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1))


def rate_of_change(s: Surroundings, R: Array, Omega: Array, h_w: float, m_B: Array, dl: float) -> Array:
    """dOmega/dt (3,), rad/s2, of R (3, 3) N from B, Omega (3,) rad/s, h_w N m s, dipole m_B (3,) A m2, motor dl N m."""
    gyroscopic = cross(s.J @ Omega + h_w * E1, Omega)
    magnetic = cross(m_B, R.T @ s.B_N)
    rho = R.T @ s.r_hat_N
    gravity = 3.0 * s.rate_squared * cross(rho, s.J @ rho)
    return np.asarray(np.linalg.solve(s.J, gyroscopic + magnetic + gravity + s.d_B - dl * E1), np.float64)
