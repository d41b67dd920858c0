"""Errors of pointing, against closed forms of Gaussian errors, SciPy's rotations and its chi distribution."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi

from design.review import budget
from plant.orbit import circular, lvlh

STEP, WINDOW, APART, P = 2.0, 60.0, 600.0, 0.95
N = round(WINDOW / STEP)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.7, np.pi - 1e-9, np.pi])
def test_rotation_vectors_are_those_of_scipy(angle):
    axis = np.array([0.48, -0.6, 0.64])
    Q = Rotation.from_rotvec(angle * axis).as_matrix()
    found = budget.rotation_vectors(Q[None])[0]
    assert np.linalg.norm(found) == pytest.approx(angle, rel=1e-9, abs=1e-15)
    assert np.cross(found, axis) == pytest.approx(np.zeros(3), abs=1e-7)  # at pi either sign is right


def test_the_error_to_lvlh_is_the_turn_from_the_desired_attitude():
    orbit = circular(6.9e6, 1.7, 0.3, 0.1, 3.986e14)
    r, v = orbit.position_velocity(700.0)
    R_d0 = Rotation.from_euler("zyx", [0.3, -0.2, 1.1]).as_matrix()
    turn = Rotation.from_rotvec([0.02, -0.01, 0.03])
    R = lvlh(r, v) @ R_d0 @ turn.as_matrix()
    Q = budget.to_lvlh(R[None], r[None], v[None], R_d0)
    assert budget.rotation_vectors(Q)[0] == pytest.approx(turn.as_rotvec(), abs=1e-12)


def _linear(rng, members, samples, bias, noise, a):
    """A linear system e' = a e + w of three axes, driven by white noise, stationary from the start, with a bias."""
    e = np.empty((members, samples, 3))
    e[:, 0] = noise / np.sqrt(1.0 - a * a) * rng.normal(size=(members, 3))
    for k in range(1, samples):
        e[:, k] = a * e[:, k - 1] + noise * rng.normal(size=(members, 3))
    return e + bias * rng.normal(size=(members, 1, 3))


def _mean_variance(a, noise):
    """Of the mean of N samples of a stationary first-order process, and of the difference of two such, APART on."""
    variance = noise**2 / (1.0 - a * a)
    lag = np.arange(N)
    among = (a ** np.abs(lag[:, None] - lag)).sum() / N**2
    later = round(APART / STEP)
    between = (a ** np.abs(lag[:, None] - lag - later)).sum() / N**2
    return variance * among, 2.0 * variance * (among - between)


def test_the_budget_of_a_linear_system_with_gaussian_errors_is_its_closed_form_to_two_per_cent():
    rng = np.random.default_rng(5)
    bias, noise, a = 2e-3, 1e-3, 0.9
    e = _linear(rng, 4000, 360, bias, noise, a)
    found = budget.of_flights(list(e), STEP, WINDOW, APART, P)
    factor = chi.ppf(P, 3)  # three like axes
    variance = noise**2 / (1.0 - a * a)
    mean, drift = _mean_variance(a, noise)
    assert found["absolute"].mixed == pytest.approx(factor * np.sqrt(bias**2 + variance), rel=0.02)
    assert found["mean"].mixed == pytest.approx(factor * np.sqrt(bias**2 + mean), rel=0.02)
    assert found["drift"].mixed == pytest.approx(factor * np.sqrt(drift), rel=0.02)
    # Samples within a window differ in variance by their place in it: the mean over them is variance - mean.
    within = np.concatenate([budget.sizes(one, STEP, WINDOW, APART)["relative"] for one in e[:500]])
    assert np.sqrt(np.mean(within**2)) == pytest.approx(np.sqrt(3.0 * (variance - mean)), rel=0.02)


