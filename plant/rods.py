"""The torquer rods: what each gives of its command, and when they are on.

Departures from the paper, whose rods give what is commanded, always: # not in the paper: gain and turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .so3 import Array

SNAP = 1e-6
"""Of a period: a time this near to a switching instant counts as that instant, so that the rounding of a long sum of
steps cuts no slivers."""


@dataclass(frozen=True)
class Turns:
    """On from k period to (k + duty) period, k = 0, 1, ..., and off until the next period begins.

    period s, 0: always on; duty in [0, 1].
    """

    period: float
    duty: float

    def on(self, t: float) -> bool:
        """Returns whether the rods are on at time t, s, and for a while from then on."""
        return self._stage(t) % 2 == 0

    def parts(self, t: float, h: float) -> list[tuple[float, bool]]:
        """[t, t + h] divided at the switching instants: durations, s, and whether the rods are on."""
        parts: list[tuple[float, bool]] = []
        left, stage = h, self._stage(t)
        while (duration := self._end(stage) - t) < left - SNAP * self.period:
            if duration > 0.0:
                parts.append((duration, stage % 2 == 0))
                left -= duration
                t += duration
            stage += 1
        return [*parts, (left, stage % 2 == 0)]

    def _stage(self, t: float) -> int:
        """2k in the first share of period k, 2k + 1 in its rest."""
        if self._steady:
            return 0 if self.period == 0.0 or self.duty > 0.0 else 1
        periods = t / self.period
        k = math.floor(periods + SNAP)
        return 2 * k if periods - k < self.duty - SNAP else 2 * k + 1

    def _end(self, stage: int) -> float:
        """Returns when the stage ends, s."""
        if self._steady:
            return math.inf
        k, rest = divmod(stage, 2)
        return (k + (1.0 if rest else self.duty)) * self.period

    @property
    def _steady(self) -> bool:
        return self.period == 0.0 or self.duty in (0.0, 1.0)


def dipoles(command: Array, limit: Array, gain: Array, on: bool) -> Array:
    """The dipoles (3,) A m2 along the rods: gain (3,) times the command within +-limit (3,); none while they are
    off."""
    return gain * np.minimum(np.maximum(command, -limit), limit) if on else np.zeros(3)
