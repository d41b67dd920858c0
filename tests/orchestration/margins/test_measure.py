"""Margins of loops whose transfer functions are known, and the reasons where a loop has none."""

import re

import control
import numpy as np
import pytest

from orchestration.margins.analysis import disk_margin, margins
from orchestration.margins.measure import measure

from .loops import STEP, law, linear, rig

# A double integrator with a lag before it, sampled each STEP; the law is proportional and derivative on exact states.
LAG = 0.8
A = np.array([[1, STEP, STEP**2 / 2], [0, 1, STEP], [0, 0, LAG]])
B = np.array([[0], [0], [1 - LAG]])
GAINS = np.array([0.5, 1.2, 0.0])


def lagging():
    return [linear(A, B, np.eye(3)), law(lambda y: -GAINS @ y, 3)]


def test_margins_of_a_known_loop_agree_with_python_control():
    response = measure(rig(lagging))
    assert response.refused == ""
    found = margins(response.omega, response.loops[:, 0])
    exact = control.ss(A, B, GAINS[None, :], 0, STEP)
    gain, phase, _, at_gain, at_phase, _ = control.stability_margins(exact, method="frd")
    assert 20 * np.log10(found.gain_up.value / gain) == pytest.approx(0, abs=0.2)
    assert np.degrees(found.phase.value) == pytest.approx(phase, abs=1)
    assert (found.gain_up.omega, found.phase.omega) == pytest.approx((at_gain, at_phase), rel=0.01)
    assert found.delay.value == pytest.approx(np.radians(phase) / at_phase, rel=0.01)
    fine = np.geomspace(0.01, np.pi / STEP, 1000)
    alpha = control.disk_margins(exact, fine)[0]
    assert found.disk.value == pytest.approx(alpha, rel=0.01)


def test_the_response_is_that_of_the_open_loop_at_every_frequency():
    response = measure(rig(lagging))
    exact = control.ss(A, B, GAINS[None, :], 0, STEP)(np.exp(1j * response.omega * STEP))
    np.testing.assert_allclose(response.S[:, 0, 0], 1 / (1 + exact), atol=3e-3)


