"""The planner's watches of rods, sensors and wheel without a flight around them: each time that must pass, the second
time as the first.

Times are those of docs/how/planned-estimates.md in units of T, here 50 s.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import core

T = 50.0


def counts(flags):
    """Lengths of the runs of equal flags, and the first flag."""
    edges = np.flatnonzero(np.diff(np.asarray(flags).astype(int)))
    return bool(flags[0]), np.diff(np.concatenate(([-1], edges, [len(flags) - 1]))).tolist()


def test_each_pause_of_the_rods_watch_lasts_twice_as_long_as_the_last_one():
    begun = np.zeros(200, bool)
    begun[[0, 30, 80]] = True
    innovations = np.tile([10.0, 0.0, 0.0], (200, 1))
    suspected = core.rods_suspected(1.0, T, 20.0, 100.0, np.zeros(200), innovations, begun)
    assert counts(suspected) == (False, [20, 10, 40, 10, 80, 40])


def test_after_each_fast_rate_the_rods_are_not_watched_for_ten_T_and_a_longer_pause_stays():
    """The rate is 15.1/T for two samples, twice, and once more within a pause of 600 s that has 599 s to go."""
    body = np.zeros(2400)
    body[[100, 101, 800, 801]] = 15.1 / T
    body[1500] = 14.9 / T
    body[1701] = 15.1 / T
    begun = np.arange(2400) == 1700
    suspected = core.rods_suspected(1.0, T, 600.0, 100.0, body, np.tile([0.0, 10.0, 0.0], (2400, 1)), begun)
    assert counts(suspected) == (True, [100, 501, 199, 501, 399, 600, 100])


def test_what_was_seen_of_the_rods_before_a_pause_is_forgotten():
    """A sum of small innovations comes to 25 after so many samples, before the pause and after it."""
    begun = np.arange(200) == 100
    suspected = core.rods_suspected(1.0, T, 5.0, 0.02, np.zeros(200), np.tile([0.0, 0.0, 60.0], (200, 1)), begun)
    first = int(np.argmax(suspected))
    assert 3 < first < 90
    assert counts(suspected) == (False, [first, 100 - first, 5 + first, 95 - first])


@pytest.mark.parametrize("along", [(60.0, 0.0, 0.0), (0.0, -60.0, 0.0), (35.0, -25.0, 45.0)])
def test_the_rods_are_suspected_as_soon_after_each_pause_as_at_first_whatever_the_direction(along):
    """Effects of 0.02 rad/s, fading over 4 T: the squared deviation of their sum to n samples, over n effects and 1."""
    begun, kept, effect = np.isin(np.arange(200), (60, 130)), 1.0 - 1.0 / (4.0 * T), 0.02
    suspected = core.rods_suspected(1.0, T, 5.0, effect, np.zeros(200), np.tile(along, (200, 1)), begun)
    sums = np.cumsum(kept ** np.arange(100))
    deviations = (effect * sums) ** 2 * np.dot(along, along) / (effect**2 * sums + 1.0)
    first = int(np.argmax(deviations > 25.0))
    assert 2 < first < 20
    assert counts(suspected) == (False, [first, 60 - first, 5 + first, 65 - first, 10 + first, 60 - first])


def test_an_attitude_is_frozen_after_the_same_time_at_each_freeze_and_turned_on_from_the_last_one():
    """0.04 T are 2 s. The attitude moves for 5 s, repeats for 10, and so on."""
    rate, dt = np.array([0.02, -0.01, 0.015]), 0.5
    moved = [Rotation.from_rotvec(0.1 * i * np.array([1.0, 2.0, -1.0])).as_matrix() for i in range(30)]
    R = np.array([moved[10 * j + min(i, 9)] for j in range(3) for i in range(30)])
    frozen, turned = core.attitudes_frozen(dt, T, 0.0, R, np.tile(rate, (90, 1)))
    for begin in (0, 30, 60):
        assert counts(frozen[begin : begin + 30]) == (False, [14, 16]), "until 2 s after the last new attitude"
        last = R[begin + 9]
        for i in (9, 14, 29):
            on = last @ Rotation.from_rotvec(dt * (i - 9) * rate).as_matrix()
            np.testing.assert_allclose(turned[begin + i], on, atol=1e-12)


def test_an_attitude_that_repeats_at_rest_is_not_frozen_until_the_rate_has_turned_it():
    """1e-3 rad at 1.03e-4 rad/s are 9.7 s; what it turned in an earlier freeze does not count."""
    R = np.array([np.eye(3)] * 30 + [Rotation.from_rotvec([0.1, 0.0, 0.0]).as_matrix()] * 30)
    frozen, _ = core.attitudes_frozen(0.5, T, 0.0, R, np.tile([0.0, 1.03e-4, 0.0], (60, 1)))
    assert counts(frozen) == (False, [20, 10, 20, 10])


def test_a_rate_that_jumps_turns_no_attitude_on():
    """More than 0.02 rad in a sample by the change of the rate: the rate of before is taken."""
    Omega = np.tile([0.0, 0.01, 0.0], (10, 1))
    Omega[[4, 7]] = [0.0, 0.5, 0.0]
    _, turned = core.attitudes_frozen(1.0, T, 0.0, np.array([np.eye(3)] * 10), Omega)
    steps = [Rotation.from_matrix(a.T @ b).magnitude() for a, b in pairwise(turned)]
    assert steps[3] == pytest.approx(0.01), "to the sample that jumps"
    assert steps[6] == pytest.approx(0.01)


def test_a_field_that_repeats_has_failed_after_the_same_time_each_time():
    """0.4 T are 20 s; a shorter repetition before does not count."""
    changes = np.cumsum(np.isin(np.arange(200), [0, 15, 33, 80, 99, 150]))
    b_B = np.outer(changes, [1e-9, 2e-9, -1e-9]) + np.array([2e-5, 1e-5, -3e-5])
    failed = core.fields_failed(1.0, T, 1e-6, b_B, b_B)
    assert counts(failed) == (False, [54, 26, 40, 30, 21, 29])


def test_a_wrong_field_fails_and_is_used_again_as_often_as_it_comes_and_goes():
    """First-order smoothing over 1.2 T: beyond the tolerance it has failed, below half of it it is used again."""
    wrong = (np.arange(800) // 200) % 2 == 1
    spread = 1e-10 * np.arange(800)[:, None]  # no sample repeats
    model = np.tile([2e-5, 1e-5, -3e-5], (800, 1)) + spread
    failed = core.fields_failed(1.0, T, 1e-6, model * (1.0 + 0.1 * wrong)[:, None], model)
    left = 1.0 - 1.0 / 60.0
    size = 0.1 * np.linalg.norm(model[0])
    until_failed = int(np.ceil(np.log(1.0 - 1e-6 / size) / np.log(left)))
    seen = counts(failed)[1]
    assert not failed[0]
    assert len(seen) == 4
    assert seen[0] == pytest.approx(199 + until_failed, abs=2)
    until_right = np.log(0.5e-6 / (size * (1.0 - left**200))) / np.log(left)
    assert seen[0] + seen[1] == pytest.approx(400 + until_right, abs=3)
    # The second time what is left of the first residual, 0.04 of it, brings the limit nearer.
    assert seen[0] + seen[1] + seen[2] == pytest.approx(599 + until_failed, abs=12)


GIVEN = np.full(300, 1e-6)


def momenta(still, noise=1e-6):
    """A momentum that grows by GIVEN, with noise, and where it stays as it was."""
    exact = 6e-3 + 0.5 * np.cumsum(GIVEN) + noise * np.random.default_rng(0).normal(size=300)
    return exact[np.maximum.accumulate(np.where(still, 0, np.arange(300)))]


def test_a_momentum_that_repeats_is_frozen_after_as_many_samples_each_time_and_used_again():
    """After 20 that repeat; 20 that change end it. A shorter repetition shows nothing meanwhile."""
    i = np.arange(300)
    still = ((i >= 40) & (i < 45)) | ((i >= 100) & (i < 230))
    frozen, blind, l = core.momenta_frozen(0.5, momenta(still), GIVEN)  # noqa: E741
    assert counts(frozen) == (False, [100 + 119, 30, 51]), "20 for each of 5 that repeated before, and 20"
    assert counts(blind) == (False, [40, 6, 59, 145, 50]), "also as it changes again"
    assert l[219] == pytest.approx(momenta(still)[99] + 120 * 0.5 * 1e-6)
    twice = (i // 100 != 1) & (i % 100 >= 40)
    frozen = core.momenta_frozen(0.5, momenta(twice), GIVEN)[0]
    assert counts(frozen) == (False, [59, 60, 140, 41]), "the second time as the first: a freeze is no usual repetition"


def test_a_momentum_without_noise_or_of_zero_is_not_frozen():
    still = np.arange(300) >= 60
    for h_w in (momenta(still, 0.0), momenta(still) * ~still):
        frozen, blind, _ = core.momenta_frozen(0.5, h_w, GIVEN)
        assert not frozen.any()
        assert not blind.any()


def test_a_wheel_that_gives_nothing_is_stuck_and_one_that_gives_again_is_not_each_time():
    """It is known after 0.2 of 2 T of such torques, 20 s; that it follows its torque is seen over 3 T, 150 s."""
    gives = (np.arange(1600) // 400) % 2 == 1
    torque = np.where(np.arange(1600) % 2, 3e-3, -3e-3)
    l_next = np.where(gives, torque, 0.0)
    failed, stuck = core.wheel_failed(1.0, T, torque, np.zeros(1600), l_next)
    for flags in (failed, stuck):
        assert not flags[:20].any()
        assert flags[20:400].all()
        assert not flags[700:800].any()
        assert flags[870:1200].all()
        assert not flags[1550:].any()
    assert not core.wheel_failed(1.0, T, 0.1 * torque, np.zeros(1600), np.zeros(1600))[0].any(), "too little is asked"


def test_a_wheel_that_does_not_follow_small_torques_is_stuck_once_it_was_watched_for_3_T_each_time():
    """Torques of a third of the limit, too small for the other test; it stands at a third of its momentum, turns with
    them from 400 s on and stands again from 800 s on, each time without noise."""
    n = 1200
    torque = 1e-3 * np.where(np.arange(n) // 7 % 2, 1.0, -1.0)
    stands = np.arange(n) // 400 != 1
    l = 0.01 + np.append(0.0, np.cumsum(np.where(stands, 0.0, torque)))  # noqa: E741
    _, stuck = core.wheel_failed(1.0, T, torque, l[:-1], l[1:])
    begins, ends, again = np.flatnonzero(np.diff(stuck.astype(int)) != 0) + 1
    assert 148 <= begins <= 152
    assert ends > 400
    assert 800 < again < 1000
    drifts = l - 1e-4 * np.clip(np.arange(n + 1) - 400, 0, 400)
    found = core.wheel_failed(1.0, T, torque, drifts[:-1], drifts[1:])[1]
    assert np.array_equal(found, stuck), "a change that no torque makes tells nothing"


@pytest.mark.parametrize("begins", [2, 40])
def test_noise_that_hides_a_single_change_of_torque_makes_no_stuck_wheel_however_early_it_came(begins):
    """The wheel gives all of its torque, which in 200 s moves it by five deviations of its momentum's noise."""
    torque = np.where(np.arange(400) < begins, 0.0, 5e-8)
    for seed in range(30):
        noise = 2e-6 * np.random.default_rng(seed).normal(size=401)
        l = 0.01 + np.append(0.0, np.cumsum(0.5 * torque)) + noise  # noqa: E741
        assert not core.wheel_failed(0.5, T, torque, l[:-1], l[1:])[1].any(), seed


