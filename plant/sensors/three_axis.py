"""The common part of gyro and magnetometer: three axes with scale-factor errors, misalignments, range and resolution.
Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import math

import numpy as np

from .noise import Array

EXACT = 2.0**52
"""From this number of quanta on every number is a multiple."""


def scaled(x: Array, scale: Array | None) -> Array:
    """(I + scale) x; scale (3,3) has the scale-factor errors on its diagonal and the misalignments off it."""
    return x if scale is None else x + scale @ x


def digitised(x: Array, limit: float, quantum: float) -> Array:
    """x (3,) clipped at +-limit and rounded to multiples of quantum, halves upwards; 0 switches either off."""
    if limit > 0.0:
        x = np.clip(x, -limit, limit)
    if quantum > 0.0:
        x = np.array([_rounded(value, quantum) for value in x.tolist()])
    return x


def _rounded(value: float, quantum: float) -> float:
    n = value / quantum
    return quantum * math.floor(n + 0.5) if abs(n) < EXACT else value
