"""A metric of campaigns that looks at two signals at once. Tests: tests/evidence/allocators/test_allocators.py."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.paper import ATTITUDE_TOLERANCE, DURATION, RATE_TOLERANCE, STEP

END = math.ceil(DURATION / STEP) * STEP
"""The last sample of the manoeuvre, s."""


def out(time: Any, signals: Mapping[str, Any]) -> float:
    """The share of the samples after the manoeuvre at which an error is out of tolerance; time (n,) s."""
    rate = np.linalg.norm(signals["judge.rate_error_B"], axis=1)
    outside = (signals["judge.attitude_error"] >= ATTITUDE_TOLERANCE) | (rate >= RATE_TOLERANCE)
    return float(outside[time > END + 0.5 * STEP].mean())
