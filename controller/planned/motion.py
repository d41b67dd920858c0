"""The motion that the plan is made of: a rigid body, a wheel along e1, three rods, gravity gradient.

    dR/dt = R Omega^,  dl/dt = dl,
    J dOmega/dt = (J Omega + l e1) x Omega + m x R^T B + 3 mu/r^3 rho x J rho + d - dl e1,  rho = R^T r_hat,  m = sum u_i m_i

The reference for `acceleration` of native/plan.c, and for the row of native/identification.c.
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


def rate_of_change(s: Surroundings, R: Array, Omega: Array, l: float, m_B: Array, dl: float) -> Array:
    """dOmega/dt (3,), rad/s2, of R (3, 3) N from B, Omega (3,) rad/s, l N m s, dipole m_B (3,) A m2, motor dl N m."""
    gyroscopic = np.cross(s.J @ Omega + l * E1, Omega)
    magnetic = np.cross(m_B, R.T @ s.B_N)
    rho = R.T @ s.r_hat_N
    gravity = 3.0 * s.rate_squared * np.cross(rho, s.J @ rho)
    return np.linalg.solve(s.J, gyroscopic + magnetic + gravity + s.d_B - dl * E1)


def momentum_row(Omega: Array, times: Array, impulse_rods: Array) -> tuple[Array, Array]:
    """Rows (3, 4) for (J1, J2, J3, rod gain) of a window, and the integral of Omega x e1 (3,) for l = 1.

    Omega (n, 3) at times (n,), impulse_rods (3,) N m s: the integral of the rods' torque at gain 1. With J diagonal,
    rows @ p = known impulses - dl e1 - integral of Omega x l e1, the balance of momentum in body axes.
    """
    change = Omega[-1] - Omega[0]
    turning = [np.cross(Omega, E * Omega) for E in np.eye(3)]  # Omega x J Omega is linear in J
    rows = np.array([change * E + np.trapezoid(w, times, axis=0) for E, w in zip(np.eye(3), turning, strict=True)])
    return np.vstack((rows, -impulse_rods)).T, np.trapezoid(np.cross(Omega, E1), times, axis=0)
