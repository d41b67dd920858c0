"""Least squares in a box, solved exactly: minimise |A x - y|^2 where low <= x <= high.

In each minimum some elements of x are at a bound and the others are free, and the free ones solve the normal
equations. Of n elements there are 3^n such faces of the box, so for a few elements all can be tried: that takes a fixed
time, needs no starting point and no tolerance, and the result is exact to rounding.
"""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def least_squares(A: Array, y: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """The minimum in the box, and the one that there is without the box, both (n,).

    A (m, n) with independent columns, y (m,), low and high (n,) with low < high.
    """
    H, g = A.T @ A, A.T @ y
    free = np.asarray(np.linalg.solve(H, g), np.float64)
    if ((low <= free) & (free <= high)).all():
        return free, free
    return np.clip(_best_face(H, g, low, high), low, high), free


def _best_face(H: Array, g: Array, low: Array, high: Array) -> Array:
    """Of the minima on all faces, x (n,), the one that violates the conditions of optimality least: only by rounding.

    They are: x is in the box, and the gradient H x - g of half the cost pushes no element from its bound inwards. Both
    are counted in units of x; one element alone would move by gradient/H_ii.
    """
    side = _sides(len(g))
    fixed = side != 0
    bound = np.where(side < 0, low, high) * fixed
    equations = np.where(fixed[:, :, None] | fixed[:, None, :], np.eye(len(g)), H)
    x = np.linalg.solve(equations, np.where(fixed, bound, g - bound @ H)[..., None])[..., 0]
    inwards = side * (x @ H - g) / np.diag(H)
    violation = np.where(fixed, inwards, np.maximum(low - x, x - high)).max(axis=1)
    return np.asarray(x[violation.argmin()])


@cache
def _sides(n: int) -> Array:
    """(3^n, n): -1 at the lower bound, 0 free, 1 at the upper bound."""
    return np.array(list(itertools.product((0.0, -1.0, 1.0), repeat=n)))
