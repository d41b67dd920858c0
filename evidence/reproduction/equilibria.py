"""The rests of the law [8]: the goal and three half turns; docs/evidence/margins.md has the multipliers of each."""

from __future__ import annotations

import math

import numpy as np

from ..paper import ORBIT

ORBITAL_RATE = 2.0 * math.pi / ORBIT
SIGNS = np.array(((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)))
