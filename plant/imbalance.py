"""Imbalance of the wheels. # not in the paper, whose wheel is symmetric.

The mass centre of a wheel at r is d off its axis (static: U_s = m d), and a principal axis is tilted (dynamic: U_d, the
wheel's product of inertia). With e(theta) a unit vector across the axis that turns with the wheel, its momentum
about the satellite's centre of mass is, beside l_w u,

    (l_w/I_w) (U_d + U_s r^) de/dtheta = d/dt [(U_d + U_s r^) e],

so that at a speed w it acts by U_d w^2 e + r x U_s w^2 e. Over any time its mean is known in closed form: a step may
last longer than a turn of the wheel. Left out: the part of the satellite's inertia that turns with the wheel.
Tests: tests/native/test_plant_imbalance.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .so3 import Array
from .wheel import Part


@dataclass(frozen=True)
class Imbalances:
    """Those of n wheels: (U_d + U_s r^) e is cosine cos(theta) + sine sin(theta), rows of (n, 3), kg m2."""

    cosine: Array
    sine: Array
    inertia: Array
    """I_w (n,), kg m2."""

    def swing(self, angle: Array) -> Array:
        """(U_d + U_s r^) e (3,) of all, at their angles (n,)."""
        return np.asarray(np.cos(angle) @ self.cosine + np.sin(angle) @ self.sine)

    def momentum(self, angle: Array, l_w: Array) -> Array:
        """Its rate (3,), N m s: momentum of all beside l_w u."""
        speed = l_w / self.inertia
        return np.asarray((speed * np.cos(angle)) @ self.sine - (speed * np.sin(angle)) @ self.cosine)

    def turned(self, part: Part, angle: Array, s: float) -> Array:
        """Angles (n,) at time s after the start of a part of a step, at which they are `angle`."""
        return np.array(
            [
                math.remainder(before + s * segment.mean(0.0, s) / inertia, math.tau)
                for before, segment, inertia in zip(angle.tolist(), part.segments, self.inertia.tolist(), strict=True)
            ]
        )


def imbalances(axes: Array, inertia: Array, product: Array, moment: Array, position: Array) -> Imbalances | None:
    """Those of wheels with unit axes (n, 3), inertia I_w, U_d and U_s (n,), at positions (n, 3); None where all are
    balanced. e at the angle zero is axis x the body axis that is furthest from it, of equal ones the first."""
    if not (product.any() or moment.any()):
        return None
    across = np.cross(axes, np.eye(3)[np.abs(axes).argmin(axis=1)])
    e = across / np.linalg.norm(across, axis=1, keepdims=True)

    def moved(way: Array) -> Array:
        """(U_d + U_s r^) of ways (n, 3)."""
        return np.asarray(product[:, None] * way + moment[:, None] * np.cross(position, way))

    return Imbalances(moved(e), moved(np.cross(axes, e)), inertia)
