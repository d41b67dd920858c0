"""Vectors of three and rotations: the little that the filter needs of SO(3)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of a measured attitude: single precision stays well below it."""


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
    """zeta (3,) with R = exp(zeta^), |zeta| at most pi."""
    twice = np.array((R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]))
    s, c = 0.5 * norm(twice), 0.5 * (float(np.trace(R)) - 1.0)
    angle = math.atan2(s, c)
    if s > 1e-4:  # neither near 0 nor near pi
        return 0.5 * angle / s * twice
    if c > 0.0:
        return 0.5 * twice
    # Near a half turn the axis comes from (R + R^T)/2 - c I = (1 - c) axis axis^T, by its largest column.
    columns = 0.5 * (R + R.T) - c * np.eye(3)
    axis = columns[:, int(np.argmax(np.sum(columns * columns, axis=0)))]
    return math.copysign(angle / norm(axis), axis @ twice) * axis


def right_jacobian(x: Array) -> Array:
    """J_r of exp (3,3) to second order in x (3,): exp((x + y)^) = exp(x^) exp((J_r y)^) for a small y."""
    skew = hat(x)
    return np.eye(3) - 0.5 * skew + skew @ skew / 6.0


def orthonormalised(R: Array) -> Array:
    """R (3,3) nearer to SO(3), by a step of Newton's: R (3 - R^T R)/2. Rounding is all that it removes."""
    return 0.5 * R @ (3.0 * np.eye(3) - R.T @ R)


def require_rotation(name: str, R: Array) -> None:
    """Raises ValueError unless R (3,3) is orthonormal to ATTITUDE_TOLERANCE and right-handed."""
    deviation = float(np.abs(R.T @ R - np.eye(3)).max())
    if not deviation <= ATTITUDE_TOLERANCE:
        raise ValueError(
            f"{name}: expected a rotation matrix, max |{name}^T {name} - I| at most {ATTITUDE_TOLERANCE:g}, "
            f"found {deviation:.3g}: {R.tolist()}"
        )
    if (determinant := float(np.linalg.det(R))) < 0.0:
        raise ValueError(f"{name}: expected a rotation matrix, determinant +1, found {determinant:.6g} (a reflection)")
