"""The numbers of the problem that docs/evidence/optimum.md states. Tests: tests/evidence/optimum/test_least_time.py."""

from __future__ import annotations

import math

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
INTERVAL, FINE = 5.0, 2.5
"""Longest interval of constant commands, s; where the check fails, the finer one."""
HELD, FEWEST = 12, 16
"""Intervals of HOLD, and least number of them before it."""
WIDE = 15
"""Least number of starts of a search."""
