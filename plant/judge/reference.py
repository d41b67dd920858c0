"""Desired motions: attitude R_d (N from desired body) and rate Omega_d in desired body axes, dR_d/dt = R_d Omega_d^ [3]."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

R_MIN = 1.0
"""m. A position nearer to the Earth's centre has no direction worth using."""
COLLINEAR = 1e-9
"""|r x v| below this share of |r||v| leaves the orbit's plane undefined."""


class Reference(NamedTuple):
    """R_d (3,3), Omega_d (3,) rad/s."""

    R_d: Array
    Omega_d: Array


def lvlh(r_N: Array, v_N: Array) -> Reference:
    """The local frame L: Z to nadir, Y = -orbit normal, X = Y x Z (along v on a circular orbit).

    r_N (3,) m, v_N (3,) m/s; any orbit about the Earth's centre: Omega_d = (0, -|r x v|/r^2, 0).
    Raises ValueError where r and v span no plane.
    """
    r, v = math.hypot(*r_N.tolist()), math.hypot(*v_N.tolist())
    h_N = np.cross(r_N, v_N)
    h = math.hypot(*h_N.tolist())
    if r < R_MIN or not h > COLLINEAR * r * v:
        raise ValueError(
            f"r_N, v_N: reference 'lvlh' expects a position and a velocity that span the orbit's plane, "
            f"found r_N = {r_N.tolist()}, v_N = {v_N.tolist()}"
        )
    z, y = -r_N / r, -h_N / h
    return Reference(np.column_stack((np.cross(y, z), y, z)), np.array((0.0, -h / (r * r), 0.0)))


def exp(x: Array) -> Array:
    """exp(x^) (3,3), the turn by |x| about x (3,): Rodrigues' formula with sin(a)/a and (1 - cos a)/a^2."""
    a, b, c = x.tolist()
    half = 0.5 * math.hypot(a, b, c)
    sinc = math.sin(half) / half if half > 0.0 else 1.0
    skew = np.array(((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0)))
    return np.eye(3) + sinc * math.cos(half) * skew + 0.5 * sinc * sinc * (skew @ skew)


def project(M: Array) -> Array:
    """The rotation nearest to M (3,3) in the Frobenius norm: U diag(1, 1, det U V^T) V^T of M = U S V^T."""
    U, _, Vt = np.linalg.svd(M)
    return U @ np.diag((1.0, 1.0, np.linalg.det(U @ Vt))) @ Vt
