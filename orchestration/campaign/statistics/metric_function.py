"""The metrics of a campaign as functions of points in the unit cube.

Tests: tests/orchestration/campaign/test_metric_function.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MetricFunction:
    """Metrics at points that a method chooses: it asks for them by `fly`, and for what a point means."""

    fly: Callable[[Floats], dict[str, Floats]]
    """Gives the metrics (n,) by name at points (n, dimension); nan where a run failed or gave none."""
    values: Callable[[Floats], dict[str, Any]]
    """Gives the start values at a point (dimension,) by name, as `--set` takes them."""
    scenario: Callable[[Floats], str]
    """Gives the scenario of a point as YAML."""
    entries: list[tuple[str, int, int]]
    """Name, first coordinate and count of coordinates of each varied entry."""
    coordinates: list[str]
    """A label for each coordinate."""
    bounded: list[bool]
    """By coordinate, whether its distribution has ends."""
    metrics: dict[str, str]
    """Units by metric."""
    reasons: dict[str, int]
    """How many runs failed up to now, by reason."""

    @property
    def dimension(self) -> int:
        """Returns how many coordinates a point has."""
        return len(self.coordinates)
