"""Rotation matrices and unit quaternions, q v q* = R v; a quaternion is scalar first here."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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


def quaternions(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """The quaternions (n, 4) of rotation matrices (n, 9), by the same method; each on the side of the one before it.

    One by one they would take as long as the rest of a page that shows thousands.
    """
    a, b, c, d, e, f, g, h, i = rotations.reshape(-1, 9).T
    candidates = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    q = candidates[np.argmax([a + e + i, a, e, i], axis=0), :, np.arange(len(a))]
    q /= np.sqrt((q * q).sum(axis=1, keepdims=True))
    turns = np.concatenate([q[:1, 0], (q[1:] * q[:-1]).sum(axis=1)])  # negative where the sign is the other one
    return q * np.where(turns < 0.0, -1.0, 1.0).cumprod()[:, None]


def transposed(R: Sequence[float]) -> list[float]:
    a, b, c, d, e, f, g, h, i = R
    return [a, d, g, b, e, h, c, f, i]


def about(axis: Sequence[float], angle: float) -> list[float]:
    """The rotation matrix by an angle, rad, about an axis of any length (Rodrigues).

    Raises ValueError where it is zero.
    """
    x, y, z = axis
    square = x * x + y * y + z * z
    if not 0.0 < square < math.inf:
        raise ValueError(f"axis: expected a direction, found {list(axis)}")
    c, s = _cosine_sine(angle)
    d = 1.0 - c
    sx, sy, sz = (s * math.copysign(math.sqrt(value * value / square), value) for value in axis)
    xy, yz, zx = d * (x * y / square), d * (y * z / square), d * (z * x / square)
    return [
        *(c + d * (x * x / square), xy - sz, zx + sy),
        *(xy + sz, c + d * (y * y / square), yz - sx),
        *(zx - sy, yz + sx, c + d * (z * z / square)),
    ]


def euler(angles: Sequence[float], sequence: str) -> list[float]:
    """The rotation matrix of three angles, rad, about the axes of a sequence.

    Capitals turn about the turned axes, "ZYX" being R_z(a) R_y(b) R_x(c); small letters about the fixed ones, "xyz"
    being R_z(c) R_y(b) R_x(a). Raises ValueError where the sequence is none, or names an axis twice in a row.
    """
    if (
        not isinstance(sequence, str)
        or not re.fullmatch("[XYZ]{3}|[xyz]{3}", sequence)
        or re.search(r"(.)\1", sequence)
    ):
        raise ValueError(
            f"sequence: expected three axes, ZYX about the turned axes or xyz about the fixed ones, found {sequence!r}"
        )
    unit = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    first, second, third = (about(unit[a.lower()], angle) for a, angle in zip(sequence, angles, strict=True))
    return _product(_product(first, second), third) if sequence.isupper() else _product(_product(third, second), first)


def angles(R: Sequence[float], sequence: str) -> list[float]:
    """Returns the three angles, rad, of which `euler` makes this matrix; the second within -90..90 or 0..180 deg.

    Where the first and the third turn about one line, the third is zero. Raises ValueError as `euler` does.
    """
    euler([0.0, 0.0, 0.0], sequence)
    turned = sequence if sequence.isupper() else sequence[::-1].upper()
    i, j, k = ("XYZ".index(letter) for letter in turned)
    M, last = [list(R[3 * n : 3 * n + 3]) for n in range(3)], k
    k = 3 - i - j
    e = 1.0 if (j - i) % 3 == 1 else -1.0
    if last == i:
        size = math.hypot(M[j][i], M[k][i])
        first, second = math.atan2(M[j][i], -e * M[k][i]), math.atan2(size, M[i][i])
        third = math.atan2(M[i][j], e * M[i][k])
    else:
        size = math.hypot(M[i][i], M[i][j])
        first, second = math.atan2(-e * M[j][k], M[k][k]), math.atan2(e * M[i][k], size)
        third = math.atan2(-e * M[i][j], M[i][i])
    if size < 1e-12:
        first, third = math.atan2(e * M[k][j], M[j][j]), 0.0
    found = [first, second, third]
    return found if sequence.isupper() else found[::-1]


VECTORS = ("mrp", "rotation vector")
FORMS = "mrp, rotation vector, or euler and a sequence such as ZYX"
"""Ways to write a rotation as three numbers."""


def three(R: Sequence[float], form: str) -> list[float]:
    """Returns the three numbers of a matrix in one of FORMS, rad. Raises ValueError where the form is none."""
    if form not in VECTORS:
        return angles(R, _sequence(form))
    w, *v = quaternion(R)
    if form == "mrp":
        return [x / (1.0 + w) for x in v]
    size = math.sqrt(sum(x * x for x in v))
    by = 2.0 * math.atan2(size, w) / size if size > 1e-12 else 2.0
    return [by * x for x in v]


def of_three(x: Sequence[float], form: str) -> list[float]:
    """Returns the matrix of three numbers in one of FORMS, rad. Raises ValueError where the form is none."""
    if form not in VECTORS:
        return euler(x, _sequence(form))
    square = sum(value * value for value in x)
    if form == "mrp":
        return matrix([(1.0 - square) / (1.0 + square), *(2.0 * value / (1.0 + square) for value in x)])
    return about(x, math.sqrt(square)) if square > 0.0 else about((1.0, 0.0, 0.0), 0.0)


def _sequence(form: str) -> str:
    name, _, sequence = form.partition(" ")
    if name != "euler":
        raise ValueError(f"expected {FORMS}, found {form!r}")
    return sequence


def _cosine_sine(angle: float) -> tuple[float, float]:
    """Exact at the double next to a quarter turn, so that 90 deg gives zeros and ones."""
    quarters = round(angle / (math.pi / 2))
    if angle == quarters * (math.pi / 2):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarters % 4]
    return math.cos(angle), math.sin(angle)


def _product(A: Sequence[float], B: Sequence[float]) -> list[float]:
    return [sum(A[3 * i + k] * B[3 * k + j] for k in range(3)) for i in range(3) for j in range(3)]
