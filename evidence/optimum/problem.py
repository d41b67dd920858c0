"""The numbers of the problem that docs/evidence/optimum.md states. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

ANGLE = math.radians(5.0)
"""Tolerance, rad; that of the rate is evidence/flight's."""
MARGIN = 0.97
"""Of both tolerances, for what the model leaves out."""
HOLD = 60.0
"""How long the tolerance is kept after T, s."""
REST, UNLOADED = 0.2, 0.87
"""At its end: the rate error is below this share of the tolerance, the wheel's momentum below this share of its
limit."""
DEGREE = 14
"""Of the Chebyshev series of the field."""
HELD = 12
"""Intervals of HOLD."""


@dataclass(frozen=True)
class Grid:
    """Intervals of constant commands before T: at most so long, s, and at least so many."""

    longest: float
    fewest: int
    guess: float = math.inf
    """T at which a search begins at most, s."""

    @property
    def finer(self) -> Grid:
        """Where the check fails."""
        return replace(self, longest=0.5 * self.longest, fewest=2 * self.fewest)


ONE_WHEEL, WHEELS = Grid(5.0, 16), Grid(10.0, 40, 150.0)
"""For satellites with one wheel, and with a set of them, whose turns take a minute."""
WIDE = 15
"""Least number of starts of a search."""
