"""Ratios of inertia are found from free motion of a known body, and the forecast keeps momentum and energy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from inflight.nutation import Inertia, Motion, forecast, identify, inertia, starting

TRUE = np.array([np.log(0.93), np.log(0.3), 0.05, -0.03, 0.08, 0.004, -0.002, 0.003])


def tumbling(seed, spin, seconds=200):
    rng = np.random.default_rng(seed)
    J = inertia(TRUE)
    start = np.array([0.06 * rng.normal(), spin, 0.06 * rng.normal()])
    t = np.arange(float(seconds))
    right = lambda _, w: np.linalg.solve(J, np.cross(J @ w, w))  # noqa: E731
    w = solve_ivp(right, (0.0, seconds), start, t_eval=t, rtol=1e-11, atol=1e-13).y.T
    return Motion(str(seed), t, w + TRUE[5:8] + 1.6e-3 * rng.normal(size=w.shape)), w + TRUE[5:8]


@pytest.fixture(scope="module")
def found():
    motions = [tumbling(seed, spin)[0] for seed, spin in enumerate((0.6, 0.8, 1.0))]
    return identify([m.until(60.0) for m in motions])


def test_the_ratios_are_found_within_their_deviations(found):
    off = (found.ratios - np.exp(TRUE[:2])) / found.ratio_sigma
    assert np.abs(off).max() < 3.5, (found.ratios, found.ratio_sigma)
    assert found.rms == pytest.approx(1.6e-3, rel=0.1)


def test_the_forecast_of_another_record_is_within_the_noise(found):
    motion, true = tumbling(9, 0.9)
    ahead = forecast(motion, found, starting(motion.until(60.0), found))
    assert np.sqrt(np.mean((ahead - true)[60:] ** 2)) < 0.6e-3


def test_the_forecast_is_the_plants_motion_of_a_known_body():
    motion, true = tumbling(4, 0.7, 100)
    known = Inertia(TRUE, np.eye(8), np.zeros((1, 3)), 0.0, 0.0)
    np.testing.assert_allclose(forecast(motion, known, (true - TRUE[5:8])[0]), true, atol=2e-5)
