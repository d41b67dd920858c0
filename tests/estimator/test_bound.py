"""The bound on the attitude's error, under errors of the sensors that last: against the truth, and a closed form.

Shows ES-5.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import estimator
from estimator.health import INCONSISTENT
from estimator.lasting import SURE
from evidence.estimator.consistency import FROM, errors, tumble
from orchestration import run
from tests.blocks import parameters

from .test_estimator import LIT, seen_by

RUNS = 12


def iron(rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """Hard iron of 1 uT and soft iron of 2%, of which the filter knows nothing."""
    sensors = {
        "field_bias_B": (1e-6 * rng.normal(size=3)).tolist(),
        "field_scale": (0.02 * rng.normal(size=(3, 3))).tolist(),
    }
    return sensors, {"field_bias_sigma": 0.0, "lasting_field": 1e-6, "lasting_field_scale": 0.02, "lasting_sun": 0.0}


def estimated_iron(rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """The same where the filter estimates a bias of the field, and is told of more noise."""
    return iron(rng)[0], {"field_bias_sigma": 1e-6, "field_noise": 1e-6, "lasting_field": 0.0, "lasting_sun": 0.0}


def misaligned(rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """A star tracker that is 0.5 deg off about each axis."""
    turn = (math.radians(0.5) * rng.normal(size=3)).tolist()
    return {"attitude_bias_B": turn, "attitude_rate_max": 0.0}, {"lasting_attitude": math.radians(0.5)}


def cubesat(rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """Six photodiodes with the Earth's light on them, iron, and a gyro whose scale is 1% off."""
    sensors, stated = iron(rng)
    sensors |= {
        "sun_sensor": "coarse",
        "sun_sensor_noise": 0.02,
        "albedo": 0.3,
        "rate_scale": np.diag(0.01 * rng.normal(size=3)).tolist(),
    }
    return sensors, {**stated, "sun_noise": 0.1, "lasting_sun": 0.1, "lasting_rate_scale": 0.01}


def flown(index: int, spoilt: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle from the estimate to the truth, bound, root of the covariance's trace; from FROM on."""
    data = tumble(index, tracker=spoilt is misaligned)
    sensors, stated = spoilt(np.random.default_rng((50, index)))
    data["blocks"]["sensors"]["start"] |= sensors
    data["blocks"]["estimator"]["start"] |= stated
    data["record"]["signals"] += ["estimator.attitude_bound"]
    result = run(data)
    late = result.time >= FROM
    angle = np.linalg.norm(errors(result, np.zeros(3))[late, :3], axis=1)
    sigma = np.linalg.norm(result["estimator.attitude_sigma_B"][late], axis=1)
    return angle, result["estimator.attitude_bound"][late], sigma


@pytest.mark.parametrize("spoilt", [iron, estimated_iron, misaligned, cubesat])
def test_the_error_is_below_its_bound_where_the_covariance_alone_is_too_small(spoilt: Any) -> None:
    """Of runs at errors that are drawn at the deviations that are stated, 1% may be beyond; the mean square over that
    of the bound is near 1, so it is not wide either."""
    runs = zip(*(flown(i, spoilt) for i in range(RUNS)), strict=True)
    angle, bound, sigma = (np.concatenate(part) for part in runs)
    assert np.mean(angle < bound) >= 0.99
    assert 0.2 < np.mean((SURE * angle / bound) ** 2) < 1.5
    assert np.mean((angle / sigma) ** 2) > 3.0


@pytest.mark.parametrize("index", [0, 4])
def test_the_sun_brings_back_an_attitude_that_a_drifting_magnetometer_has_turned_and_the_bound_holds(
    index: int,
) -> None:
    """12 uT in 600 s, believed until its strength shows it: by then it has turned attitude and gyro bias together."""
    data = tumble(index, tracker=False, duration=1500.0)
    white = {"angle_random_walk": 3.5e-4}
    data["blocks"]["sensors"]["start"] |= white
    stated = {"rate_random_walk": 2e-6, "rate_bias_sigma": 5e-3, "field_bias_sigma": 3e-7, "field_noise": 1e-6}
    data["blocks"]["estimator"]["start"] |= white | stated
    data["faults"] = [
        {"at": 300.0 + 50.0 * k, "bias": "sensors.b_B_measured", "by": [6e-7 * (k + 1)] * 3}
        | ({"until": 350.0 + 50.0 * k} if k < 11 else {})
        for k in range(12)
    ]
    data["record"]["signals"] += ["estimator.attitude_bound", "estimator.health"]
    result = run(data)
    out = result["estimator.health"][:, 1] == INCONSISTENT
    angle = np.linalg.norm(errors(result, np.zeros(3))[out, :3], axis=1)
    assert angle[0] > math.radians(5.0)
    assert np.median(angle) < 0.5 * angle[0]
    assert np.all(angle < result["estimator.attitude_bound"][out])


@pytest.mark.parametrize("off", [0.0, 0.01])
def test_a_star_tracker_alone_leaves_all_of_its_misalignment_in_the_bound(off: float) -> None:
    """The filter follows it, whatever its gain: the bound's square is that of the covariance and of three turns."""
    p = parameters("estimator", epoch=LIT, lasting_attitude=off)
    u = replace(seen_by(np.eye(3), p, R_NB_measured=np.eye(3)), b_B_measured=np.zeros(3), sun_B_measured=np.zeros(3))
    x = estimator.start(p, u)
    for _ in range(20):
        x, y = estimator.step(x, u, p, 1.0)
    expected = SURE * math.sqrt(float(np.trace(y.covariance[:3, :3])) + 3.0 * off * off)
    assert y.attitude_bound == pytest.approx(expected, rel=1e-3)


def test_without_an_attitude_there_is_no_bound_below_half_a_turn() -> None:
    p = parameters("estimator")
    u = replace(seen_by(np.eye(3), p), r_N_measured=np.zeros(3))
    assert estimator.outputs(estimator.start(p, u), u, p).attitude_bound == math.pi
