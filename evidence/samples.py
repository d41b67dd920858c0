"""Random rotations and random bodies. Tests: tests/evidence/reproduction/test_convergence.py."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from .paper import Array


def random_rotations(rng: np.random.Generator, n: int) -> Array:
    """Rotations (n, 3, 3), uniform on SO(3): unit quaternions uniform on the sphere."""
    w, x, y, z = rng.standard_normal((4, n))
    return np.asarray(Rotation.from_quat(np.column_stack((x, y, z, w))).as_matrix())


def wrong_inertias(J: Array, n: int, seed: int, size: float) -> Array:
    """Inertias (n, 3, 3), kg m2, of real bodies near J (3, 3): J' = S (1 + size E) S with S = J^(1/2).

    E is symmetric with eigenvalues uniform in [-1, 1] and axes uniform on SO(3), so that products of inertia come
    with it.
    """
    rng = np.random.default_rng(seed)
    w, v = np.linalg.eigh(J)
    S = v @ np.diag(np.sqrt(w)) @ v.T
    bodies: list[Array] = []
    while len(bodies) < n:
        T = random_rotations(rng, 1)[0]
        candidate = S @ (np.eye(3) + size * T @ np.diag(rng.uniform(-1.0, 1.0, 3)) @ T.T) @ S
        candidate = 0.5 * (candidate + candidate.T)
        moments = np.linalg.eigvalsh(candidate)
        if moments[2] <= moments[0] + moments[1]:  # else no body has them
            bodies.append(candidate)
    return np.array(bodies)