def test_friction_that_holds_a_wheel_is_learned_through_noise_each_time_and_none_of_one_that_moves():
    """It stands under 1e-4 N m for 200 s, is moved away and comes back, and stands again; its momentum has noise."""
    rng, n = np.random.default_rng(2), 1600
    held = np.isin(np.arange(n) // 400, (0, 2))
    torque = np.where(held, 1e-4, np.where(np.arange(n) % 400 < 200, 1e-4, -1e-4))
    moved = np.cumsum(np.where(held, 0.0, 0.5 * torque))
    l = np.append(0.0, moved) + 2e-6 * rng.normal(size=n + 1)  # noqa: E741
    known = core.friction(0.5, T, torque, l[:-1], l[1:])[:, 0]
    assert known[[300, 1100]] == pytest.approx(1e-4, rel=0.05)
    assert known[[790, 1590]] == pytest.approx(0.0, abs=1e-5)
    slow = 4e-6 * np.sin(0.05 * np.arange(n))
    l = np.append(0.0, np.cumsum(0.5 * slow)) - 4e-5 + 2e-6 * rng.normal(size=n + 1)  # noqa: E741
    assert core.friction(0.5, T, slow, l[:-1], l[1:])[:, 0].max() < 2e-6


def test_friction_of_either_kind_is_the_one_of_a_least_squares_fit_of_all_samples():
    """Without a change of friction the filter is the fit that begins with zeros and a deviation of a tenth."""
    rng, n, dt = np.random.default_rng(3), 400, 0.5
    limit, most = 5e-3, 0.03
    torque = 2e-3 * np.sin(0.05 * np.arange(n)) + 1e-3 * rng.normal(size=n)
    true = np.array([1.5e-4, 4e-3])
    momenta = np.zeros(n + 1)
    momenta[0] = 0.012
    for k in range(n):
        momenta[k + 1] = momenta[k] + dt * (torque[k] - true @ (np.sign(momenta[k]), momenta[k]))
    before, after = momenta[:-1], momenta[1:]
    used = before * after > 0.0
    assert 0.2 < np.mean(before > 0.0) < 0.8, "to either side"
    known = core.friction(dt, T, torque, before, after)
    rows = np.column_stack((np.where(before > 0.0, 1.0, -1.0), 0.5 * (before + after)))[used]
    sizes = np.array([0.1 * limit, 0.1 * limit / most])
    weighted = np.vstack((rows / (0.01 * limit), np.diag(1.0 / sizes)))
    lacks = np.append((torque - (after - before) / dt)[used] / (0.01 * limit), (0.0, 0.0))
    expected = np.linalg.lstsq(weighted, lacks, rcond=None)[0]
    assert known[-1] == pytest.approx(expected, rel=0.02)
    assert known[-1] == pytest.approx(true, rel=0.1)


def test_a_wheel_that_stands_at_exactly_zero_shows_its_friction_at_once_by_the_torque_that_it_bears():
    """At any other momentum about zero so small a torque would take a minute to show it."""
    torque = np.where(np.arange(40) < 20, 1e-6, -4e-6)
    zero, other = np.zeros(40), np.full(40, 1e-9)
    known = core.friction(0.5, T, torque, zero, zero)[:, 0]
    assert known[18] == pytest.approx(1e-6, rel=0.2)
    assert 2e-6 < known[39] <= 4e-6
    for before, after in ((zero, other), (other, zero)):
        assert core.friction(0.5, T, torque, before, after)[:, 0].max() < 2e-7
    assert not core.friction(0.5, T, 0.0 * torque, zero, zero).any()


def test_friction_that_becomes_another_is_followed_over_a_day():
    """Each changes in 1e5 s by as much as it may be before the flight."""
    n, dt = 240_000, 0.5
    torque = 2e-3 * np.sign(np.sin(0.05 * np.arange(n))) * (1.0 + 0.3 * np.sin(0.011 * np.arange(n)))
    coulomb, viscous = (np.where(np.arange(n) < n // 2, a, b) for a, b in ((1.5e-4, 3e-4), (2e-3, 8e-3)))
    l = np.empty(n + 1)  # noqa: E741
    l[0] = 0.0
    at = 0.0
    for k, (tau, c, v) in enumerate(zip(torque.tolist(), coulomb.tolist(), viscous.tolist(), strict=True)):
        at += dt * (tau - (c if at > 0.0 else -c) - v * at)
        l[k + 1] = at
    known = core.friction(dt, T, torque, l[:-1], l[1:])
    assert known[n // 2 - 1] == pytest.approx([1.5e-4, 2e-3], rel=0.1)
    assert known[-1] == pytest.approx([3e-4, 8e-3], rel=0.1)


def test_a_slip_of_the_wheel_is_followed_at_once_without_noise_and_little_with_it_each_time():
    """It slips by 1e-4 N m for 100 s, not for 100 s, and again; white noise of the momentum is no slip."""
    n, dt = 800, 0.5
    rng, slips = np.random.default_rng(4), np.arange(n) // 200 % 2 == 0
    exact = np.append(0.0, np.cumsum(dt * np.where(slips, 1e-4, 0.0)))
    torque = np.zeros(n)
    assert core.wheel_rates(dt, T, torque, exact[:-1], exact[1:]) == pytest.approx(np.where(slips, 1e-4, 0.0))
    noise = 2e-4 * rng.normal(size=n + 1)
    measured = exact + noise
    rates = core.wheel_rates(dt, T, torque, measured[:-1], measured[1:])
    raw = np.diff(measured) / dt
    assert np.std(rates[100:]) < 0.1 * np.std(raw[100:])
    jump = np.append(0.0, np.cumsum(np.where(np.arange(n) == 300, 10.0, 0.0)))
    found = core.wheel_rates(dt, T, torque, jump[:-1], jump[1:])
    assert found[300] == pytest.approx(20.0), "no wheel's: taken as measured"
    assert not found[301:].any(), "and forgotten"
