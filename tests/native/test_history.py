"""States that last, each reached twice in both flavours: the first time does not change the second.

Each test is a state with the inputs that lead there, leave it and come back, and what is seen in each stage.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimator.health import GOOD, INCONSISTENT
from tests.blocks import inputs, parameters
from tests.estimator.test_estimator import LIT, seen_by

from .twice import FLAVOURS

H = 1e-3
DARK = np.zeros(3)
R = Rotation.random(random_state=7).as_matrix()


@pytest.fixture
def estimator_() -> tuple[Any, Any, Any]:
    p = parameters("estimator", epoch=LIT)
    good = seen_by(R, p)
    return p, good, replace(good, b_B_measured=-good.b_B_measured, sun_B_measured=DARK)


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_only_rejections_in_a_row_end_the_filter_and_it_starts_again_as_often_as_it_is_lost(flavour, estimator_):
    """30 wrong fields and 30 right ones in turn leave it; 50 wrong ones in a row end it, the first time and later. Each
    time it starts with as much uncertainty, and becomes as certain."""
    p, good, wrong = estimator_
    with flavour("estimator", p, good, H) as step:
        starts = [[step(good)["attitude_sigma_B"] for _ in range(20)]]
        rejected = 0
        for _ in range(2):
            for _ in range(3):
                for _ in range(30):
                    assert step(wrong)["attitude_valid"]
                rejected += 30
                for _ in range(30):
                    y = step(good)
                assert y["attitude_valid"]
                assert y["rejected"].tolist() == [rejected, 0, 0]
            for _ in range(50):
                y = step(wrong)
            rejected += 50
            assert not y["attitude_valid"]
            assert y["rejected"].tolist() == [rejected, 0, 0]
            y = step(good)
            starts.append([y["attitude_sigma_B"], *(step(good)["attitude_sigma_B"] for _ in range(19))])
            assert y["attitude_valid"]
            assert y["R_NB"] == pytest.approx(R, abs=1e-3)
            assert y["health"][0] == (GOOD if len(starts) == 2 else INCONSISTENT), "lost twice in 600 s by its gyro"
        for later in starts[1:]:  # the first one began before its first step
            np.testing.assert_allclose(later[1:], starts[0][:-1], rtol=0.03)


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_only_wrong_fields_in_a_row_clear_the_bank_each_time(flavour):
    """30 of them and one right one in turn leave it; 50 in a row clear it."""
    p = parameters("estimator", bank=True, epoch=LIT, field_noise=1e-8, rate_bias_sigma=1e-6, rate_scale_sigma=0.0)
    good = seen_by(R, p)
    B = good.b_B_measured
    wrong = replace(good, b_B_measured=np.array((B[1], -B[0], B[2])), sun_B_measured=DARK)
    with flavour("estimator", p, good, H) as step:
        for _ in range(2):
            for _ in range(60):
                y = step(good)
            assert y["attitude_valid"]
            for _ in range(3):
                for _ in range(30):
                    assert step(wrong)["attitude_valid"]
                y = step(good)
            assert y["attitude_valid"]
            for _ in range(50):
                y = step(wrong)
            assert not y["attitude_valid"]


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_a_sun_sensor_sees_nothing_in_each_shadow_and_the_sun_after_it(flavour):
    for kind in ("fine", "coarse"):
        p = parameters("plant_sensors", sun_sensor=kind, fine_sun_axis_B=[0.0, 0.0, 1.0], fine_sun_half_angle=1.0)
        lit = inputs("plant_sensors", R_NB=np.eye(3), r_N=[7e6, 0.0, 0.0], sun_N=[0.28, 0.0, 0.96], sunlight=1.0)
        with flavour("plant_sensors", p, lit, H) as step:
            for sunlight in (1.0, 0.0, 0.0, 1.0, 0.0, 1.0):
                y = step(replace(lit, sunlight=sunlight))
                assert y["sun_B_measured"] == pytest.approx(sunlight * np.array(lit.sun_N), abs=1e-12), (kind, sunlight)
                assert bool(y["sun_sensors"].any()) == bool(sunlight)


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_a_drop_out_of_position_is_bridged_from_the_last_sample_each_time(flavour, estimator_):
    p, good, _ = estimator_
    lost = replace(good, r_N_measured=DARK, v_N_measured=DARK)
    with flavour("estimator", p, good, H) as step:
        for _ in range(2):
            at = step(good)["r_N"]
            for count in range(1, 6):
                moved = step(lost)["r_N"] - at
                assert np.linalg.norm(moved - count * H * good.v_N_measured) < 1e-3, count
