"""Telemetry of the wheels and the rods. Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import numpy as np

from . import noise
from .noise import Array
from .parameters import Parameters

NO_DIPOLE = np.zeros(3)


def measured(h_w: float | Array, dipole: Array | None, p: Parameters, sample: int) -> tuple[float | Array, Array]:
    """Wheel momentum, N m s, (4,) of a set, and the dipole of each rod (3,), A m2; zeros where the rods' is not
    connected."""
    if isinstance(h_w, np.ndarray):
        off = noise.noise(p.seed, sample, noise.WHEEL, p.wheel_momentum_noise, len(h_w))
        wheel: float | Array = h_w + off + p.wheel_momentum_bias
    else:
        wheel = h_w + float(noise.noise(p.seed, sample, noise.WHEEL, p.wheel_momentum_noise, 1)[0])
    if dipole is None:
        return wheel, NO_DIPOLE
    return wheel, dipole + noise.noise(p.seed, sample, noise.DIPOLE, p.dipole_noise)
