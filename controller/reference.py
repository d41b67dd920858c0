"""Desired motions: attitude R_d (N from desired body), rate Omega_d and its derivative in desired body axes [3].

dR_d/dt = R_d Omega_d^ holds for each of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import so3
from .so3 import Array

_ZERO = np.zeros(3)
_ZERO.flags.writeable = False
R_MIN = 1.0
"""m. A position nearer to the Earth's centre has no direction worth using."""
_COLLINEAR = 1e-9
"""|r x v| below this share of |r||v| leaves the orbit's plane undefined."""


class Reference(NamedTuple):
    """R_d (3,3), Omega_d (3,) rad/s, dOmega_d (3,) rad/s2."""

    R_d: Array
    Omega_d: Array
    dOmega_d: Array


def lvlh(r_N: Array, v_N: Array) -> Reference:
    """Hold of the local frame L: Z to nadir, Y = -orbit normal, X = Y x Z (along v on a circular orbit).

    r_N (3,) m, v_N (3,) m/s; any orbit about the Earth's centre, not only a circle:
    n = |r x v|/r^2, Omega_d = (0, -n, 0), and since |r x v| is constant dn/dt = -2 n (r.v)/r^2.
    Raises ValueError where r and v span no plane.
    """
    r = so3.norm(r_N)
    h_N = so3.cross(r_N, v_N)
    h = so3.norm(h_N)
    if r < R_MIN or not h > _COLLINEAR * r * so3.norm(v_N):
        raise ValueError(
            f"r_N, v_N: reference 'lvlh' expects a position and a velocity that span the orbit's plane, "
            f"found r_N = {r_N.tolist()}, v_N = {v_N.tolist()}"
        )
    z_N = r_N * (-1.0 / r)
    y_N = h_N * (-1.0 / h)
    x_N = so3.cross(y_N, z_N)
    n = h / (r * r)
    dn = -2.0 * n * float(r_N.dot(v_N)) / (r * r)
    return Reference(
        R_d=np.array((x_N, y_N, z_N)).T,
        Omega_d=np.array((0.0, -n, 0.0)),
        dOmega_d=np.array((0.0, -dn, 0.0)),
    )


def inertial(R_d0: Array) -> Reference:
    """Hold of the attitude R_d0 in N."""
    return Reference(R_d0, _ZERO, _ZERO)


def rate(R_d0: Array, Omega_d0: Array, t: float) -> Reference:
    """From R_d0 at t = 0 with the constant body rate Omega_d0: R_d = R_d0 exp(t Omega_d0^)."""
    return Reference(R_d0 @ so3.exp(t * Omega_d0), Omega_d0, _ZERO)
