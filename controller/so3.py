"""Vectors of three and rotations: the little that the law needs of SO(3).

`cross` works on floats since numpy's own costs thirty times as much on three elements.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def norm(x: Array) -> float:
    """|x| of x (3,)."""
    return math.hypot(*x.tolist())


def cross(x: Array, y: Array) -> Array:
    """x^ y = x cross y, both (3,)."""
    x1, x2, x3 = x.tolist()
    y1, y2, y3 = y.tolist()
    return np.array((x2 * y3 - x3 * y2, x3 * y1 - x1 * y3, x1 * y2 - x2 * y1))


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


def principal_angle(Q: Array) -> float:
    """|zeta| of Q = exp(zeta^), in [0, pi], rad.

    From sine and cosine together: the arc cosine of the trace alone has half the digits near 0 and near pi.
    """
    (q11, q12, q13), (q21, q22, q23), (q31, q32, q33) = Q.tolist()
    sine = 0.5 * math.hypot(q32 - q23, q13 - q31, q21 - q12)
    cosine = 0.5 * (q11 + q22 + q33 - 1.0)
    return math.atan2(sine, cosine)


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


def project(M: Array) -> Array:
    """The rotation nearest to M (3,3) in the Frobenius norm: U diag(1, 1, det U V^T) V^T of M = U S V^T."""
    U, _, Vt = np.linalg.svd(M)
    return U @ np.diag((1.0, 1.0, np.linalg.det(U @ Vt))) @ Vt
