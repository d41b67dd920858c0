"""Errors to LVLH from a body's motion, and when errors stay within a tolerance."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from .paper import Array


def errors_to_lvlh(R_NB: Array, omega_B: Array, r_N: Array, v_N: Array) -> tuple[Array, Array]:
    """Angle between attitude and LVLH, rad, and norm of the rate error, rad/s, each (n,).

    R_NB (n, 3, 3), omega_B (n, 3) rad/s, r_N (n, 3) m, v_N (n, 3) m/s. LVLH follows from position and velocity alone:
    Z to nadir, Y against the orbit's normal, turning at |r x v|/r^2 about the normal.
    """
    normal = np.cross(r_N, v_N)
    z = -r_N / np.linalg.norm(r_N, axis=1)[:, None]
    y = -normal / np.linalg.norm(normal, axis=1)[:, None]
    target = np.stack((np.cross(y, z), y, z), axis=2)
    Q = np.swapaxes(target, 1, 2) @ R_NB
    turning = normal / (r_N * r_N).sum(axis=1)[:, None]
    rate = omega_B - np.einsum("nji,nj->ni", R_NB, turning)
    return Rotation.from_matrix(Q).magnitude(), np.asarray(np.linalg.norm(rate, axis=1))


def settling_time(time: Array, outside: Array) -> float:
    """The first instant, s, from which on nothing is outside to the end; NaN where something is at the end.

    time (n,) s, outside (n,) flags.
    """
    last = np.flatnonzero(outside)
    if not len(last):
        return float(time[0])
    return math.nan if last[-1] + 1 == len(time) else float(time[last[-1] + 1])
