"""The GNSS receiver: position and velocity with noise. Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

from . import noise
from .noise import Array
from .parameters import Parameters


def measured(r_N: Array, v_N: Array, p: Parameters, sample: int) -> tuple[Array, Array]:
    """Position (3,), m, and velocity (3,), m/s, of a fix."""
    return (
        r_N + noise.noise(p.seed, sample, noise.POSITION, p.position_noise),
        v_N + noise.noise(p.seed, sample, noise.VELOCITY, p.velocity_noise),
    )
