"""Vectors of three. `cross` and `dot` work on floats since numpy's own cost thirty and four times as much
on three elements. Tests: tests/allocator/test_allocation.py."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def norm(x: Array) -> float:
    """|x| of x (3,)."""
    return math.hypot(*x.tolist())


def dot(x: Sequence[float], y: Sequence[float]) -> float:
    """x.y of three elements each."""
    x1, x2, x3 = x
    y1, y2, y3 = y
    return x1 * y1 + x2 * y2 + x3 * y3


def cross(x: Array, y: Array) -> Array:
    """x^ y = x cross y, both (3,)."""
    x1, x2, x3 = x.tolist()
    y1, y2, y3 = y.tolist()
    return np.array((x2 * y3 - x3 * y2, x3 * y1 - x1 * y3, x1 * y2 - x2 * y1))
