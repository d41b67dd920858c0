"""Biases that jump, against the truth: the estimate follows them, and says so; both flavours alike.

Shows ES-4.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estimator.health import BLANK, FROZEN, GOOD, JUMPED, jumped, noticed
from tests.estimator.test_health import AT, BIAS, RATE, angle, assert_both_alike, estimates, measured

JUMPS = {"omega_B_measured": np.full(3, 5e-3), "b_B_measured": np.full(3, 7e-6)}
SENSOR = {"omega_B_measured": 0, "b_B_measured": 1}


def flight(name: str, wheel: bool = True, until: int = 400) -> list[Any]:
    """Field, gyro and Sun; from AT on one of them has a bias."""
    us = [replace(u, wheel_torque=0.0) if wheel else u for _, _, u in measured(False)]
    return [replace(u, **{name: getattr(u, name) + JUMPS[name]}) if AT <= k < until else u for k, u in enumerate(us)]


@pytest.mark.parametrize("name", JUMPS)
def test_a_bias_that_jumps_is_named_at_its_first_measurement_and_the_attitude_stays(name: str) -> None:
    ys = estimates(flight(name))
    assert ys[AT - 2].health[SENSOR[name]] == GOOD
    assert [y.health[SENSOR[name]] for y in ys[AT - 1 :]] == [JUMPED] * len(ys[AT - 1 :])
    assert max(angle(y, R) for y, (R, _, _) in zip(ys[AT:], measured(False)[AT + 1 :], strict=True)) < 0.5
    if name == "omega_B_measured":
        assert ys[-1].rate_bias_B == pytest.approx(BIAS + JUMPS[name], abs=1e-4)
        assert ys[-1].omega_B == pytest.approx(RATE, abs=2e-4)
    else:
        assert ys[-1].field_bias_B == pytest.approx(JUMPS[name], abs=3e-7)


@pytest.mark.parametrize("name", JUMPS)
def test_a_bias_that_goes_again_is_followed_back(name: str) -> None:
    ys = estimates(flight(name, until=200))
    assert max(angle(y, R) for y, (R, _, _) in zip(ys[AT:], measured(False)[AT + 1 :], strict=True)) < 0.5
    assert ys[-1].rate_bias_B == pytest.approx(BIAS, abs=2e-4)
    assert ys[-1].field_bias_B == pytest.approx(np.zeros(3), abs=4e-7)


def test_a_gyro_is_not_judged_where_nothing_says_what_the_wheel_gives() -> None:
    ys = estimates(flight("omega_B_measured", wheel=False))
    assert ys[AT].health[0] == GOOD


def test_a_sensor_that_freezes_far_from_its_last_value_keeps_the_bias_that_it_had() -> None:
    us = [replace(u, wheel_torque=0.0) for _, _, u in measured(False)]
    stuck = us[AT].omega_B_measured + 0.01
    ys = estimates([replace(u, omega_B_measured=stuck) if k >= AT else u for k, u in enumerate(us)])
    assert ys[AT].health[0] == JUMPED
    assert ys[-1].health[0] == FROZEN
    assert ys[-1].rate_bias_B == pytest.approx(BIAS, abs=2e-4)
    assert ys[-1].omega_B == pytest.approx(RATE, abs=1e-3)


def test_noise_never_jumps_and_a_jump_is_eight_times_what_is_usual() -> None:
    """White noise: a vector 13.9 deviations long has the probability of chi-square with 3 degrees at 192, 2e-41."""
    rng, w = np.random.default_rng(2), replace(BLANK, since=0.5)
    for _ in range(20000):
        v = rng.normal(size=3)
        w, jumps = jumped(noticed(w, v, every=False), v, 0.0)
        assert not jumps or w.usual < 0.5
    usual = w.usual
    assert usual == pytest.approx(3.0, rel=0.5)
    assert not jumped(w, np.array((7.9 * np.sqrt(usual), 0.0, 0.0)), 0.0)[1]
    assert not jumped(w, np.array((8.1 * np.sqrt(usual), 0.0, 0.0)), 1000.0)[1]
    assert jumped(w, np.array((8.1 * np.sqrt(usual), 0.0, 0.0)), 0.0)[1]


@pytest.mark.parametrize("name", JUMPS)
def test_both_flavours_follow_a_jump_alike(name: str) -> None:
    us = flight(name, until=250)
    assert_both_alike(us, estimates(us))