def test_pulses_and_a_multisine_have_the_same_margins():
    """The witness injects 60 sines with phases of least peak (Schroeder) over six windows, and takes the last one."""
    loop, n = rig(lagging), 512
    lines = np.unique(np.geomspace(1, n // 2 - 1, 60).astype(int))
    count, k = np.arange(6 * n), np.arange(len(lines))
    sines = np.cos(2 * np.pi * np.outer(count, lines) / n - np.pi * k * (k - 1) / len(lines)).sum(axis=1)[:, None]
    came = loop.fly(1e-3 * loop.scales * sines) - loop.fly(np.zeros_like(sines))
    d, v = (np.fft.rfft(one[-n:, 0])[lines] for one in (1e-3 * loop.scales * sines, came))
    omega, L = 2 * np.pi * lines / n / STEP, -(v / d) / (1 + v / d)
    response = measure(rig(lagging))
    found, witness = margins(response.omega, response.loops[:, 0]), margins(omega, L)
    assert 20 * np.log10(found.gain_up.value / witness.gain_up.value) == pytest.approx(0, abs=0.2)
    assert np.degrees(found.phase.value - witness.phase.value) == pytest.approx(0, abs=1)


def test_a_slow_loop_whose_answers_grow_at_first_has_its_margins():
    """Behind a lag of 20 s the answer to a pulse is 300 times as large after 25 s as at first."""
    slow, lag = np.array([4e-4, 0.028, 0.0]), 0.995
    plant = np.array([[1, STEP, STEP**2 / 2], [0, 1, STEP], [0, 0, lag]])
    drive = np.array([[0], [0], [1 - lag]])
    response = measure(rig(lambda: [linear(plant, drive, np.eye(3)), law(lambda y: -slow @ y, 3)]))
    assert response.refused == ""
    found = margins(response.omega, response.loops[:, 0])
    gain, phase, *_ = control.stability_margins(control.ss(plant, drive, slow[None, :], 0, STEP), method="frd")
    assert 20 * np.log10(found.gain_up.value / gain) == pytest.approx(0, abs=0.2)
    assert np.degrees(found.phase.value) == pytest.approx(phase, abs=1)


def test_a_slow_law_is_measured_at_its_own_samples():
    response = measure(rig(lagging, law={"every": 3}))
    held = np.linalg.matrix_power(A, 3), sum(np.linalg.matrix_power(A, k) @ B for k in range(3))
    exact = control.ss(*held, GAINS[None, :], 0, 3 * STEP)(np.exp(1j * response.omega * 3 * STEP))
    assert response.step == pytest.approx(3 * STEP)
    np.testing.assert_allclose(response.S[:, 0, 0], 1 / (1 + exact), atol=3e-3)


def test_channels_that_are_sound_alone_may_be_weak_together():
    """The spinning satellite of Zhou and Doyle (Essentials of Robust Control, 8.2), sampled: each loop alone is 1/s."""
    a = 5.0
    continuous = control.ss([[0, a], [-a, 0]], np.eye(2), [[1, a], [-a, 1]], np.zeros((2, 2)))
    plant = control.sample_system(continuous, 0.02)
    response = measure(rig(lambda: [linear(plant.A, plant.B, plant.C), law(lambda y: -y, 2, 2)]))
    assert response.refused == ""
    z = np.exp(1j * response.omega * STEP)  # a mock steps whatever the length
    sensitivity = np.linalg.inv(np.eye(2) + np.moveaxis(plant(z), 2, 0))
    np.testing.assert_allclose(response.S, sensitivity, atol=0.06)
    alone = [margins(response.omega, response.loops[:, i]).disk.value for i in (0, 1)]
    together = disk_margin(response.omega, response.S).value
    exact = disk_margin(response.omega, sensitivity).value
    assert together == pytest.approx(exact, rel=0.02)
    assert min(alone) > 4 * together
    # Gains are among the factors that the margin allows, so none within it makes the loop unstable.
    low, high = (2 - together) / (2 + together), (2 + together) / (2 - together)
    for gains in ((low, high), (high, low), (high, high), (low, low)):
        assert np.abs(np.linalg.eigvals(plant.A - plant.B @ np.diag(gains) @ plant.C)).max() < 1


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (lambda y: np.clip(-GAINS @ y - 5.0, -1e-9, 1e-9) + 0 * y[:1], "open here, saturated"),
        (lambda y: np.sign(-GAINS @ y), "switches|limit cycle"),
        (lambda y: -GAINS @ np.round(y, 3), "not linear|limit cycle|not died out"),
        (lambda y: +GAINS @ y, "unstable"),
        (lambda y: -GAINS @ y + np.random.default_rng().normal(0, 0.1), "noise"),
    ],
    ids=["saturated", "switching", "quantized", "unstable", "noise without a seed"],
)
def test_a_loop_without_margins_gives_the_reason_and_no_number(function, reason):
    response = measure(rig(lambda: [linear(A, B, np.eye(3)), law(function, 3)]), longest=1024)
    assert response.refused
    assert re.search(reason, response.refused), response.refused


def test_a_loop_that_repeats_has_no_margins_of_a_moment():
    def make():
        count = [0]

        def function(y):
            count[0] += 1
            return -GAINS @ y * (1.0 + 0.9 * np.sin(count[0] / 7))

        return [linear(A, B, np.eye(3)), law(function, 3)]

    response = measure(rig(make))
    assert re.search("varies with time or repeats", response.refused), response.refused


def test_noise_of_a_fixed_seed_cancels():
    def make():
        noise = np.random.default_rng(1)
        return [linear(A, B, np.eye(3)), law(lambda y: -GAINS @ y + noise.normal(0, 0.1), 3)]

    response = measure(rig(make))
    exact = control.ss(A, B, GAINS[None, :], 0, STEP)(np.exp(1j * response.omega * STEP))
    np.testing.assert_allclose(response.S[:, 0, 0], 1 / (1 + exact), atol=3e-3)


def test_a_bend_of_the_law_is_measured_at_an_amplitude_at_which_it_is_straight():
    bent = lambda y: np.tanh(-50 * GAINS @ y) / 50  # noqa: E731
    response = measure(rig(lambda: [linear(A, B, np.eye(3)), law(bent, 3)], first=400))
    exact = control.ss(A, B, GAINS[None, :], 0, STEP)(np.exp(1j * response.omega * STEP))
    np.testing.assert_allclose(response.S[:, 0, 0], 1 / (1 + exact), atol=0.01)
    assert response.amplitude[0] < 0.02
