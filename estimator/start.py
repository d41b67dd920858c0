"""The first attitude, from two directions: TRIAD (Black, 1964)."""

from __future__ import annotations

import math

import numpy as np

from .so3 import Array, cross, norm

SINE_MIN = math.sin(math.radians(10.0))
"""Of the angle between the two directions: nearer to each other they leave the turn about them too open."""


def triad(first_B: Array, second_B: Array, first_N: Array, second_N: Array) -> Array | None:
    """R_NB (3,3) that maps the first direction exactly and the second as well as that allows. None where a pair is collinear.

    Directions (3,) of any length.
    """
    pairs = []
    for first, second in ((first_B, second_B), (first_N, second_N)):
        normal = cross(first, second)
        if not norm(normal) >= SINE_MIN * norm(first) * norm(second) > 0.0:
            return None
        x, z = first / norm(first), normal / norm(normal)
        pairs.append(np.column_stack((x, z, cross(x, z))))
    return pairs[1] @ pairs[0].T
