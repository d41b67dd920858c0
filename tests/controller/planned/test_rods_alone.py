"""A wheel that is stuck or absent: the plan by rods alone, and the command that leaves the wheel out."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import saved, serialized

from . import block, core
from .test_identification import DT, Tumbles, flown
from .truth import DAYS, RADIUS, Truth, orbit

ORBIT = 2.0 * math.pi * math.sqrt(RADIUS**3 / core.MU)
BODY = core.Satellite(wheel_torque_max=0.0)
AHEAD = core.Ahead(*orbit(0.0), days=DAYS)


def turned_from_lvlh(seed, angle, h_w=0.0):
    """At LVLH's rate, turned away by an angle about an axis of the seed."""
    R_d, Omega_d = core.lvlh(*orbit(0.0))
    axis = np.random.default_rng(seed).normal(size=3)
    Q = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    return core.Motion(R_d @ Q, Q.T @ Omega_d, h_w)


def test_a_plan_without_a_wheel_looks_over_one_orbit_and_leaves_the_wheel_as_it_is():
    plan = core.plan(BODY, AHEAD, turned_from_lvlh(1, 1.0, 4e-3), 5)
    assert plan.h.sum() == pytest.approx(ORBIT, rel=1e-9)
    assert len(plan.h) <= core.STAGES
    assert np.abs(plan.u[:, :3]).max() <= 1.0
    assert (plan.u[:, 3] == 0.0).all()
    assert {x.h_w for x in plan.path} == {4e-3}


@pytest.mark.parametrize("scale", [1e-3, 1e2])
def test_the_plan_of_a_satellite_of_another_size_has_the_same_stages_and_motion(scale):
    """All times are those of the orbit: inertia, rods and wheel times a factor change nothing but the cost of the
    controls' rounding."""
    x = turned_from_lvlh(2, 0.5)
    other = core.Satellite(J=scale * BODY.J, rods=scale * BODY.rods, dipole_max=scale * 25.0, wheel_torque_max=0.0)
    other = replace(other, wheel_momentum_max=scale * BODY.wheel_momentum_max)
    was, plan = (core.plan(it, AHEAD, x, 3) for it in (BODY, other))
    assert plan.h == pytest.approx(was.h, rel=1e-12)
    assert pytest.approx(was.path[-1].R, abs=1e-6) == plan.path[-1].R


def test_a_search_without_a_wheel_turns_the_satellite_to_its_target_by_rods_alone():
    """Controls of the search, flown by SciPy: 100 deg away at first, within 10 deg for the last third of the orbit."""
    x = turned_from_lvlh(3, math.radians(100.0))
    stages = core.plan(BODY, AHEAD, x, 0).h
    searched = core.search(BODY, AHEAD, x)
    truth = Truth(BODY.J, BODY.rods, R=x.R, Omega=x.Omega)
    late = []
    for h, u in zip(stages, searched.u, strict=False):
        truth.fly(u[:3], 0.0, h)
        if truth.t > ORBIT * 2.0 / 3.0:
            target = core.lvlh(*orbit(truth.t))[0]
            late.append(Rotation.from_matrix(target.T @ truth.R).magnitude())
    assert max(late) < math.radians(10.0)


R_D, OMEGA_D = core.lvlh(*orbit(0.0))
AXIS = np.array([0.48, -0.6, 0.64])


def away(angle, change=(0.0, 0.0, 0.0)):
    """Cost and gradient by the angle of a motion turned by so much from its target, and then by a small vector."""
    R = R_D @ Rotation.from_rotvec(angle * AXIS).as_matrix() @ Rotation.from_rotvec(change).as_matrix()
    cost, gradient = core.cost_rate(BODY, R_D, OMEGA_D, core.Motion(R, R.T @ R_D @ OMEGA_D, 0.0))
    return cost, gradient[:3]


