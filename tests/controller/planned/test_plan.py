"""The plan: its cost, its limits, and an optimiser of another kind."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize
from scipy.spatial.transform import Rotation

from . import core, motion
from .states import AHEAD, R0, SATELLITE, V0, flown, state, turned


@pytest.mark.parametrize("seed", range(10))
def test_the_costs_gradient_is_its_difference(seed):
    target = turned(100 + seed)
    Omega_d = np.array([0.0, -1.08e-3, 2e-4])
    x = state(seed)
    x = core.Motion(x.R, x.Omega, [0.01, 0.0295, -0.0298][seed % 3])

    def cost(d):
        y = core.Motion(x.R @ Rotation.from_rotvec(d[:3]).as_matrix(), x.Omega + d[3:6], x.h_w + d[6])
        return core.cost_rate(SATELLITE, target, Omega_d, y)[0]

    gradient = core.cost_rate(SATELLITE, target, Omega_d, x)[1]
    steps = np.array([1e-5] * 3 + [1e-6] * 3 + [1e-6])
    expected = [(cost(s * e) - cost(-s * e)) / (2 * s) for s, e in zip(steps, np.eye(7), strict=True)]
    assert gradient == pytest.approx(expected, rel=1e-5, abs=1e-4)


def test_at_the_target_with_the_wheel_at_rest_nothing_is_to_be_paid():
    R_d, Omega_d = turned(1), np.array([0.0, -1.08e-3, 0.0])
    cost, gradient = core.cost_rate(SATELLITE, R_d, Omega_d, core.Motion(R_d, Omega_d, 0.0))
    assert cost == pytest.approx(0.0, abs=1e-15)
    assert gradient == pytest.approx(np.zeros(7), abs=1e-10)


def test_controls_for_a_torque_are_scipys_least_squares(rng):
    for _ in range(100):
        tau, B, h_w = rng.normal(size=3) * 2e-3, rng.normal(size=3) * 3e-5, rng.uniform(-0.03, 0.03)
        u = core.controls_for(SATELLITE, tau, B, h_w)
        A = np.column_stack((np.cross(SATELLITE.rods, B).T, -SATELLITE.wheel_torque_max * motion.E1))
        best = lsq_linear(A, tau, (-1, 1), tol=1e-14)
        assert np.abs(u).max() <= 1.0
        assert np.linalg.norm(A @ u - tau) <= np.linalg.norm(A @ best.x - tau) + 3e-5


# ------------------------------------------------------------------------------------------- plans


def starts():
    """Attitudes of any kind, 0.06 N m s of momentum and less, as at the handover."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        Omega = rng.normal(size=3)
        yield core.Motion(turned(seed), 0.018 * Omega / np.linalg.norm(Omega), rng.uniform(-0.01, 0.01))


@pytest.mark.parametrize("rate", [0.0, 0.008, 0.02])
def test_iterations_never_cost_more_and_the_plan_keeps_its_limits(rate):
    for x in starts():
        costs = []
        for n in (0, 1, 2, 3, 5, 10, 20, 60):
            plan = core.plan(SATELLITE, AHEAD, x, n, rate)
            costs.append(plan.cost)
            assert np.abs(plan.u).max() <= 1.0
            assert max(abs(y.h_w) for y in plan.path) <= SATELLITE.wheel_momentum_max * (1 + 1e-9)
        assert all(after <= before for before, after in pairwise(costs))
        assert costs[-1] < 0.8 * costs[0]


def test_the_plans_end_is_near_the_target_with_room_left_in_the_wheel():
    for x in starts():
        best = min(
            (core.plan(core.Satellite(), AHEAD, x, 60, rate) for rate in (0.0, 0.008, 0.02)), key=lambda p: p.cost
        )
        end = best.path[-1]
        _, R_d, Omega_d = core.around(AHEAD, best.h.sum())
        assert best.h.sum() == pytest.approx(1500.0)
        assert Rotation.from_matrix(R_d.T @ end.R).magnitude() < math.radians(2.0)
        assert np.linalg.norm(end.Omega - end.R.T @ R_d @ Omega_d) < 1e-3
        assert abs(end.h_w) < 0.02


