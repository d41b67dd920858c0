"""Drop-outs: a signal that is lost and found again as a Markov process of two states in continuous time
(Gilbert, 1960). Tests: tests/plant/sensors/test_models.py."""

from __future__ import annotations

import math

from .noise import uniform


def lost(was: bool, interval: float, duration: float, span: float, seed: int, sample: int, sensor: int) -> bool:
    """Returns whether the signal is lost, `span` s after it `was`; interval and duration, s: mean times found and lost.

    The exact probability for any span: P = q + (was - q) exp(-span (1/interval + 1/duration)), q = duration/(interval +
    duration).
    """
    q = duration / (interval + duration)
    probability = q + (was - q) * math.exp(-span * (1.0 / interval + 1.0 / duration))
    return uniform(seed, sample, sensor) < probability
