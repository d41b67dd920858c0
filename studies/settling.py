"""When errors stay within a tolerance."""

from __future__ import annotations

import math

import numpy as np

from .paper import Array


def settling_time(time: Array, outside: Array) -> float:
    """The first instant, s, from which on nothing is outside to the end; NaN where something is at the end.

    time (n,) s, outside (n,) flags.
    """
    last = np.flatnonzero(outside)
    if not len(last):
        return float(time[0])
    return math.nan if last[-1] + 1 == len(time) else float(time[last[-1] + 1])
