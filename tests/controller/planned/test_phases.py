"""The timers of the planner's phases without a flight around them: doubt of the attitude, settling, a hold that is
strained, each the second time as the first; and the table of phases.

Times and limits are those of docs/how/planned.md, Phases, and docs/how/planned-orbit.md, Strained hold.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import core
from .states import AHEAD, R0, V0

T, PERIOD, DISTURBANCE = core.hold_scales()
DEGREE = np.radians(1.0)
BEYOND, WITHIN = np.radians(30.1), np.radians(29.9)


def runs(flags):
    """The samples at which flags change, from false on."""
    return np.flatnonzero(np.diff(np.concatenate(([0], np.asarray(flags).astype(int))))).tolist()


def doubted(bound, turns, holds=None, lost=None):
    """Turns are shares of 0.3/T beyond a target that turns itself."""
    n = len(bound)
    wanted = 0.4 / T + 0.1 / T * np.sin(np.arange(n))
    none = np.zeros(n, bool)
    holds, lost = (none if each is None else each for each in (holds, lost))
    return core.doubted(bound, wanted + 0.3 / T * np.asarray(turns), wanted, holds, lost)[:2]


def test_an_attitude_is_doubted_from_a_turn_beyond_the_target_s_on_until_its_bound_is_small_each_time():
    i = np.arange(60)
    bound = np.where(i % 30 < 25, BEYOND, WITHIN)
    turns = np.where(np.isin(i % 30, (10, 11)), 1.01, 0.99)
    held = np.arange(60) < 1
    assert runs(doubted(bound, turns, held)[0]) == [10, 25, 40, 55]
    assert runs(doubted(bound, turns, lost=held)[0]) == [10, 25, 40, 55]
    assert not doubted(bound, turns)[0].any(), "neither a hold nor a lost field before"
    assert not doubted(bound, np.full(60, 0.99), held)[0].any()
    assert not doubted(np.full(60, WITHIN), turns, held)[0].any()


def test_a_field_that_drives_is_given_up_while_the_attitude_is_doubted_and_taken_again_each_time():
    """Beyond twice the least rate of this doubt, and 0.3/T."""
    i = np.arange(90)
    bound = np.where(i % 45 < 40, BEYOND, WITHIN)
    rate = np.full(90, 2.0 / T)
    rate[(i % 45 >= 10) & (i % 45 < 20)] = 1.0 / T
    rate[i % 45 == 20] = 2.29 / T
    rate[i % 45 == 30] = 2.31 / T
    found, drives, _ = core.doubted(bound, rate, np.zeros(90), i < 1, i < 0)
    assert runs(found) == [0, 40, 45, 85]
    assert runs(drives) == [30, 40, 75, 85]


def test_a_hold_has_settled_after_the_same_time_without_a_break_each_time_and_is_turned_away_beyond_five_degrees():
    """Below 1 deg and 1/(20 T) for 1.2 T."""
    n, dt = 400, T / 50.0
    angle, rate = np.full(n, 0.99 * DEGREE), np.full(n, 0.99 / (20.0 * T))
    angle[[0, 100, 200]] = 1.01 * DEGREE
    rate[[130, 230]] = -1.0
    rate[[130, 230]] = 1.01 / (20.0 * T)
    angle[300], angle[320] = 4.99 * DEGREE, 5.01 * DEGREE
    found = core.held(dt, angle, rate, np.zeros(n), np.zeros(n, bool))
    seen = runs(found.settled)
    expected = [61, 100, 191, 200, 291, 300, 381]
    assert np.abs(np.array(seen) - expected).max() <= 1, seen
    assert runs(found.away) == [320, 321]


def test_a_hold_is_strained_a_twentieth_of_an_orbit_after_the_load_began_and_for_an_orbit_after_it_ended_each_time():
    dt = PERIOD / 400.0
    i = np.arange(1500)
    loaded = ((i >= 10) & (i < 29)) | ((i >= 30) & (i < 100)) | ((i >= 700) & (i < 760))
    found = core.held(dt, np.full(1500, 0.9 * DEGREE), 0.0 * i, 0.0 * i, loaded)
    assert np.abs(np.array(runs(found.strained)) - [51, 499, 721, 1159]).max() <= 1, runs(found.strained)
    big = core.held(dt, np.full(1500, 50.0 * DEGREE), 0.0 * i, 0.0 * i, loaded)
    sooner = 2.0 * T / dt
    expected = [0, 11 + sooner, 500, 701 + sooner, 1160]
    assert runs(big.away) == pytest.approx(expected, abs=2), "beyond 5 deg, in a strained hold beyond 57"


def test_it_is_strained_sooner_with_an_error_beyond_a_degree_and_stays_so_under_a_disturbance_that_is_too_large():
    """After 2 T; the large disturbance alone is no cause, but lets a strained hold stay."""
    dt, i = T / 10.0, np.arange(3500)
    loaded = (i >= 100) & (i < 140)
    torque = np.where(i < 2000, 1.01, 0.99) * DISTURBANCE
    found = core.held(dt, np.full(3500, 1.01 * DEGREE), 0.0 * i, torque, loaded)
    first, last = runs(found.strained)
    assert abs(first - 121) <= 1
    assert last == pytest.approx(2000 + PERIOD / dt, abs=2)
    assert not core.held(dt, np.full(3500, 0.99 * DEGREE), 0.0 * i, torque, loaded).strained.any()


STEERING, ACQUISITION, HOLD, DAMPING = 1, 2, 3, 4
NO_ATTITUDE, NO_TARGET, WHEEL, TARGET, LOST, PLAN, AWAY, SETTLED = (2**k for k in range(8))


def test_events_lead_from_each_phase_as_the_table_has_it_and_the_first_row_counts():
    for phase in (STEERING, ACQUISITION, HOLD, DAMPING):
        for event in (NO_ATTITUDE, NO_TARGET, WHEEL):
            assert core.changed_phase(phase, event, LOST, PLAN, AWAY, SETTLED, TARGET) == DAMPING
    leads = {
        (DAMPING, TARGET): -STEERING,
        (STEERING, PLAN): -ACQUISITION,
        (HOLD, AWAY): ACQUISITION,
        (ACQUISITION, SETTLED): HOLD,
        (ACQUISITION, LOST): -STEERING,
        (HOLD, LOST): -STEERING,
        (DAMPING, LOST): -STEERING,
        (STEERING, LOST): STEERING,
    }
    for phase in (STEERING, ACQUISITION, HOLD, DAMPING):
        for event in (TARGET, LOST, PLAN, AWAY, SETTLED):
            assert core.changed_phase(phase, event) == leads.get((phase, event), phase), (phase, event)
    assert core.changed_phase(HOLD, LOST, AWAY) == -STEERING
    assert core.changed_phase(STEERING, LOST, PLAN) == STEERING


@pytest.mark.parametrize(
    ("degrees", "h_w", "loaded"),
    [(0.4, 0.0, False), (0.6, 0.0, True), (-0.6, 0.0, True), (0.4, 1.0, True), (0.4, -1.0, True)],
)
def test_a_hold_is_loaded_by_its_error_or_by_the_wheel_alone(degrees, h_w, loaded):
    """Beyond 0.5 deg, or 0.6 of the wheel's momentum; its error and rate are those from the target."""
    satellite = core.Satellite()
    R, Omega = core.lvlh(R0, V0)
    off = Rotation.from_rotvec(np.radians(degrees) * np.array([0.6, 0.0, 0.8]))
    rate = off.inv().apply(Omega) + np.array([1e-5, -2e-5, 2e-5])
    for share in (0.59, 0.61):
        l = h_w * share * satellite.wheel_momentum_max  # noqa: E741
        found = core.standing(satellite, AHEAD, core.Motion(R @ off.as_matrix(), rate, l), HOLD)
        assert found[0] == pytest.approx(abs(np.radians(degrees)), rel=1e-6)
        assert found[1] == pytest.approx(3e-5, rel=1e-6)
        assert found[2:] == (False, True, loaded and (h_w == 0.0 or share > 0.6))


def test_a_sample_gives_what_the_plan_has_in_its_middle():
    for period, middle in ((0.3, 0.1), (0.5, 0.2), (1.1, 0.5)):
        assert core.commanded(control_period=period) == pytest.approx([middle, 0.0, 0.0, 0.0]), period


def test_a_search_begins_where_the_plan_that_is_flown_meanwhile_brings_the_wheel():
    """Without friction the momentum is the sum of the torques over time, those after the search's begin left out."""
    torque = np.append(2e-3 * np.array([1.0, 1, 1, 1, 1, -0.5, -0.5, 0.25, 0.25, 0, 0, 0.1, 0.1, 0.1, -0.3, 0.7]), 3e-3)
    after, momentum = core.foreseen(torque)
    assert after == pytest.approx(16 * 0.5)
    assert momentum == pytest.approx(0.5 * torque[:16].sum(), rel=1e-9)
