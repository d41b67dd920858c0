"""Desired motions: attitude R_d (N from desired body) and rate Omega_d in desired body axes, dR_d/dt =
R_d Omega_d^ [3]. Tests: tests/plant/judge/test_judge.py."""

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


def norm(x: Array) -> float:
    """|x| of x (3,)."""
    return math.hypot(*x.tolist())


def hat(x: Array) -> Array:
    """x^ (3,3), the skew matrix with x^ y = x cross y."""
    x1, x2, x3 = x.tolist()
    return np.array(((0.0, -x3, x2), (x3, 0.0, -x1), (-x2, x1, 0.0)))


def exp(x: Array) -> Array:
    """exp(x^) (3,3), the turn by |x| about x (Rodrigues), with nothing that cancels at a small angle."""
    half = 0.5 * norm(x)
    sinc = math.sin(half) / half if half > 0.0 else 1.0
    skew = hat(x)
    return np.eye(3) + sinc * math.cos(half) * skew + 0.5 * sinc * sinc * (skew @ skew)


def project(M: Array) -> Array:
    """The rotation nearest to M (3,3) in the Frobenius norm: U diag(1, 1, det U V^T) V^T of M = U S V^T."""
    U, _, Vt = np.linalg.svd(M)
    return U @ np.diag((1.0, 1.0, np.linalg.det(U @ Vt))) @ Vt


def require_rotation(name: str, R: Array, tolerance: float) -> None:
    """Raises ValueError unless R (3,3) is orthonormal to `tolerance`, element by element of R^T R, and right-handed."""
    (a1, b1, c1), (a2, b2, c2), (a3, b3, c3) = R.tolist()
    errors = (
        a1 * a1 + a2 * a2 + a3 * a3 - 1.0,
        b1 * b1 + b2 * b2 + b3 * b3 - 1.0,
        c1 * c1 + c2 * c2 + c3 * c3 - 1.0,
        a1 * b1 + a2 * b2 + a3 * b3,
        b1 * c1 + b2 * c2 + b3 * c3,
        c1 * a1 + c2 * a2 + c3 * a3,
    )
    deviation = max(max(errors), -min(errors))
    if not (deviation <= tolerance and math.isfinite(sum(errors))):  # a NaN hides from max
        raise ValueError(
            f"{name}: expected a rotation matrix, max |{name}^T {name} - I| at most {tolerance:g}, "
            f"found {deviation if math.isfinite(sum(errors)) else math.nan:.3g}: {R.tolist()}"
        )
    determinant = a1 * (b2 * c3 - b3 * c2) + b1 * (c2 * a3 - c3 * a2) + c1 * (a2 * b3 - a3 * b2)
    if determinant < 0.0:
        raise ValueError(
            f"{name}: expected a rotation matrix, determinant +1, found {determinant:.6g} (a reflection): {R.tolist()}"
        )
