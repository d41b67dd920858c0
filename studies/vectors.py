"""Vectors and matrices of three, many at once: components first, cases last. A vector is (3, n), a matrix (3, 3, n)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def cross(x: Array, y: Array) -> Array:
    """x^ y of each case, (3, n)."""
    return np.array((x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]))


def dot(x: Array, y: Array) -> Array:
    """x . y of each case, (n,)."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def norm(x: Array) -> Array:
    return np.sqrt(dot(x, x))


def times(M: Array, x: Array) -> Array:
    """M x of each case."""
    return M[:, 0] * x[0] + M[:, 1] * x[1] + M[:, 2] * x[2]


def transposed_times(M: Array, x: Array) -> Array:
    """M^T x of each case."""
    return M[0] * x[0] + M[1] * x[1] + M[2] * x[2]


def product(A: Array, B: Array) -> Array:
    """A B of each case."""
    return A[:, None, 0] * B[0] + A[:, None, 1] * B[1] + A[:, None, 2] * B[2]


def hat(x: Array) -> Array:
    """x^ of each case."""
    zero = np.zeros_like(x[0])
    return np.array(((zero, -x[2], x[1]), (x[2], zero, -x[0]), (-x[1], x[0], zero)))


def solve(M: Array, y: Array) -> Array:
    """x with M x = y of each case, by Cramer's rule."""
    a, b, c = M[:, 0], M[:, 1], M[:, 2]
    b_c = cross(b, c)
    determinant = dot(a, b_c)
    return np.array((dot(y, b_c), dot(a, cross(y, c)), dot(a, cross(b, y)))) / determinant


def cayley(f: Array) -> Array:
    """F = (I + f^)(I - f^)^-1 of each case."""
    skew = hat(f)
    F = (2.0 / (1.0 + dot(f, f))) * (skew + product(skew, skew))
    for i in range(3):
        F[i, i] += 1.0
    return F


def angle(Q: Array) -> Array:
    """Principal angle of each rotation, (n,), from sine and cosine together."""
    sine = 0.5 * norm(np.array((Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1])))
    return np.arctan2(sine, 0.5 * (Q[0, 0] + Q[1, 1] + Q[2, 2] - 1.0))


def inverse(M: Array) -> Array:
    """M^-1 of each case."""
    return np.moveaxis(np.linalg.inv(np.moveaxis(M, -1, 0)), 0, -1)


def random_rotations(rng: np.random.Generator, n: int) -> Array:
    """Rotations (3, 3, n), uniform on SO(3): unit quaternions uniform on the sphere."""
    w, x, y, z = (q := rng.standard_normal((4, n))) / np.sqrt((q * q).sum(axis=0))
    return np.array(
        (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
    )
