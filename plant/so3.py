"""The rotation group SO(3): the few maps that the plant needs. Rotations are (3,3) arrays."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Triple = tuple[float, float, float]


def cayley(f: Array) -> Array:
    """F = (I + f^)(I - f^)^-1 = I + 2/(1 + f.f) (f^ + f^ f^), a rotation about f (3,) by 2 atan |f|."""
    x, y, z = f.tolist()
    c = 2.0 / (1.0 + x * x + y * y + z * z)
    return np.array(
        [
            [1.0 - c * (y * y + z * z), c * (x * y - z), c * (x * z + y)],
            [c * (x * y + z), 1.0 - c * (x * x + z * z), c * (y * z - x)],
            [c * (x * z - y), c * (y * z + x), 1.0 - c * (x * x + y * y)],
        ]
    )


def solve(A: tuple[Triple, Triple, Triple], y: Triple) -> Triple:
    """x of A x = y, A 3x3 regular, by Cramer's rule."""
    (a, b, c), (d, e, f), (g, h, i) = A
    p, q, r = y
    A11, A12, A13 = e * i - f * h, f * g - d * i, d * h - e * g
    A21, A22, A23 = c * h - b * i, a * i - c * g, b * g - a * h
    A31, A32, A33 = b * f - c * e, c * d - a * f, a * e - b * d
    determinant = a * A11 + b * A12 + c * A13
    return (
        (A11 * p + A21 * q + A31 * r) / determinant,
        (A12 * p + A22 * q + A32 * r) / determinant,
        (A13 * p + A23 * q + A33 * r) / determinant,
    )


def project(M: Array) -> Array:
    """The rotation nearest to M (3,3) in the Frobenius norm: U diag(1, 1, det U V^T) V^T of M = U S V^T."""
    U, _, Vt = np.linalg.svd(M)
    return U @ np.diag((1.0, 1.0, np.linalg.det(U @ Vt))) @ Vt


def from_quaternion(q: Array) -> Array:
    """The rotation of a quaternion (4,), scalar first, of any length but zero."""
    w, x, y, z = (q / math.sqrt(q @ q)).tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def to_quaternion(rotation: Array) -> Array:
    """The unit quaternion (4,) of a rotation, scalar first and not negative.

    Shepperd's method: the largest of the four squared components is the pivot, so that nothing
    cancels at any angle, 180 deg included (J. Guidance and Control 1(3), 1978).
    """
    (r11, r12, r13), (r21, r22, r23), (r31, r32, r33) = rotation.tolist()
    squares = (1.0 + r11 + r22 + r33, 1.0 + r11 - r22 - r33, 1.0 - r11 + r22 - r33, 1.0 - r11 - r22 + r33)
    pivot = squares.index(max(squares))
    if pivot == 0:
        q = (squares[0], r32 - r23, r13 - r31, r21 - r12)
    elif pivot == 1:
        q = (r32 - r23, squares[1], r12 + r21, r13 + r31)
    elif pivot == 2:
        q = (r13 - r31, r12 + r21, squares[2], r23 + r32)
    else:
        q = (r21 - r12, r13 + r31, r23 + r32, squares[3])
    length = math.hypot(*q) if q[0] >= 0.0 else -math.hypot(*q)
    return np.array([c / length for c in q])
