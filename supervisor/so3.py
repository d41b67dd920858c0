"""Vectors of three and rotations. Tests: tests/supervisor/test_reference.py."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SMALL = 0.05
"""rad, below which the coefficients of the exponential are taken from their series, for they lose digits."""


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


def principal_angle(Q: Array) -> float:
    """|zeta| of Q = exp(zeta^), in [0, pi], rad.

    From sine and cosine together: the arc cosine of the trace alone has half the digits near 0 and near pi.
    """
    (q11, q12, q13), (q21, q22, q23), (q31, q32, q33) = Q.tolist()
    sine = 0.5 * math.hypot(q32 - q23, q13 - q31, q21 - q12)
    cosine = 0.5 * (q11 + q22 + q33 - 1.0)
    return math.atan2(sine, cosine)


def coefficients(angle: float) -> tuple[float, float, float, float]:
    """a = (1 - cos x)/x^2 and b = (x - sin x)/x^3, and a'/x, b'/x: of the right Jacobian I - a x^ + b x^^2."""
    x2 = angle * angle
    if angle < SMALL:
        a = 1 / 2 - x2 / 24 + x2 * x2 / 720
        b = 1 / 6 - x2 / 120 + x2 * x2 / 5040
        return a, b, -1 / 12 + x2 / 180 - x2 * x2 / 6720, -1 / 60 + x2 / 1260 - x2 * x2 / 60480
    s, c = math.sin(angle), math.cos(angle)
    a, b = (1.0 - c) / x2, (angle - s) / (x2 * angle)
    return a, b, (s / angle - 2.0 * a) / x2, (a - 3.0 * b) / x2


def shortest(a: Array, b: Array) -> Array:
    """The smallest turn (3,3) that takes the direction of a (3,) to the unit vector b (3,); of opposite
    ones any half turn."""
    a = a / norm(a)  # else its rounding would double from step to step
    v, c = np.cross(a, b), float(a @ b)
    if c < -1.0 + 1e-12:
        axis = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        axis = axis / norm(axis)
        return 2.0 * np.outer(axis, axis) - np.eye(3)
    skew = hat(v)
    return np.eye(3) + skew + (skew @ skew) / (1.0 + c)


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
