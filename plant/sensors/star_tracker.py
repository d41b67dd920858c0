"""The star tracker: noise about and across its boresight, and when it sees no stars.
Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import math

import numpy as np

from . import noise
from .noise import Array
from .parameters import Parameters

EARTH_RADIUS = 6378137.0
"""Equatorial, of WGS 84, m."""


def sees(R_NB: Array, omega_B: Array, r_N: Array, sun_N: Array | None, sunlight: float, p: Parameters) -> bool:
    """Returns whether rate, Sun and Earth leave it an attitude. The Sun does not blind it from behind the Earth."""
    if p.attitude_rate_max > 0.0 and float(omega_B @ omega_B) > p.attitude_rate_max**2:
        return False
    if p.attitude_sun_exclusion == 0.0 and p.attitude_earth_exclusion == 0.0:
        return True
    towards_N = R_NB @ p.boresight
    sun = sun_N if p.attitude_sun_exclusion > 0.0 and sunlight > 0.0 else None
    if sun is not None and float(towards_N @ sun) > math.cos(p.attitude_sun_exclusion):
        return False
    if p.attitude_earth_exclusion > 0.0:
        r = math.sqrt(r_N @ r_N)
        s = min(EARTH_RADIUS / r, 1.0)
        limb = math.atan2(s, math.sqrt(1.0 - s * s))  # from nadir
        return float(towards_N @ r_N) >= -r * math.cos(min(limb + p.attitude_earth_exclusion, math.pi))
    return True


def measured(R_NB: Array, p: Parameters, sample: int) -> Array:
    """R_NB exp(delta^) (3,3): delta is the bias, and noise of one sigma across the boresight and of another about
    it."""
    if not p.turns_attitude:
        return R_NB
    across, about = p.attitude_noise, p.attitude_noise_about
    turn = p.attitude_bias_B
    if about > 0.0:
        xi = noise.normals(p.seed, sample, noise.ATTITUDE, 3)
        turn = turn + across * xi + ((about - across) * float(p.boresight @ xi)) * p.boresight
    else:
        turn = turn + noise.noise(p.seed, sample, noise.ATTITUDE, across)
    return R_NB @ rotation(turn)


def rotation(turn: Array) -> Array:
    """exp(turn^) (3,3), the rotation about `turn` (3,), rad, by its length: by way of its unit quaternion."""
    angle = math.sqrt(turn @ turn)
    w = math.cos(0.5 * angle)
    x, y, z = ((math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5) * turn).tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
