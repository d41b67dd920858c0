"""Gravity-gradient moment M_g of a point-mass Earth [2]."""

from __future__ import annotations

import numpy as np

from .so3 import Array


def moment(r_hat_B: Array, J: Array, rate_squared: float) -> Array:
    """M_g = 3 (mu/r^3) r_hat x J r_hat, (3,) N m in body axes.

    r_hat_B (3,) the unit position in body axes, J (3,3) kg m2, rate_squared = mu/r^3, 1/s2.
    It equals the potential's form sum r_i x v_ri with r_i, v_ri the rows of R and of dU/dR.
    """
    x, y, z = r_hat_B.tolist()
    a, b, c = ((3.0 * rate_squared) * J.dot(r_hat_B)).tolist()
    return np.array((y * c - z * b, z * a - x * c, x * b - y * a))


def potential(r_hat_B: Array, J: Array, rate_squared: float) -> float:
    """U = (mu/r^3)(3/2 r_hat.J r_hat - 1/2 tr J), J: the attitude-dependent part of the potential energy."""
    (J11, _, _), (_, J22, _), (_, _, J33) = J.tolist()
    return rate_squared * (1.5 * float(r_hat_B.dot(J.dot(r_hat_B))) - 0.5 * (J11 + J22 + J33))