def test_ensemble_and_temporal_statistics_of_constant_and_of_fleeting_errors():
    rng = np.random.default_rng(6)
    constant = [np.tile(2e-3 * rng.normal(size=3), (30, 1)) for _ in range(6000)]
    found = budget.of_flights(constant, STEP, WINDOW, APART, P)["absolute"]
    assert found.ensemble == pytest.approx(2e-3 * chi.ppf(P, 3), rel=0.02)  # the time adds nothing
    assert found.mixed == pytest.approx(found.ensemble, rel=1e-12)
    assert found.temporal == pytest.approx(max(np.linalg.norm(e[0]) for e in constant))
    fleeting = [1e-3 * rng.normal(size=(100_000, 3)) for _ in range(4)]
    found = budget.of_flights(fleeting, STEP, WINDOW, APART, P)["absolute"]
    assert found.temporal == pytest.approx(1e-3 * chi.ppf(P, 3), rel=0.02)  # the flights are alike


def test_the_root_of_the_sum_of_squares_is_what_independent_gaussian_errors_give_together():
    rng = np.random.default_rng(7)
    parts = [_linear(rng, 3000, 40, b, n, a) for b, n, a in ((2e-3, 1e-3, 0.9), (0.0, 2e-3, 0.5), (1e-3, 0.0, 0.0))]

    def absolute(e):
        return budget.of_flights(list(e), STEP, WINDOW, APART, P)["absolute"].mixed

    linear, root = budget.summed(0.0, [absolute(e) for e in parts])
    together = absolute(sum(parts))
    assert root == pytest.approx(together, rel=0.02)
    assert linear > 1.3 * together


def test_what_a_flight_has_without_errors_counts_once_in_a_sum():
    assert budget.summed(3.0, [5.0, 5.0]) == pytest.approx((7.0, np.sqrt(9.0 + 16.0 + 16.0)))


def test_a_flight_shorter_than_a_window_has_no_means():
    found = budget.of_flights([np.full((5, 3), 1e-3)], STEP, WINDOW, APART, P)
    assert found["absolute"].mixed == pytest.approx(1e-3 * np.sqrt(3.0))
    assert np.isnan(found["mean"].mixed)


def test_the_largest_of_59_flights_bounds_95_percent_with_95_percent_confidence():
    """The well-known number of Wilks, and what 20 flights say."""
    assert budget.largest_covers(59, 0.95) >= 0.95 > budget.largest_covers(58, 0.95)
    assert budget.largest_covers(20, 0.95) == pytest.approx(0.6415, abs=1e-4)


def test_differences_of_paired_flights_have_their_interval():
    """Four pairs by hand: differences 1, 2, 3, 4, t = 3.1824 of 3 degrees of freedom, s = 1.2910."""
    mean, spread = budget.difference([11.0, 22.0, 33.0, 44.0], [10.0, 20.0, 30.0, 40.0], 0.95)
    assert mean == 2.5
    assert spread == pytest.approx(3.18245 * 1.290994 / 2.0, rel=1e-5)
    assert np.isnan(budget.difference([1.0], [0.5], 0.95)[1])
    rng = np.random.default_rng(1)
    covered = [abs(m) <= s for m, s in (budget.difference(rng.normal(size=4), np.zeros(4), 0.95) for _ in range(4000))]
    assert np.mean(covered) == pytest.approx(0.95, abs=0.01)


def test_windows_begin_at_each_sample_and_no_size_is_beyond_half_a_turn():
    """A ramp of 1 in 4 samples: each window of two has a mean between its ends, and none is left out."""
    ramp = np.linspace(0.0, 0.3, 4)[:, None] * [1.0, 0.0, 0.0]
    found = budget.sizes(ramp, 1.0, 2.0, 1.0)
    assert found["mean"] == pytest.approx([0.05, 0.15, 0.25])
    assert found["relative"] == pytest.approx([0.05] * 6)
    assert found["drift"] == pytest.approx([0.1, 0.1])
    turned = budget.sizes(np.array([[3.1, 0.0, 0.0], [-3.1, 0.0, 0.0], [3.1, 0.0, 0.0]]), 1.0, 1.0, 1.0)
    assert turned["drift"].max() == pytest.approx(np.pi)
    assert [len(v) for v in budget.sizes(ramp[:1], 1.0, 2.0, 1.0).values()] == [1, 0, 0, 0]
