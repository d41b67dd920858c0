"""How far a renewed plan sees, in orbits and in the satellite's time T (docs/how/planned-plan.md,
docs/evidence/satellites.md)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import core
from .states import AHEAD

ACQUISITION, HOLD = 2, 3
QUARTER = 0.5 * math.pi * math.sqrt(6.971e6**3 / core.MU)
"""s, by Kepler's third law."""
T = 16.0
"""s, of the 1U in docs/evidence/satellites.md; 50 s of the paper's satellite."""
ONE_U = core.Satellite(np.diag([2.47e-3, 2.47e-3, 2.17e-3]), 0.2 * np.eye(3), dipole_max=0.2)
ONE_U = replace(ONE_U, wheel_torque_max=1e-4, wheel_momentum_max=1e-3)
PLENTY = 10**9
LITTLE = 20_000
"""Of work: for a plan of the usual horizon, and not for cutting it."""


def off(angle: float) -> core.Motion:
    """At rest relative to LVLH, turned away from it by this angle, rad."""
    _, R_d, Omega_d = core.around(AHEAD, 0.0)
    return core.Motion(R_d @ Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix(), Omega_d, 0.0)


@pytest.mark.parametrize(
    ("heavier", "stage"),
    [(1.0, T), (2.44, 26.0), (0.25, (QUARTER - 30 * 8.2) / 80.0)],  # stages of T, or longer ones where 80 would not do
)
def test_a_holds_plan_grows_by_a_stage_at_each_renewal_until_it_sees_a_quarter_of_an_orbit(heavier, stage):
    satellite = replace(ONE_U, J=heavier * ONE_U.J)
    lengths, longer = [], 0
    for _ in range(85):
        plan = core.renewed(satellite, AHEAD, off(0.0), HOLD, longer)
        longer = plan.longer
        lengths.append(plan.h.sum())
    grown = np.diff(lengths)
    assert lengths[0] == pytest.approx(core.plan(satellite, AHEAD, off(0.0), 0).h.sum() + stage, rel=1e-2)
    assert grown[: longer - 1] == pytest.approx(stage, rel=1e-2)
    assert grown[longer - 1 :] == pytest.approx(0.0, abs=1e-9)
    assert lengths[-1] == pytest.approx(QUARTER, abs=0.51 * stage)


HEAVY = replace(core.Satellite(), J=4.0 * core.Satellite().J)
"""Its usual horizon is more than a quarter of an orbit."""


@pytest.mark.parametrize(
    ("satellite", "phase", "angle", "length"),
    [
        (HEAVY, HOLD, 0.0, 30 * 100.0),
        (ONE_U, ACQUISITION, 1.0, 7 * T),
        (replace(ONE_U, wheel_torque_max=0.0), HOLD, 1.0, 4 * QUARTER),
    ],
    ids=["a long horizon", "acquisition", "by rods alone"],
)
def test_no_other_plan_grows_or_is_cut(satellite, phase, angle, length):
    plan = core.renewed(satellite, AHEAD, off(angle), phase, 5)
    assert plan.longer == 0
    assert plan.h.sum() == pytest.approx(length, rel=1e-2)


@pytest.mark.parametrize(("satellite", "time"), [(ONE_U, T), (core.Satellite(), 50.0)])
def test_a_holds_plan_with_a_turn_in_it_is_cut_down_to_the_first_ten_T_and_grows_again(satellite, time):
    refused = core.renewed(satellite, AHEAD, off(1.5), HOLD, account=LITTLE)
    once = core.renewed(satellite, AHEAD, off(0.0), HOLD, refused.longer)
    assert once.h.sum() == pytest.approx(20.5 * time, abs=0.5 * time)
    cut = core.renewed(satellite, AHEAD, off(1.5), HOLD, account=PLENTY)
    assert cut.h.sum() == pytest.approx(10 * time)
    again = core.renewed(satellite, AHEAD, off(0.0), HOLD, cut.longer)
    assert again.h.sum() == pytest.approx(10.5 * time)


@pytest.mark.parametrize("angle", [0.0, 0.05, 0.1])
def test_a_holds_plan_that_costs_less_than_twice_T_is_flown(angle):
    plan = core.renewed(ONE_U, AHEAD, off(angle), HOLD, account=LITTLE)
    assert plan.cost < 2.0 * T
    assert (len(plan.h), plan.longer) == (91, 1)


@pytest.mark.parametrize("angle", [0.15, 0.2, 0.3, 0.5])
def test_a_holds_plan_that_costs_more_is_not_flown_where_there_is_no_work_left_to_cut_it(angle):
    plan = core.renewed(ONE_U, AHEAD, off(angle), HOLD, account=LITTLE)
    assert plan.cost > 2.0 * T
    assert (len(plan.h), plan.longer) == (0, -20)


@pytest.mark.parametrize("angle", [0.5, 1.0, 2.0])
def test_the_account_of_a_sample_is_never_overdrawn(angle):
    for satellite in (ONE_U, core.Satellite()):
        for longer in (0, 30, 60):
            assert core.renewed(satellite, AHEAD, off(angle), HOLD, longer).left >= 0


def test_the_next_plan_is_asked_to_reach_the_target_in_four_fifths_of_the_time_that_this_one_takes():
    plan = core.renewed(core.Satellite(), AHEAD, off(0.2), ACQUISITION, until=math.inf)
    assert 0.0 < plan.settles < 7 * 50.0
    assert plan.until == pytest.approx(0.8 * plan.settles)
