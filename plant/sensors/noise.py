"""Standard normal numbers as a function of where they are used: no generator's state, so a repeated step repeats them.

Philox 4x32-10: Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC11 (2011).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Words = tuple[int, int, int, int]
"""Of 32 bits each."""

(ATTITUDE, RATE, FIELD, WHEEL, POSITION, VELOCITY, DIPOLE, SUN_SENSORS, FINE_SUN) = range(9)
(RATE_WALK, RATE_INSTABILITY, ATTITUDE_LOSS, ORBIT_LOSS) = range(9, 13)
"""Numbers of what draws noise, which keep it apart."""

ROUNDS = 10
_ZEROS = np.zeros(6)
_MASK = 0xFFFFFFFF
_MULTIPLIERS = (0xD2511F53, 0xCD9E8D57)
_KEY_STEPS = (0x9E3779B9, 0xBB67AE85)


def philox(counter: Words, key: tuple[int, int]) -> Words:
    """The four random words of a counter under a key."""
    a, b, c, d = counter
    k, m = key
    for _ in range(ROUNDS):
        x, y = _MULTIPLIERS[0] * a, _MULTIPLIERS[1] * c
        a, b, c, d = (y >> 32) ^ b ^ k, y & _MASK, (x >> 32) ^ d ^ m, x & _MASK
        k, m = (k + _KEY_STEPS[0]) & _MASK, (m + _KEY_STEPS[1]) & _MASK
    return a, b, c, d


def normals(seed: int, sample: int, sensor: int, n: int) -> Array:
    """n independent standard normal numbers of a sensor's sample; in pairs by Box and Muller (1958)."""
    numbers: list[float] = []
    for pair in range((n + 1) // 2):
        a, b, c, d = philox((sample & _MASK, sample >> 32 & _MASK, sensor, pair), (seed, 0))
        radius = math.sqrt(-2.0 * math.log(_uniform(a, b)))
        angle = 2.0 * math.pi * _uniform(c, d)
        numbers += radius * math.cos(angle), radius * math.sin(angle)
    return np.array(numbers[:n])


def noise(seed: int, sample: int, sensor: int, sigma: float, n: int = 3) -> Array:
    """(n,) of standard deviation sigma; zeros, without drawing any, where sigma is zero."""
    return sigma * normals(seed, sample, sensor, n) if sigma > 0.0 else _ZEROS[:n]


def uniform(seed: int, sample: int, sensor: int) -> float:
    """A number of a sensor's sample, evenly distributed in (0, 1)."""
    a, b, _, _ = philox((sample & _MASK, sample >> 32 & _MASK, sensor, 0), (seed, 0))
    return _uniform(a, b)


def _uniform(high: int, low: int) -> float:
    """In (0, 1), both ends left out: the middle of one of 2^52 equal parts."""
    return ((high << 32 | low) >> 12) * 2.0**-52 + 2.0**-53
