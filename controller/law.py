"""The tracking law [8] and its Lyapunov function [11].

Requirement: CT-1.
"""

from __future__ import annotations

import numpy as np

from .errors import Errors
from .morse import slope_direction
from .reference import R_MIN
from .so3 import Array, cross, norm

NO_MOMENT = np.zeros(3)
NO_MOMENT.flags.writeable = False


def gravity_gradient(mu: float, J: Array, R_NB: Array, r_N: Array) -> Array:
    """M_g = 3 mu/r^3 r_B x J r_B (3,), N m, r_B the unit position in body axes: [2]'s potential for a point-mass Earth.

    mu m3/s2, J (3,3) kg m2, r_N (3,) m. Raises ValueError at the Earth's centre.
    """
    r = norm(r_N)
    if r < R_MIN:
        raise ValueError(f"r_N: expected a position at least {R_MIN:g} m from the Earth's centre, found {r_N.tolist()}")
    r_B = r_N.dot(R_NB) * (1.0 / r)
    return (3.0 * mu / (r * r * r)) * cross(r_B, J.dot(r_B))


def torque(J: Array, K: Array, L: Array, phi_slope: float, errors: Errors, M_g: Array) -> Array:
    """Control torque tau (3,), N m [8].

    tau = -L omega + J Q^T dOmega_d/dt + (Q^T Omega_d)^ J (Q^T Omega_d) + Phi' sum k_i e_i x Q^T e_i - M_g - M_ad

    J (3,3) kg m2, K (3,) N m, L (3,3) N m s, phi_slope Phi'(tr(K - K Q)), M_g (3,) N m at R_d Q = R.
    The law knows no drag: M_ad = 0.
    """
    damping = -L.dot(errors.omega)
    acceleration = J.dot(errors.dOmega_d_B)
    gyroscopic = cross(errors.Omega_d_B, J.dot(errors.Omega_d_B))
    attitude = phi_slope * slope_direction(K, errors.Q)
    gravity = -M_g
    return damping + acceleration + gyroscopic + attitude + gravity


def lyapunov(J: Array, phi_value: float, omega: Array) -> float:
    """V = 1/2 omega.J omega + Phi(tr(K - K Q)) [11], J.

    With constant gains and exact torque dV/dt = -omega.L omega; gains that follow the errors may let V rise.
    """
    return 0.5 * float(omega.dot(J.dot(omega))) + phi_value
