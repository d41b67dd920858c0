"""Desired motions: attitude R_d (N from desired body), rate Omega_d and its derivative in desired body axes [3].

dR_d/dt = R_d Omega_d^ holds for each of them.
"""

from __future__ import annotations

import math
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
    (r1, r2, r3), (v1, v2, v3) = r_N.tolist(), v_N.tolist()
    h1, h2, h3 = r2 * v3 - r3 * v2, r3 * v1 - r1 * v3, r1 * v2 - r2 * v1
    r, v, h = math.hypot(r1, r2, r3), math.hypot(v1, v2, v3), math.hypot(h1, h2, h3)
    if r < R_MIN or not h > _COLLINEAR * r * v:
        raise ValueError(
            f"r_N, v_N: reference 'lvlh' expects a position and a velocity that span the orbit's plane, "
            f"found r_N = {r_N.tolist()}, v_N = {v_N.tolist()}"
        )
    z1, z2, z3 = -r1 / r, -r2 / r, -r3 / r
    y1, y2, y3 = -h1 / h, -h2 / h, -h3 / h
    x1, x2, x3 = y2 * z3 - y3 * z2, y3 * z1 - y1 * z3, y1 * z2 - y2 * z1
    n = h / (r * r)
    dn = -2.0 * n * (r1 * v1 + r2 * v2 + r3 * v3) / (r * r)
    return Reference(
        R_d=np.array(((x1, y1, z1), (x2, y2, z2), (x3, y3, z3))),
        Omega_d=np.array((0.0, -n, 0.0)),
        dOmega_d=np.array((0.0, -dn, 0.0)),
    )


def relative(frame: Reference, R_d0: Array) -> Reference:
    """Hold of the attitude R_d0 (3,3) relative to a frame that moves: frame from desired body."""
    return Reference(frame.R_d @ R_d0, frame.Omega_d @ R_d0, frame.dOmega_d @ R_d0)


def inertial(R_d0: Array) -> Reference:
    """Hold of the attitude R_d0 in N."""
    return Reference(R_d0, _ZERO, _ZERO)


def rate(R_d0: Array, Omega_d0: Array, t: float) -> Reference:
    """From R_d0 at t = 0 with the constant body rate Omega_d0: R_d = R_d0 exp(t Omega_d0^)."""
    return Reference(R_d0 @ so3.exp(t * Omega_d0), Omega_d0, _ZERO)