def test_a_plan_that_scipy_flies_without_feedback_stays_near_its_path():
    """The slew of 300 s in stages of 10 s by an integrator without their error."""
    x = next(starts())
    plan = core.plan(SATELLITE, AHEAD, x, 60, 0.008)
    y, t, largest = x, 0.0, 0.0
    for i in range(30):  # 300 s: the slew
        y = flown(SATELLITE, core.around(AHEAD, t + 0.5 * plan.h[i])[0], y, plan.u[i], plan.h[i])
        t += plan.h[i]
        largest = max(largest, Rotation.from_matrix(y.R.T @ plan.path[i + 1].R).magnitude())
    assert largest < math.radians(5.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_plan_follows_its_expected_motion_from_another_where_its_controls_alone_would_lose_it(seed):
    """A degree and 9e-4 rad/s off; from the expected motion itself both are the plan that was."""
    x = list(starts())[seed]
    plan = core.plan(SATELLITE, AHEAD, x, 60, 0.008)
    off = core.Motion(x.R @ Rotation.from_rotvec([0.0, math.radians(1.0), 0.0]).as_matrix(), x.Omega + 5e-4, x.h_w)
    assert core.followed(SATELLITE, x, x) == pytest.approx((plan.cost, plan.cost), rel=1e-12)
    alone, following = core.followed(SATELLITE, x, off)
    assert following - plan.cost < 0.1 * (alone - plan.cost)


def test_no_small_change_of_the_controls_is_cheaper(rng):
    """First-order optimality of the converged plan, by differences of its cost: inside the box no slope, at a bound
    none inward."""
    x = next(starts())
    plan = core.plan(SATELLITE, AHEAD, x, 400, 0.008)
    n, step = len(plan.h), 1e-3
    assert core.plan_cost(SATELLITE, AHEAD, x, plan.u) == pytest.approx(plan.cost, rel=1e-9)
    start = core.plan(SATELLITE, AHEAD, x, 0, 0.008)
    for i in rng.choice(n, 25, replace=False):
        for j in range(4):
            slopes = []
            for u in (start.u, plan.u):
                changed = []
                for sign in (1.0, -1.0):
                    v = u.copy()
                    v[i, j] = np.clip(v[i, j] + sign * step, -1.0, 1.0)
                    changed.append(
                        (
                            core.plan_cost(SATELLITE, AHEAD, x, v) - core.plan_cost(SATELLITE, AHEAD, x, u),
                            v[i, j] - u[i, j],
                        )
                    )
                slopes.append(max(-c / abs(d) if d else 0.0 for c, d in changed))  # gain for a unit of control
            # What could be won by moving the control a whole unit, against what the plan costs.
            assert slopes[1] < 2e-3 * plan.cost


def test_an_optimiser_of_another_kind_finds_nothing_better_nearby():
    """L-BFGS-B from the plan on the first 30 stages, with differences of the cost alone."""
    x = next(starts())
    plan = core.plan(SATELLITE, AHEAD, x, 400, 0.008)
    first = 10

    def cost(v):
        u = plan.u.copy()
        u[:first] = v.reshape(first, 4)
        return core.plan_cost(SATELLITE, AHEAD, x, u) / plan.cost

    found = minimize(
        cost, plan.u[:first].ravel(), method="L-BFGS-B", bounds=[(-1, 1)] * (4 * first), options={"maxfun": 1500}
    )
    assert found.fun > 0.995


def test_a_plan_laid_anew_goes_on_with_its_controls():
    x = next(starts())
    plan = core.plan(SATELLITE, AHEAD, x, 20, 0.008)
    h, u = core.replanned(SATELLITE, AHEAD, plan.path[1], plan, 0.0, 10.0)
    ends = np.cumsum(plan.h)
    t = 10.0
    for length, v in zip(h, u, strict=True):
        middle = t + 0.5 * length
        expected = plan.u[np.searchsorted(ends, middle, side="right")] if middle < ends[-1] else np.zeros(4)
        assert v == pytest.approx(expected, abs=0.0)
        t += length
    assert t == pytest.approx(1510.0)


@pytest.mark.parametrize("rate", [0.0, 0.03, 0.05, 0.1, 0.2, 0.45])
def test_stages_are_finer_where_the_satellite_turns_fast_and_always_cover_the_horizon(rate):
    x = core.Motion(np.eye(3), rate * np.array([0.0, 0.0, 1.0]), 0.0)
    plan = core.plan(core.Satellite(), AHEAD, x, 0)
    assert plan.h.sum() == pytest.approx(1500.0)
    assert len(plan.h) <= core.STAGES
    assert plan.h[0] == (10.0 if rate < 0.04 else 5.0 if rate < 0.08 else 2.5)


def test_a_motion_that_turns_too_far_in_a_stage_is_no_plan():
    spin = core.Motion(np.eye(3), np.array([0.0, 0.0, 5.0]), 0.0)
    plan = core.plan(core.Satellite(), AHEAD, spin, 60)
    assert plan.cost == 1e300
    assert not plan.u.any()


@pytest.mark.parametrize("wrong", ["rate", "attitude", "wheel", "target"])
def test_what_is_no_number_gives_no_plan_and_no_controls_that_are_none(wrong):
    x = core.Motion(
        np.full((3, 3), np.nan) if wrong == "attitude" else np.eye(3),
        np.full(3, np.nan) if wrong == "rate" else np.zeros(3),
        math.nan if wrong == "wheel" else 0.0,
    )
    ahead = core.Ahead(R0, V0, target=2, R_d0=np.full((3, 3), np.nan)) if wrong == "target" else AHEAD
    plan = core.plan(SATELLITE, ahead, x, 60)
    assert plan.cost == 1e300
    assert np.isfinite(plan.u).all()


def test_no_motion_to_make_costs_nothing_and_asks_for_nothing():
    """Inertial hold at rest with neither field nor torque worth the name: the zero plan is kept."""
    still = core.Ahead(np.array([4e8, 0.0, 0.0]), np.array([0.0, 900.0, 0.0]), target=2)
    plan = core.plan(core.Satellite(), still, core.Motion(np.eye(3), np.zeros(3), 0.0), 60)
    assert plan.cost < 1e-9
    assert np.abs(plan.u).max() < 1e-3


@pytest.mark.parametrize(("t", "first"), [(10.0, 0.1), (10.9, 0.1), (11.0, 0.2), (12.5, 0.3), (13.0, 0.0), (99.0, 0.0)])
def test_a_plan_gives_the_controls_of_its_stage_and_none_after_its_end(t, first):
    assert core.controls_at(t, np.full(4, 0.7)) == pytest.approx([first, 0.0, 0.0, 0.0], abs=1e-15)


def test_the_field_ahead_keeps_what_was_measured_for_a_while():
    bias = np.array([1e-6, 2e-6, -1e-6])
    with_bias = core.Ahead(R0, V0, bias_N=bias)
    shares = [(core.around(with_bias, t)[0].B_N - core.around(AHEAD, t)[0].B_N) / bias for t in (0.0, 600.0, 1200.0)]
    assert shares == pytest.approx(np.outer(np.exp([0.0, -1.0, -2.0]), np.ones(3)), rel=1e-9)


# ------------------------------------------------------------------------------------------- work of a sample


def test_a_search_over_samples_ends_at_the_plan_of_one_without_pause():
    at_once = core.search(SATELLITE, AHEAD, state(3, 0.01), 2**31 - 1)
    spread = core.search(SATELLITE, AHEAD, state(3, 0.01))
    assert at_once.calls == 1
    assert spread.calls > 5
    assert spread.cost == pytest.approx(at_once.cost, rel=1e-6)
    assert spread.u == pytest.approx(at_once.u, abs=1e-3)


@pytest.mark.parametrize("rate", [0.0, 0.01, 0.03, 0.05])
@pytest.mark.parametrize("speed", [1.0, 1.3])
def test_no_sample_takes_more_than_its_account_however_fast_the_satellite_turns_or_eccentric_its_orbit(rate, speed):
    searched = core.search(SATELLITE, core.Ahead(R0, speed * V0), state(5, rate))
    assert 0 <= searched.least < core.WORK_OF_SAMPLE / 2
    assert 3 <= searched.calls < 100
