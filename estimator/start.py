"""The first attitude, from two directions: TRIAD (Black, 1964). Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math

import numpy as np

from .so3 import Array, cross, norm


def triad(first_B: Array, second_B: Array, first_N: Array, second_N: Array, apart: float) -> Array | None:
    """R_NB (3,3) that maps the first direction exactly and the second as well as that allows.

    Directions (3,) of any length. None where those of a pair are less than `apart`, rad, from one line.
    """
    pairs = []
    for first, second in ((first_B, second_B), (first_N, second_N)):
        if not sine(first, second) >= math.sin(apart):
            return None
        x, normal = first / norm(first), cross(first, second)
        z = normal / norm(normal)
        pairs.append(np.column_stack((x, z, cross(x, z))))
    R: Array = pairs[1] @ pairs[0].T
    return R


def sine(x: Array, y: Array) -> float:
    """Returns the sine of the angle between x and y (3,); 0 where one of them is zero."""
    both = norm(x) * norm(y)
    return norm(cross(x, y)) / both if both > 0.0 else 0.0
