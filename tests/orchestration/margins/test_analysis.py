"""Margins from frequency responses in closed form."""

import numpy as np
import pytest

from orchestration.margins.analysis import alike, disk, disk_margin, margins, structured

OMEGA = np.geomspace(0.01, 100, 120)


def test_three_equal_lags_have_the_margins_of_the_closed_form():
    k = 4.0
    found = margins(OMEGA, k / (1 + 1j * OMEGA) ** 3)
    crossover = np.sqrt(k ** (2 / 3) - 1)
    phase = np.pi - 3 * np.arctan(crossover)
    assert (found.gain_up.value, found.gain_up.omega) == pytest.approx((8 / k, np.sqrt(3)), rel=1e-4)
    assert (found.phase.value, found.phase.omega) == pytest.approx((phase, crossover), rel=1e-4)
    assert found.delay.value == pytest.approx(phase / crossover, rel=1e-4)
    assert found.gain_down.value == 0.0


def test_a_loop_that_needs_its_gain_has_a_margin_downwards():
    """L = k (s + 1)/s^2 ... with an unstable pole: k/(s - 1) is stable closed for k > 1."""
    found = margins(OMEGA, 3.0 / (1j * OMEGA - 1))
    fine = np.geomspace(1e-4, 100, 300)
    assert margins(fine, 3.0 / (1j * fine - 1)).phase.omega == pytest.approx(np.sqrt(8), rel=1e-3)
    assert found.phase.value == pytest.approx(np.arccos(1 / 3), rel=1e-3)


def test_a_conditionally_stable_loop_has_gain_margins_on_both_sides():
    """L = k (s + 1)^2/s^3: its phase is -180 deg where 2 atan(w) = 90 deg, w = 1, there |L| = 2 k."""
    found = margins(OMEGA, 1.0 * (1j * OMEGA + 1) ** 2 / (1j * OMEGA) ** 3)
    assert (found.gain_down.value, found.gain_down.omega) == pytest.approx((0.5, 1.0), rel=1e-4)
    assert found.gain_up.value == np.inf


def test_the_disk_margin_of_an_integrator_is_whole():
    assert margins(OMEGA, 1 / (1j * OMEGA)).disk.value == pytest.approx(2.0, rel=1e-6)
    assert disk(2.0).high == np.inf
    assert disk(2.0).phase == pytest.approx(np.pi / 2)


def test_the_disk_margin_means_gains_and_phases():
    sure = disk(2 / 3)
    assert (sure.low, sure.high) == pytest.approx((0.5, 2.0))
    assert sure.phase == pytest.approx(2 * np.arctan(1 / 3))


def test_the_structured_value_of_a_ring_is_the_mean_of_its_gains(rng):
    assert structured(np.array([[0, 8.0], [0.5j, 0]])) == pytest.approx(2.0, rel=1e-4)
    assert structured(np.array([[0, 20.0, 0], [0, 0, -0.1], [4.0j, 0, 0]])) == pytest.approx(2.0, rel=1e-3)
    diagonal = np.diag(rng.normal(size=3) + 1j * rng.normal(size=3))
    assert structured(diagonal) == pytest.approx(np.abs(diagonal).max())


def test_channels_without_coupling_have_the_least_disk_margin_of_them():
    L = np.stack([2.0 / (1 + 1j * OMEGA) ** 3, 4.0 / (1 + 1j * OMEGA) ** 3], axis=1)
    S = 1 / (1 + L)
    alone = margins(OMEGA, L[:, 1]).disk
    together = disk_margin(OMEGA, S[:, :, None] * np.eye(2))
    assert together.value == pytest.approx(alone.value, rel=1e-6)


def test_a_channel_without_gain_has_no_margin_and_leaves_those_of_the_others():
    """The place of a wheel that is not there; an integrator has a phase margin of 90 deg."""
    omega = np.logspace(-3, 0, 200)
    L = np.zeros((200, 2, 2), complex)
    L[:, 0, 0] = 0.1 / (1j * omega)
    found = alike(omega, L)
    assert found.phase.value == pytest.approx(np.pi / 2)
    assert found.phase.omega == pytest.approx(0.1)
    assert found.gain_up.value == np.inf
