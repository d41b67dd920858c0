"""Failures behind an estimator, whose attitude is off by degrees for minutes: they are found, and sound parts are
not blamed.

Shows PL-1.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from .test_failures import FAILED, failing
from .test_identification import DT, Tumbles, estimated, flown

SIGMA = np.full(3, 0.05)
TUMBLES = 2
NO_TARGET = {"R_ref": np.zeros((3, 3)), "Omega_ref": np.zeros(3), "dOmega_ref": np.zeros(3)}
"""Nothing is planned, which takes the time."""


def off(sigma=SIGMA):
    """An attitude that is wrong by up to 3 deg, a little more or less each minute, as that of a filter which converges;
    where a deviation is given it is connected."""

    def spoil(i, sample):
        error = 0.05 * np.array([np.sin(0.05 * i), np.cos(0.04 * i), np.sin(0.03 * i + 1.0)])
        said = {} if sigma is None else {"attitude_sigma_B": np.tile(sigma, (len(sample["R_NB"]), 1))}
        return sample | {"R_NB": sample["R_NB"] @ Rotation.from_rotvec(error).as_matrix(), **said}

    return spoil


def without_bias(truth):
    truth.bias[:] = 0.0
    return truth


def test_failed_rods_are_named_on_an_estimated_attitude():
    found = flown(without_bias(failing()), off(), **NO_TARGET)[1]
    assert [int(y["failed_rod"]) for y in found[:4]] == FAILED


def test_sound_rods_are_learned_on_an_estimated_attitude_and_blamed_without_its_deviation():
    truth = without_bias(Tumbles(4, TUMBLES))
    found = flown(truth, off(), **NO_TARGET)[1]
    assert not any(y["rod_failed"] for y in found)
    assert estimated(found, "rod_gains_estimate") == pytest.approx(truth.gains, abs=0.05)
    blind = flown(without_bias(Tumbles(4, TUMBLES)), off(None), **NO_TARGET)[1]
    assert np.abs(estimated(blind, "rod_gains_estimate") - truth.gains).max() > 0.2


def test_the_attitude_of_an_estimator_is_taken_as_it_is():
    record, found = flown(without_bias(Tumbles(5, 1)), off(), samples=6, reference="inertial")
    for k, y in enumerate(found):
        assert y["attitude_error"] == pytest.approx(Rotation.from_matrix(record[-1]["R_NB"][k]).magnitude(), abs=1e-12)
        assert not np.any(y["rate_bias_estimate_B"])


def test_nothing_is_learned_from_a_rate_that_the_estimator_has_without_its_gyro():
    """What it learned before stays: the gains of the start, of rods that have failed."""
    without = flown(without_bias(failing()), spoilt_without_gyro, **NO_TARGET)[1]
    assert not any(y["rod_failed"] for y in without)
    assert estimated(without, "rod_gains_estimate") == pytest.approx(1.0, abs=1e-12)


def spoilt_without_gyro(i, sample):
    return off()(i, sample) | {"rate_health": np.full(len(sample["R_NB"]), 2)}


@pytest.mark.parametrize(("sigma", "named"), [(0.05, [0] * 4), (0.01, FAILED)])
def test_no_rod_is_named_by_a_field_that_an_uncertain_attitude_turns(sigma, named):
    """Without its magnetometer an estimator gives the field of its model: good where its attitude is."""

    def spoil(i, sample):
        return off(np.full(3, sigma))(i, sample) | {"field_health": np.full(len(sample["R_NB"]), 3)}

    found = flown(without_bias(failing()), spoil, **NO_TARGET)[1]
    assert [int(y["failed_rod"]) for y in found[:4]] == named


def noise_of(h_w, rng):
    return h_w + 1e-5 * rng.normal(size=h_w.shape)


@pytest.mark.parametrize("until", [150, 260])
def test_a_momentum_that_is_frozen_is_counted_on_by_the_commands_and_used_again(until):
    """Frozen at 60 s, while 20 samples at least: until 75 s, and once more from 100 s."""
    rng, held = np.random.default_rng(5), {}

    def spoil(i, sample):
        noisy = noise_of(sample["h_w"], rng)
        begin = 200 if i >= 200 else 120
        frozen = 120 <= i < 150 or i >= 200
        return sample | {"h_w": held.setdefault(begin, noisy) if frozen else noisy}

    truth = without_bias(Tumbles(4, 1))
    y = flown(truth, spoil, samples=until - 1, **NO_TARGET)[1][0]
    assert y["h_w_frozen"]
    assert not y["wheel_failed"]
    assert not y["rod_failed"]
    assert y["h_w_estimate"] == pytest.approx(truth.h_w[0], abs=1e-4)
    assert abs(held[200 if until > 200 else 120][0] - truth.h_w[0]) > 2e-4, "what is measured would not do"
    after = flown(without_bias(Tumbles(4, 1)), spoil, samples=190, **NO_TARGET)[1][0]
    assert not after["h_w_frozen"]


def test_a_momentum_that_freezes_before_the_first_attitude_is_counted_on():
    rng, held = np.random.default_rng(6), {}

    def spoil(i, sample):
        noisy = noise_of(sample["h_w"], rng)
        known = np.array([i >= 90] * len(noisy))[:, None, None]
        return sample | {"R_NB": known * sample["R_NB"], "h_w": held.setdefault(1, noisy) if i >= 50 else noisy}

    truth = without_bias(Tumbles(4, 1))
    y = flown(truth, spoil, samples=110, **NO_TARGET)[1][0]
    assert y["h_w_frozen"]
    assert y["h_w_estimate"] == pytest.approx(truth.h_w[0], abs=1e-4)
    assert abs(held[1][0] - truth.h_w[0]) > 2e-4, "what is measured would not do"


class StuckOn(Tumbles):
    """Rod 1 gives a fifth of its dipole whatever is commanded."""

    def fly(self, steps=4):
        asked, self.gains = self.u, np.ones((self.n, 3))
        self.u = np.column_stack((np.full(self.n, 0.2), asked[:, 1:]))
        super().fly(steps)
        self.u = asked


def test_a_rod_that_is_stuck_on_is_named_and_its_dipole_known():
    for y in flown(without_bias(StuckOn(8, 2)), off(), **NO_TARGET)[1]:
        assert y["failed_rod"] == 1
        assert y["residual_dipole_estimate_B"] == pytest.approx(0.2 * 25.0 * np.array([1, 1, -1]) / 3**0.5, abs=0.8)


class Sticks(Tumbles):
    """The wheel gets a hundredth of its torque, and stands still for a while; its momentum has noise."""

    stuck = (40.0, 240.0)

    def command(self):
        super().command()
        self.asked = 0.01 * self.dl
        held = self.stuck[0] <= self.t < self.stuck[1]
        self.dl = np.zeros(self.n) if held else self.asked

    def friction(self):
        """What is asked for and not given."""
        return self.asked - self.dl


@pytest.mark.parametrize(("until", "failed"), [(235.0, True), (430.0, False)])
def test_a_stuck_wheel_shows_by_small_torques_and_is_used_again(until, failed):
    rng = np.random.default_rng(3)

    def noisy(i, sample):
        return sample | {"h_w": noise_of(sample["h_w"], rng)}

    y = flown(Sticks(7, 1), noisy, samples=int(until / DT), **NO_TARGET)[1][0]
    assert bool(y["wheel_failed"]) == failed
    assert not y["h_w_frozen"], "its noise goes on"
    assert not y["rod_failed"]
