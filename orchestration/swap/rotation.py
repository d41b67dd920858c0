"""Rotation matrices and unit quaternions, q v q* = R v; a quaternion is scalar first here."""

from __future__ import annotations

import math
from collections.abc import Sequence

UNIT_TOLERANCE = 1e-3
"""How far the length of a quaternion may be from one; the rest is taken out."""


def matrix(q: Sequence[float]) -> list[float]:
    """The rotation matrix of a quaternion, row by row. Raises ValueError where its length is not one."""
    w, x, y, z = q
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if not abs(norm - 1.0) <= UNIT_TOLERANCE:
        raise ValueError(f"expected a quaternion of length 1, to {UNIT_TOLERANCE:g}, found one of {norm:.6g}")
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return [
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]


def quaternion(R: Sequence[float], near: Sequence[float] | None = None) -> list[float]:
    """The quaternion of a rotation matrix given row by row (Shepperd's method).

    Of the two of opposite sign the one on the side of `near`, so that a course of them has no jumps;
    without it, the one with a scalar of zero or more.
    """
    a, b, c, d, e, f, g, h, i = R
    largest = max(a + e + i, a, e, i)
    if largest == a + e + i:
        q = [1 + a + e + i, h - f, c - g, d - b]
    elif largest == a:
        q = [h - f, 1 + a - e - i, b + d, c + g]
    elif largest == e:
        q = [c - g, b + d, 1 - a + e - i, f + h]
    else:
        q = [d - b, c + g, f + h, 1 - a - e + i]
    norm = math.sqrt(sum(x * x for x in q))
    side = q[0] if near is None else sum(x * y for x, y in zip(q, near, strict=True))
    return [x / (norm if side >= 0.0 else -norm) for x in q]


def transposed(R: Sequence[float]) -> list[float]:
    a, b, c, d, e, f, g, h, i = R
    return [a, d, g, b, e, h, c, f, i]
