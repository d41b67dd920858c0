"""When an error stays below a limit for good, and how large it is from then on.

Tests: tests/orchestration/results/test_settling.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Settling(NamedTuple):
    """Settling of an error that is held against a limit."""

    below: float
    time: float | None
    """From which it stays below to the end; None where it does not at the end."""
    rms: float
    """From then on; nan where it does not settle."""
    largest: float


def settling(time: NDArray[np.float64], error: NDArray[np.float64], below: float) -> Settling:
    """Returns how a recorded signal (n,), or the norm of one (n, ...), settles below a limit.

    The time is that of the first sample after which none is at the limit or above.
    """
    size = np.abs(error) if error.ndim == 1 else np.linalg.norm(error.reshape(len(error), -1), axis=1)
    above = np.flatnonzero(~(size < below))
    first = int(above[-1]) + 1 if len(above) else 0
    if first >= len(size):
        return Settling(below, None, np.nan, np.nan)
    rest = size[first:]
    return Settling(below, float(time[first]), float(np.sqrt(np.mean(rest**2))), float(rest.max()))
