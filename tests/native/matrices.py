"""Directions, rotations and inertias at random."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def unit(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def rotation(rng: np.random.Generator) -> np.ndarray:
    return Rotation.random(random_state=rng).as_matrix()


def inertia(rng: np.random.Generator) -> np.ndarray:
    """Full and unequal, of a body: from three masses' second moments."""
    a, b, c = rng.uniform(0.5, 2.0, 3)
    R = rotation(rng)
    J = R @ np.diag([b + c, c + a, a + b]) @ R.T
    return 0.5 * (J + J.T)


def positive_definite(rng: np.random.Generator) -> np.ndarray:
    R = rotation(rng)
    L = R @ np.diag(rng.uniform(0.2, 2.0, 3)) @ R.T
    return 0.5 * (L + L.T)
