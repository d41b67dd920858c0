"""The estimator behind the sensors of a tumbling plant, against the truth: `evidence.estimator.consistency` with few
runs.

Shows ES-2.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from evidence.estimator.consistency import FROM, bounds, errors, measured, tumble
from orchestration import run

DARK = 5
"""A run that starts in eclipse."""


@pytest.fixture(scope="module", params=[False, True], ids=["without a star tracker", "with a star tracker"])
def runs(request: pytest.FixtureRequest) -> list[dict[str, Any]]:
    return [measured((i, request.param)) for i in range(8)]


def test_errors_are_as_large_as_their_covariance_says(runs: list[dict[str, Any]]) -> None:
    late = runs[0]["time"] >= FROM
    low, high = bounds(6, len(runs))
    assert low < np.mean([r["nees"][late] for r in runs]) < high


def test_innovations_of_the_field_are_as_large_as_their_covariance_says(runs: list[dict[str, Any]]) -> None:
    late = runs[0]["time"] >= FROM
    assert np.mean([r["nis"][late][:, 0] for r in runs]) == pytest.approx(3.0, abs=0.2)


def flown(index: int, **changes: Any) -> tuple[Any, np.ndarray]:
    """A run with other parameters of the estimator, and its attitude error over time, deg."""
    data = tumble(index, tracker=False)
    data["blocks"]["estimator"]["start"] |= changes
    result = run(data)
    return result, np.degrees(np.linalg.norm(errors(result, np.zeros(3))[:, :3], axis=1))


def test_a_start_in_eclipse_waits_for_the_field_to_turn_and_not_for_the_sun() -> None:
    result, angle = flown(DARK)
    assert not result["plant.sunlight"][result.time <= 240.0].any()
    assert np.isnan(angle[0])
    assert angle[result.time == 240.0] < 5.0
    assert angle[-1] < 1.0


def test_without_a_gyro_the_rate_follows_the_equations_of_motion() -> None:
    _, angle = flown(0, rate_source="dynamics", rate_bias_sigma=0.02, momentum_random_walk=1e-6)
    assert angle[-1] < 0.5
