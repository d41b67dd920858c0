"""The field and the air along an orbit as a satellite in LVLH meets them, for evidence/hold_bound.py.

Tests: tests/evidence/test_hold_bound.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import controller.reference
import plant
from controller.so3 import hat
from orchestration import InputError

from .paper import Array

INTERVAL = 20.0
"""s, over which the means are taken, at most."""


def by_turn(J: Array, w: Array) -> Array:
    """The matrix (3,3) that takes theta to [theta, J] w."""
    return np.array([hat(e) @ J @ w - J @ hat(e) @ w for e in np.eye(3)]).T


def uneven(J: Array) -> float:
    """Norm of what J differs by from a multiple of the unit matrix, which no turn changes."""
    return float(np.linalg.norm(J - np.trace(J) / 3.0 * np.eye(3), 2))


@dataclass(frozen=True)
class Course:
    """At the ends and in the middle of n intervals the direction of the field and its rate of change in N, in LVLH
    axes (2n+1, 3).

    There too `times` (2n+1,), s, the velocity `v` relative to the air, m/s in LVLH axes (2n+1, 3), and its `density`,
    kg/m3 (2n+1,), zero without drag.
    """

    times: Array
    b: Array
    c: Array
    v: Array
    density: Array
    Omega_d: Array

    @property
    def interval(self) -> float:
        """s."""
        return float(self.times[2] - self.times[0])

    @property
    def count(self) -> int:
        """Number of intervals."""
        return len(self.times) // 2

    @classmethod
    def of(cls, p: plant.Parameters, begin: float, end: float, interval: float = INTERVAL, more: int = 0) -> Course:
        """Along the plant's orbit between two of its times, s, in intervals of at most so many s, and so many
        intervals more.

        Raises InputError for an orbit that is not circular.
        """
        if p.orbit.eccentricity > 0.0:
            raise InputError(f"expected a circular orbit, found an eccentricity of {p.orbit.eccentricity:g}")
        count = math.ceil((end - begin) / interval)
        times = begin + (end - begin) * np.arange(2 * (count + more) + 1) / (2 * count)
        lvlh = [controller.reference.lvlh(*p.orbit.position_velocity(t)) for t in times]
        to_N = np.array([frame.R_d for frame in lvlh])
        B = np.array([p.field.at(t) for t in times])
        b_N = B / np.linalg.norm(B, axis=1)[:, None]
        c_N = np.gradient(b_N, times[1] - times[0], axis=0, edge_order=2)
        flows = [p.air.flow(t) if p.drag else (np.zeros(3), 0.0) for t in times]
        v_N, density = np.array([v for v, _ in flows]), np.array([density for _, density in flows])
        b, c, v = (np.einsum("kji,kj->ki", to_N, x) for x in (b_N, c_N, v_N))
        return cls(times, b, c, v, density, np.array(lvlh[0].Omega_d))

    def mean(self, values: Array) -> Array:
        """Returns means over each interval (n,) of values at ends and middles (2n+1,), by Simpson's rule."""
        return np.asarray(values[:-1:2] + 4.0 * values[1::2] + values[2::2]) / 6.0


def second(angle: float) -> float:
    """Returns an upper bound of Q S Q^T - S - [theta, S], over the norm of S."""
    return 2.0 * angle**2 * math.exp(2.0 * angle)


def facing(along: Array, angle: float) -> tuple[Array, Array]:
    """Of plates with n.v/|v| = x the share s of max(n.v, 0) that is linear, s n.v, and the most that is left of it
    over |v|.

    That is for a v that turns by up to an angle. What is left is between zero and (angle^2 - x^2)/(2 angle), for a
    plate that stands along the flow to the angle; other plates face the flow, s = 1, or do not.
    """
    return np.clip(0.5 + 0.5 * along / angle, 0.0, 1.0), np.maximum(angle**2 - along**2, 0.0) / (2.0 * angle)


def drag(p: plant.Parameters, course: Course, angle: float) -> tuple[Array, Array, float]:
    """The moment of drag, N m in LVLH axes, at the target (2n+1, 3); its change with theta (2n+1, 3, 3); and a bound
    of the rest.

    The half of what may be left of the flow on a plate (facing) counts as known. It is the same for a plate and the
    one on the other side.
    """
    if not p.drag:
        return np.zeros_like(course.v), np.zeros((len(course.v), 3, 3)), 0.0
    normals, arms = p.surface.normals, p.surface.arms
    pairs = arms + arms[np.argmin(normals @ normals.T, axis=1)]
    speed = np.linalg.norm(course.v, axis=1)
    shares, edges = facing(course.v @ normals.T / speed[:, None], angle)
    known, unknown = 0.5 * edges @ arms, 0.25 * edges @ np.linalg.norm(pairs, axis=1)
    S = np.einsum("kp,pi,pj->kij", shares, arms, normals)
    faced = np.einsum("kij,kj->ki", S, course.v) + speed[:, None] * known
    moment = course.density[:, None] * np.cross(course.v, faced)
    change = np.array([rho * hat(v) @ by_turn(s, v) for rho, v, s in zip(course.density, course.v, S, strict=True)])
    rest = second(angle) * np.array([uneven(s) for s in S]) + angle * np.linalg.norm(known, axis=1) + unknown
    return moment, change, float((course.density * speed**2 * rest).max())
