"""The Earth's magnetic field by the model of the plant, for those that judge a block and import none.

Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from plant.geomagnetic import Field
from plant.orbit import earth_fixed
from plant.tables import field_model
from plant.time_scales import decimal_year, gmst, parse_epoch

Floats = NDArray[np.float64]
_MODEL, _DEGREE = "igrf14", 13


class EarthField:
    """IGRF-14 at an epoch. Raises ValueError where the epoch is no date."""

    def __init__(self, epoch: str) -> None:
        """`epoch` is UTC at t = 0, ISO 8601."""
        date = parse_epoch(epoch)
        self.year, self.gmst = decimal_year(date), gmst(date)
        """gmst in rad, at t = 0."""

    def at(
        self, time: Floats, r_N: Floats, turned: float = 0.0, year: float | None = None, degree: int = _DEGREE
    ) -> Floats:
        """Returns the field (n, 3), T, along N at times (n,), s, and places (n, 3), m.

        `turned`, rad, is how much farther east the Earth stands than at the epoch; `degree` 1 is its dipole.
        """
        g, h = field_model(_MODEL).at(self.year if year is None else year, extrapolate=True)
        model = Field(g, h, degree)
        frames = [earth_fixed(float(t), self.gmst + turned) for t in time]
        return np.array([to_N @ model.at(to_N.T @ r) for to_N, r in zip(frames, r_N, strict=True)])

    def axes(self, time: Floats) -> Floats:
        """Returns the matrices (n, 3, 3) from the Earth's axes to N."""
        return np.array([earth_fixed(float(t), self.gmst) for t in time])

    @property
    def zero_longitude(self) -> float:
        """Returns by how much the Earth is turned where its axes are those of N at t = 0, rad from -pi to pi."""
        return math.remainder(-self.gmst, 2 * math.pi)
