"""Vectors of three and rotations: the little that the filter needs of SO(3).
Tests: tests/estimator/test_estimator.py."""

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


def log(R: Array) -> Array:
    """x (3,) with R = exp(x^), |x| at most pi; R (3,3)."""
    (r11, r12, r13), (r21, r22, r23), (r31, r32, r33) = R.tolist()
    twice = np.array((r32 - r23, r13 - r31, r21 - r12))
    s, c = 0.5 * norm(twice), 0.5 * (r11 + r22 + r33 - 1.0)
    angle = math.atan2(s, c)
    if s > 1e-4:
        return (0.5 * angle / s) * twice
    if c > 0.0:
        return 0.5 * twice
    # Near a half turn: (R + R^T)/2 - c I = (1 - c) axis axis^T.
    outer = 0.5 * (R + R.T) - c * np.eye(3)
    axis = outer[:, int(np.argmax(np.einsum("ij,ij->j", outer, outer)))]
    return (math.copysign(angle, 1.0 if float(axis @ twice) >= 0.0 else -1.0) / norm(axis)) * axis


def right_jacobian(x: Array) -> Array:
    """J_r of exp (3,3) to second order in x (3,): exp((x + y)^) = exp(x^) exp((J_r y)^) for a small y."""
    skew = hat(x)
    return np.eye(3) - 0.5 * skew + skew @ skew / 6.0


def orthonormalised(R: Array) -> Array:
    """R (3,3) nearer to SO(3), by a step of Newton's: R (3 - R^T R)/2. Rounding is all that it removes."""
    return 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)


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
