"""The magnetometer: bias, noise, scale factors, misalignments, and the field of the rods beside it.
Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

from . import noise
from .noise import Array
from .parameters import Parameters
from .three_axis import digitised, scaled


def measured(b_B: Array, dipole: Array | None, p: Parameters, sample: int) -> Array:
    """The field (3,), T, that is read in the field b_B (3,), T; dipole (3,), A m2, of the rods, None
    where not connected."""
    x = b_B if dipole is None or not p.has_rod_coupling else b_B + p.field_rod_coupling @ dipole
    x = scaled(x, p.field_scale if p.has_field_scale else None)
    x = x + p.field_bias_B + noise.noise(p.seed, sample, noise.FIELD, p.field_noise)
    return digitised(x, p.field_range, p.field_quantum)
