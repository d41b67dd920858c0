"""The calibration finds what a synthetic magnetometer was given, within its own deviations, and says what a record
cannot show."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from evidence.flight_data.synthetic import BIAS, A, spinning
from inflight import magnetometer
from inflight.magnetometer import calibrate, symmetric


@pytest.fixture(scope="module")
def flown():
    flight, _, B, _ = spinning(3, 5400, calibrated=False)
    return flight, np.linalg.norm(B, axis=1)


def test_bias_scale_and_misalignment_are_found_through_a_drifting_gain(flown):
    flight, size = flown
    found = calibrate(flight.t, flight.m, size)
    drift = 1.0 + 0.02 * np.sin(2.0 * np.pi * flight.t / 3000.0)
    mean = np.interp(flight.t, found.knots, found.gain) / drift
    assert np.ptp(mean) < 0.03
    assert found.rms < 5e-7
    level = mean.mean()
    np.testing.assert_allclose(found.bias / level, BIAS, atol=1e-6)
    np.testing.assert_allclose(found.A * level, A, atol=0.035)  # A12, along the spin, is the least known
    assert calibrate(flight.t, flight.m, size, interval=1e9).rms > 2.0 * found.rms


def test_the_other_half_of_a_record_is_calibrated_by_the_first(flown):
    flight, size = flown
    first = calibrate(flight.t[:2700], flight.m[:2700], size[:2700])
    second = calibrate(flight.t[2700:], flight.m[2700:], size[2700:], known=first)
    assert second.rms < 6e-7


def test_a_record_without_motion_shows_little_and_says_so(flown):
    flight, size = flown
    found = calibrate(flight.t[:20], np.tile(flight.m[:1], (20, 1)), size[:20])
    assert "shown" not in set(found.verdict().values())


def test_the_derivatives_are_those_of_differences():
    rng = np.random.default_rng(0)
    m, size, H = rng.normal(size=(4, 3)), rng.uniform(1, 2, 4), rng.uniform(0, 1, (4, 2))
    x = np.array([1.1, 0.1, -0.1, 0.9, 0.05, 1.0, 0.3, -0.2, 0.1, 1.0, 1.1, *np.linspace(-0.2, 0.3, 6)])
    _, J = magnetometer._residual(x, m, size, H)
    wanted = approx_fprime(x, lambda x: magnetometer._residual(x, m, size, H)[0], 1e-7)
    np.testing.assert_allclose(J, wanted, atol=1e-5)


def test_the_symmetric_form_has_the_same_sizes(flown):
    flight, size = flown
    found = calibrate(flight.t, flight.m, size)
    turned = symmetric(found)
    np.testing.assert_allclose(turned.A, turned.A.T, atol=1e-12)
    sizes = [np.linalg.norm(c.field(flight.t, flight.m), axis=1) for c in (found, turned)]
    np.testing.assert_allclose(*sizes, rtol=1e-12)
