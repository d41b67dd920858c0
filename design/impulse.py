"""The most momentum that dipoles of a limited size can give along a direction: rho times the integral of |B x p|.

It is bounded from above by trapezoids on the chords of the field B, since |B x p| is convex in B, and by a bound on the
distance of B from its chords.

Tests: tests/design/test_momentum.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SAMPLE = 1.0
"""Interval of the chords, s."""


class Impulse:
    """The field of a manoeuvre, T, and what dipoles within a ball of radius `rho`, A m2, can do in it."""

    def __init__(self, field: Callable[[float], Array], rho: float, horizon: float) -> None:
        """`field`: B (3,) in N at a time; `horizon`, s: the longest time asked for."""
        self.rho = rho
        self.times = np.arange(math.ceil(horizon / SAMPLE) + 2) * SAMPLE
        self.B = np.array([field(t) for t in self.times])
        bend = np.abs(np.diff(self.B, 2, axis=0)).max() / SAMPLE**2
        # B's distance from its chord is h^2/8 max |B''|; differences see |B''| at the nodes, hence the factor 2.
        self.error = 2.0 * math.sqrt(3.0) * bend * SAMPLE**2 / 8.0
        self.B_max = float(np.linalg.norm(self.B, axis=1).max()) + self.error

    def chords(self, T: float) -> tuple[Array, Array]:
        """B (n, 3) at the corners of the chords over [0, T] and their trapezoidal weights, s; the last is at T."""
        n = math.floor(T / SAMPLE)
        rest = T - n * SAMPLE
        w = np.full(n + 2, SAMPLE)
        w[0], w[n + 1] = 0.5 * SAMPLE, 0.5 * rest
        w[n] = 0.5 * rest + (0.5 * SAMPLE if n else 0.0)
        end = self.B[n] + rest / SAMPLE * (self.B[n + 1] - self.B[n])
        return np.concatenate((self.B[: n + 1], [end])), w

    def impulse(self, p: Array, T: float) -> float:
        """At least rho times the integral of |B x p| over [0, T], N m s."""
        B, w = self.chords(T)
        each = np.linalg.norm(np.cross(B, p), axis=1)  # exact for p along B, where p.G p is what rounding leaves
        return self.rho * (float(w @ each) + float(w.sum()) * self.error * float(np.linalg.norm(p)))


def across(B: Array) -> Array:
    """G with p.G p = |B x p|^2, (..., 3, 3), of fields (..., 3)."""
    return (B * B).sum(axis=-1)[..., None, None] * np.eye(3) - B[..., :, None] * B[..., None, :]
