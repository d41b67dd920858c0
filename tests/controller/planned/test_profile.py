"""The disturbance along the orbit as the planner keeps it: its nodes, their times, and the change an orbit later."""

import numpy as np
import pytest

from . import core

PERIOD, NOW = 5500.0, 9000.0
SAMPLES = np.arange(0.0, NOW + 0.1, 0.5)
AHEAD = NOW + np.linspace(0.0, 0.98 * PERIOD, 50)


def drag(t):
    """A torque with the period of the orbit and half of it, N m (n, 3)."""
    turn = 2.0 * np.pi * np.asarray(t) / PERIOD
    return 1e-5 * np.column_stack((1.0 + np.sin(turn), np.cos(2.0 * turn), np.full_like(turn, 3.0)))


@pytest.mark.parametrize("now", [NOW, PERIOD + 8.0 * PERIOD / 64.0], ids=["between two nodes", "at a node"])
def test_a_disturbance_that_repeats_is_known_an_orbit_ahead(now):
    """Between two of 64 nodes a harmonic of 2/P is known to (4 pi/64)^2/8: 0.5%."""
    samples, ahead = SAMPLES[now >= SAMPLES], now + AHEAD - NOW
    change = core.profile_change(PERIOD, samples, drag(samples), samples >= 0.0, ahead)
    assert samples[-1] == now
    assert change == pytest.approx(drag(ahead) - drag([now]), abs=1e-7)
    assert np.abs(change).max() > 1.5e-5


@pytest.mark.parametrize("step", [7.0, 13.0, 61.0])
def test_the_profiles_nodes_keep_their_times_however_seldom_it_is_sampled(step):
    """A node is as late as a sample: at most a step times the largest slope, 2.3e-8 N m/s; lateness does not add up
    over the 64 nodes of an orbit, nor over four orbits."""
    t = np.arange(0.0, 4.2 * PERIOD, step)
    ahead = t[-1] + AHEAD - NOW
    change = core.profile_change(PERIOD, t, drag(t), t >= 0.0, ahead)
    assert change == pytest.approx(drag(ahead) - drag([t[-1]]), abs=2.0 * step * 2.3e-8 + 1e-7)


def test_it_is_taken_to_be_constant_in_the_first_orbit_and_later_than_one_after_the_newest_node():
    first = SAMPLES[SAMPLES < 0.99 * PERIOD]
    assert not core.profile_change(PERIOD, first, drag(first), first >= 0.0, first[-1] + AHEAD - NOW).any()
    later = NOW + PERIOD * np.array([1.0, 1.5])
    assert not core.profile_change(PERIOD, SAMPLES, drag(SAMPLES), SAMPLES >= 0.0, later).any()


def test_it_is_taken_to_be_constant_where_no_good_estimate_was_an_orbit_before():
    """Also between a good node and another: those at 6359 and 6617 s are good, at 6445 and 6531 s they are not."""
    good = np.abs(SAMPLES - 6500.0) > 100.0
    then = 6500.0 + PERIOD + np.array([-200.0, -110.0, 0.0, 90.0, 200.0])
    change = core.profile_change(PERIOD, SAMPLES, drag(SAMPLES), good, then)
    whole = core.profile_change(PERIOD, SAMPLES, drag(SAMPLES), SAMPLES >= 0.0, then)
    assert whole.any(axis=1).all()
    assert change == pytest.approx(whole * np.array([1, 0, 0, 0, 1])[:, None], abs=0.0)


@pytest.mark.parametrize(("parts", "known"), [(1.5, True), (2.5, False)])
def test_after_a_gap_of_two_parts_of_an_orbit_it_begins_anew(parts, known):
    there = np.abs(SAMPLES - 8000.0) > 0.5 * parts * PERIOD / 64.0
    assert core.profile_change(PERIOD, SAMPLES[there], drag(SAMPLES[there]), there[there], AHEAD).any() == known


def test_what_differs_from_the_last_orbit_fades_by_e_in_a_tenth_of_one():
    sudden = np.where(SAMPLES[:, None] > NOW - 100.0, [0.0, 2e-5, 0.0], 0.0)
    change = core.profile_change(PERIOD, SAMPLES, sudden, SAMPLES >= 0.0, AHEAD[:-5])
    assert change[:, 1] == pytest.approx(-2e-5 * (1.0 - np.exp(-(AHEAD[:-5] - NOW) / (0.1 * PERIOD))), abs=1e-9)
