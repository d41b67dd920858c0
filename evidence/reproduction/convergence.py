"""The starts from which the law converges when its torque is given exactly, flown by design/exact.py."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import controller
from controller import so3
from controller.gains import attitude_scale, rate_scale
from design.exact import Flown, fly

from ..paper import ORBIT, STEP, Array
from ..samples import random_rotations

ORBITAL_RATE = 2.0 * math.pi / ORBIT
RATE_MAX = 0.1
"""Random rates are uniform in a ball of this radius, rad/s; the paper's manoeuvres start at 0.10 and 0.077."""
OFF_EDGE, EACH = 1e-6, 20
"""Starts near an unstable equilibrium: rad from it, and how many from each."""
SIGNS = np.array(((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)))
"""The diagonals of Q where the law rests: the goal and three half turns, which docs/evidence/margins.md has, too."""


def start(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Attitude errors Q uniform on SO(3), and body rates uniform in a ball of RATE_MAX."""
    Q = random_rotations(rng, n)
    direction = rng.standard_normal((3, n)).T
    size = RATE_MAX * rng.random(n) ** (1.0 / 3.0)
    return Q, size[:, None] * direction / np.linalg.norm(direction, axis=1)[:, None]


def random_cases(
    law: controller.Parameters, schedule: str, n: int = 600, duration: float = 600.0, J: Array | None = None
) -> Flown:
    """n random starts under one law with the gain schedule "error" [10] or "constant".

    J (n, 3, 3): the bodies' inertias, by default what the law knows.
    """
    p = replace(law, gain_schedule=schedule)
    if schedule == "constant":  # k and l as [10] has them at the start from (90 deg, 0.1 rad/s)
        p = replace(
            p,
            kappa0=attitude_scale(p.kappa0, p.a1, p.a2, math.pi / 2, math.pi / 2),
            lambda0=rate_scale(p.lambda0, p.c1, p.c2, RATE_MAX, RATE_MAX),
        )
    Q, Omega = start(np.random.default_rng(1), n)
    return fly(p, p.J_B if J is None else J, Q, Omega, duration, STEP, ORBITAL_RATE)


def from_the_edge(law: controller.Parameters) -> Flown:
    """Starts at rest OFF_EDGE from each of the three unstable equilibria, EACH in random directions; gains [10]."""
    rng = np.random.default_rng(3)
    Q = []
    for which in (1, 2, 3):
        for _ in range(EACH):
            x = rng.standard_normal(3)
            Q.append(np.diag(SIGNS[which]) @ so3.exp(OFF_EDGE * x / np.linalg.norm(x)))
    at = np.array(Q)
    return fly(law, law.J_B, at, -ORBITAL_RATE * at[:, 1], 1500.0, STEP, ORBITAL_RATE)
