"""Sun sensors: coarse ones by the cosine law with the Earth's albedo, the sun vector made of them, and a fine one.
Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import math

import numpy as np

from . import noise
from .noise import Array
from .parameters import Parameters
from .star_tracker import EARTH_RADIUS, rotation

RIDGE = 1e-5
"""Of a unit axis: makes the shortest of all least-squares solutions where the sensors leave a direction open."""
NONE = np.zeros(3)


def measured(s_B: Array, sunlight: float, r_B: Array, p: Parameters, sample: int) -> tuple[Array, Array]:
    """The signals of the coarse sensors (6,), and the unit vector to the Sun (3,) by these or by the fine sensor.

    s_B (3,): unit vector to the Sun; r_B (3,), m: position from the Earth's centre, in B too.
    """
    x = signals(s_B, sunlight, r_B, p, sample)
    return x, vector(x, p) if p.sun_sensor == "coarse" else fine(s_B, sunlight, p, sample)


def signals(s_B: Array, sunlight: float, r_B: Array, p: Parameters, sample: int) -> Array:
    """(6,), 1 in full light at normal incidence: the Sun within each field of view by the cosine law, albedo, noise."""
    cosines = p.sun_axes @ s_B
    x = np.where(cosines >= max(math.cos(p.sun_sensor_half_angle), 0.0), sunlight * cosines, 0.0)
    if p.albedo > 0.0:
        r = math.sqrt(r_B @ r_B)
        up_B = r_B / r
        lit = p.albedo * max(float(up_B @ s_B), 0.0)
        H = max(r / EARTH_RADIUS, 1.0)
        x = x + [lit * view_factor(-float(axis @ up_B), H) for axis in p.sun_axes]
    x = x + noise.noise(p.seed, sample, noise.SUN_SENSORS, p.sun_sensor_noise, 6)
    return x * p.has_sun_axes


def view_factor(c: float, H: float) -> float:
    """From a small plate to the whole of a sphere, H >= 1 of its radii from its centre; c: cosine of normal and centre.

    Cunningham, NASA TN D-710 (1961); 1/H^2 where the plate faces the centre.
    """
    if c * H >= 1.0:
        return c / (H * H)
    if c * H <= -1.0:
        return 0.0
    m, s = math.sqrt(H * H - 1.0), math.sqrt(1.0 - c * c)  # the horizon of the plate crosses the sphere
    q = math.sqrt(max(1.0 - H * H * c * c, 0.0))
    part = c * math.atan2(q, -m * c) - m * q
    return 0.5 - math.atan2(m, q) / math.pi + part / (math.pi * H * H) if s > 0.0 else 0.0


def vector(x: Array, p: Parameters) -> Array:
    """The unit vector to the Sun (3,) from the signals (6,) by least squares; zeros where their vector is too short.

    Of the sensors those count that lie on the side of sum n_i x_i, since the others see albedo alone.
    """
    towards = p.sun_axes.T @ np.maximum(x, 0.0)
    used = p.sun_axes @ towards > 0.0
    axes = p.sun_axes[used]
    normal = axes.T @ axes + RIDGE * np.eye(3)
    found = np.asarray(np.linalg.solve(normal, axes.T @ x[used]), dtype=np.float64)
    length = math.sqrt(found @ found)
    return found * (1.0 / length) if length >= p.sun_threshold else NONE


def fine(s_B: Array, sunlight: float, p: Parameters, sample: int) -> Array:
    """The unit vector to the Sun (3,) by a fine sensor, turned by its noise; zeros outside its field of
    view and in shadow."""
    if sunlight < p.sun_threshold or float(p.fine_sun_axis @ s_B) < math.cos(p.fine_sun_half_angle):
        return NONE
    return rotation(noise.noise(p.seed, sample, noise.FINE_SUN, p.fine_sun_noise)) @ s_B
