"""What becomes of a flight in which a part fails, by the plant's truth: metrics of the campaigns of rows.py.
Requirements, stated before the flights were flown:

- While the sensors that are left allow it, the satellite is within LOST of its target from `rest` after the failure on.
  They do not where the estimator's bound, which is computed without the failed sensor, is above NO_ATTITUDE; then the
  satellite has RETURN to come back.
- While they do not, it turns at most by SAFE_RATE beyond its target.

Tests: tests/evidence/health/test_verdict.py."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TUMBLE, HOLD = 100.0, 6000.0
"""s: when a part fails."""
REST, LATE = 600.0, 1800.0
"""s: what is left to recover in the hold, and in the tumble, where the slowest of 1000 sound satellites takes 1263."""
LOST, NO_ATTITUDE, SAFE_RATE = 15.0, 30.0, 1.0
"""deg, deg, deg/s"""
RETURN = 1800.0
"""s"""
ERROR, RATE, BOUND = "judge.attitude_error", "judge.rate_error_B", "estimator.attitude_bound"


def held(begin: float, time: Array, signals: dict[str, Array]) -> float:
    """The largest attitude error, deg, from `begin`, s, on, but for times without an attitude and RETURN after them."""
    last = np.maximum.accumulate(np.where(np.degrees(signals[BOUND]) > NO_ATTITUDE, time, -np.inf))
    counts = (time >= begin) & (time - last > RETURN)
    return float(np.degrees(signals[ERROR][counts].max(initial=0.0)))


def rate(begin: float, time: Array, signals: dict[str, Array]) -> float:
    """The largest rate, deg/s, from `begin`, s, on while there is no attitude."""
    counts = (time >= begin) & (np.degrees(signals[BOUND]) > NO_ATTITUDE)
    return float(np.degrees(np.linalg.norm(signals[RATE][counts], axis=1).max(initial=0.0)))


held_tumble, held_hold = partial(held, TUMBLE + LATE), partial(held, HOLD + REST)
rate_tumble, rate_hold = partial(rate, TUMBLE + LATE), partial(rate, HOLD + REST)
