"""The gyro, in the terms of IEEE Std 952: bias, angle random walk, rate random walk, Markov noise, scale
factor, range, resolution. Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import math

from . import noise
from .noise import Array
from .parameters import Parameters
from .three_axis import digitised, scaled


def walked(walk: Array, p: Parameters, sample: int, span: float) -> Array:
    """The rate random walk (3,), rad/s, `span` s later: w + K sqrt(T) xi."""
    return walk + noise.noise(p.seed, sample, noise.RATE_WALK, p.rate_random_walk * math.sqrt(span))


def correlated(markov: Array, p: Parameters, sample: int, span: float) -> Array:
    """The exponentially correlated noise (3,), rad/s, `span` s later: e g + sqrt(1 - e^2) sigma xi, e = exp(-T/T_c).

    The exact step of a stationary first-order Gauss-Markov process, for any span; without end it is a first number.
    """
    e = math.exp(-span / p.rate_instability_time)
    sigma = p.rate_instability * math.sqrt(-math.expm1(-2.0 * span / p.rate_instability_time))
    return e * markov + noise.noise(p.seed, sample, noise.RATE_INSTABILITY, sigma)


def measured(omega_B: Array, drift: Array | None, p: Parameters, sample: int, span: float) -> Array:
    """The rate (3,), rad/s, that is read; span: s since the last measurement, over which the angle random
    walk is white noise."""
    sigma = p.rate_noise
    if p.angle_random_walk > 0.0 and span > 0.0:
        sigma = math.sqrt(sigma * sigma + p.angle_random_walk * p.angle_random_walk / span)
    x = scaled(omega_B, p.rate_scale if p.has_rate_scale else None)
    x = x + p.rate_bias_B + noise.noise(p.seed, sample, noise.RATE, sigma)
    return digitised(x if drift is None else x + drift, p.rate_range, p.rate_quantum)