@pytest.mark.parametrize("angle", [0.02, 0.075, 0.1, 0.16, 0.5, 2.0])
def test_the_gradient_of_the_cost_near_to_and_far_from_the_target_is_its_difference(angle):
    expected = [(away(angle, 1e-5 * e)[0] - away(angle, -1e-5 * e)[0]) / 2e-5 for e in np.eye(3)]
    assert away(angle)[1] == pytest.approx(expected, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(("stages", "share", "counts"), [(166, 0.9, True), (166, 1.1, False), (0, 0.0, False)])
def test_far_angles_count_more_after_a_plan_that_stays_close_and_not_without_one(stages, share, counts):
    assert (core.weight_far(BODY, stages, share) > 0.0) is counts


def test_six_degrees_for_half_of_the_time_cost_more_than_four_and_a_half_all_the_time():
    """Of two holds with the same rms the one with the lesser largest angle is to be found, as long as both are
    close."""
    four, six = (away(math.radians(angle))[0] for angle in (6.36 / math.sqrt(2.0), 6.36))
    assert 0.5 * six > 1.3 * four


@pytest.mark.parametrize("rate", [0.0, 0.02])
def test_no_sample_of_a_search_without_a_wheel_takes_more_than_its_account(rate):
    x = turned_from_lvlh(4, 2.0)
    searched = core.search(BODY, AHEAD, core.Motion(x.R, x.Omega + rate, 0.0))
    assert 0 <= searched.least < core.WORK_OF_SAMPLE / 2
    assert 16 <= searched.calls < 400


class Wheel(Tumbles):
    """The motor is asked for 2.6 mN m of 3, and the wheel gives a share of it."""

    share = 0.0

    def command(self):
        super().command()
        self.dl = np.copysign(self.share * 2.6e-3, 0.012 - self.h_w)

    def asked(self, i, sample):
        dipoles = sample["u_applied"][:, :3]
        return sample | {"u_applied": np.column_stack((dipoles, np.copysign(2.6e-3, self.dl)))}


def along_the_field(truth, y):
    """The part along b of the torque that rods and a wheel without torque have to give, over the whole of it."""
    torque = y["tau_cmd_B"] + np.cross(truth.Omega[0], [truth.h_w[0], 0.0, 0.0]) + [y["wheel_torque_ff"], 0.0, 0.0]
    b = y["b_used_B"]
    return abs(torque @ b) / (np.linalg.norm(torque) * np.linalg.norm(b))


def test_a_stuck_wheel_is_only_tried_by_a_fiftieth_of_its_torque_and_rods_are_asked_for_no_torque_along_the_field():
    truth = Wheel(8, 1)
    truth.command()
    y = flown(truth, truth.asked)[1][0]
    assert y["wheel_failed"]
    assert abs(y["wheel_torque_ff"]) == pytest.approx(0.02 * 3e-3)
    assert along_the_field(truth, y) < 1e-3


def test_a_wheel_that_drags_is_not_given_up():
    """It gives a fifth of the torque."""
    truth = Wheel(8, 1)
    truth.share = 0.2
    truth.command()
    y = flown(truth, truth.asked)[1][0]
    assert y["wheel_failed"]
    assert y["wheel_torque_ff"] != 0.0


def test_a_stuck_wheel_is_not_looked_for_where_that_is_not_wanted():
    truth = Wheel(8, 1)
    truth.command()
    assert flown(truth, truth.asked, find_failures=False)[1][0]["wheel_torque_ff"] != 0.0


def test_a_wheel_of_limits_next_to_nothing_is_left_out_from_the_start():
    truth = Tumbles(9, 1)
    truth.h_w[:] = 0.0
    truth.command = lambda: None
    truth.dl = np.zeros(1)
    without = flown(truth, samples=4, wheel_torque_max=1e-9, wheel_momentum_max=1e-9)[1][0]
    assert without["wheel_torque_ff"] == 0.0
    assert along_the_field(truth, without) < 1e-3
    assert truth.t == 4 * DT


def searching(turn):
    """Share of the samples in which there is a search, for each 20 s of 1200: at rest, off by the rotation vector. A
    search changes kilobytes of the state in each sample; a renewal of the plan does so in one of twenty."""
    Q = Rotation.from_rotvec(turn).as_matrix()

    def askew(t):
        u = block.at_target(t)
        return {**u, "R_NB": u["R_NB"] @ Q, "omega_B": Q.T @ u["omega_B"], "b_B": Q.T @ u["b_B"]}

    changed, before = [], None
    with block.started(askew, wheel_torque_max=1e-9, wheel_momentum_max=1e-9, **block.KNOWN) as it:
        for i in range(2400):
            block.run(it, 0.5 * i, 0.5 * (i + 1), inputs=askew)
            state = np.frombuffer(serialized(it, saved(it)), np.uint8)
            changed.append(before is None or np.count_nonzero(state != before) > 2000)
            before = state
    return np.reshape(changed, (-1, 40)).mean(axis=1)


def test_searches_without_a_wheel_follow_each_other_by_a_twelfth_of_an_orbit():
    """60 deg off, from where a plan comes back."""
    active = searching([0.6, -0.8, 0.3]) > 0.5
    begun = [20.0 * i for i in range(1, len(active)) if active[i] and not active[i - 1]]
    assert active[0]
    assert np.diff([0.0, *begun]) == pytest.approx(ORBIT / 12.0 + 80.0, abs=60.0)
    assert len(begun) == 2


def test_a_plan_without_a_wheel_that_is_poor_is_challenged_all_the_time():
    """160 deg off, and no motion comes back."""
    assert searching([1.8, -2.0, 0.6]).mean() > 0.6
