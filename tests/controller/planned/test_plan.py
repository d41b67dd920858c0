"""The plan: motion and its derivatives against SciPy, the limits, the cost, and an optimiser of another kind."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import lsq_linear, minimize
from scipy.spatial.transform import Rotation

from . import core, motion

R0, V0 = np.array([6.971e6, 0.0, 0.0]), np.array([0.0, -1052.3891, 7488.1109])
FULL_J = np.array([[2.13, 0.11, -0.07], [0.11, 3.04, 0.19], [-0.07, 0.19, 3.09]])
SATELLITE = core.Satellite(J=FULL_J, disturbance_B=np.array([1e-5, -2e-5, 3e-5]), residual_B=np.array([0.1, 0.2, -0.3]))
NUTATING = replace(SATELLITE, wheel_momentum_max=0.3)
"""At its limit by 5 rad in T = 50 s, so its stages are implicit."""
AHEAD = core.Ahead(R0, V0)


def turned(seed):
    return Rotation.random(random_state=seed).as_matrix()


def around(seed=0):
    rng = np.random.default_rng(seed)
    r = rng.normal(size=3)
    return core.Around(rng.normal(size=3) * 3e-5, r / np.linalg.norm(r), core.MU / 6.971e6**3)


def state(seed=0, rate=0.05):
    rng = np.random.default_rng(seed)
    return core.Motion(turned(seed), rng.normal(size=3) * rate, rng.uniform(-0.02, 0.02))


def reference(satellite, a):
    return motion.Surroundings(satellite.J, a.B_N, a.r_hat_N, a.rate_squared, satellite.disturbance_B)


def flown(satellite, a, x, u, h):
    """The motion after h by SciPy, in the quaternion of R."""
    s = reference(satellite, a)
    m_B, dl = np.asarray(u[:3]) @ satellite.rods + satellite.residual_B, u[3] * satellite.wheel_torque_max

    def rates(t, y):
        q, Omega, h_w = y[:4], y[4:7], y[7]
        R = Rotation.from_quat(q).as_matrix()
        dq = 0.5 * (Rotation.from_quat(q).as_quat() @ _right(Omega))
        return [*dq, *motion.rate_of_change(s, R, Omega, h_w, m_B, dl), dl]

    start = [*Rotation.from_matrix(x.R).as_quat(), *x.Omega, x.h_w]
    end = solve_ivp(rates, (0.0, h), start, rtol=1e-11, atol=1e-13, method="DOP853").y[:, -1]
    return core.Motion(Rotation.from_quat(end[:4]).as_matrix(), end[4:7], end[7])


def _right(w):
    """q (x, y, z, s) times (w, 0), as a row times a matrix."""
    x, y, z = w
    return np.array([[0, -z, y, -x], [z, 0, -x, -y], [-y, x, 0, -z], [x, y, z, 0]], float)


def errors(x, y):
    """Of y from x: attitude in the body axes of x, rate, wheel momentum."""
    return np.array([*Rotation.from_matrix(x.R.T @ y.R).as_rotvec(), *(y.Omega - x.Omega), y.h_w - x.h_w])


# ------------------------------------------------------------------------------------------- motion


@pytest.mark.parametrize("seed", range(20))
def test_the_acceleration_is_that_of_the_equations(seed, rng):
    x, a, u = state(seed), around(seed), rng.uniform(-1, 1, 4)
    expected = motion.rate_of_change(
        reference(SATELLITE, a),
        x.R,
        x.Omega,
        x.h_w,
        u[:3] @ SATELLITE.rods + SATELLITE.residual_B,
        u[3] * SATELLITE.wheel_torque_max,
    )
    assert core.acceleration(SATELLITE, a, x, u) == pytest.approx(expected, rel=1e-12, abs=1e-18)


def test_the_equations_conserve_the_total_momentum_without_torque_from_outside():
    """R (J Omega + l e1) in N is at rest while the wheel spins up: no term is lost and no sign is turned."""
    free = motion.Surroundings(FULL_J, np.zeros(3), np.array([1.0, 0, 0]), 0.0, np.zeros(3))
    x = state(3)
    dOmega = motion.rate_of_change(free, x.R, x.Omega, x.h_w, np.zeros(3), 2e-3)
    Pi = FULL_J @ x.Omega + x.h_w * motion.E1
    assert np.cross(x.Omega, Pi) + FULL_J @ dOmega + 2e-3 * motion.E1 == pytest.approx(np.zeros(3), abs=1e-17)


def test_the_gravity_gradient_of_the_equations_is_that_of_two_masses():
    """Four points on two axes in the field of a point mass: their torque to the first order in size over distance."""
    masses, r = np.array([1.5, 1.5, 0.8, 0.8]), np.array([3e6, -4e6, 5e6])
    at = np.array([[0.3, 0, 0.4], [-0.3, 0, -0.4], [0.5, -0.6, 0.1], [-0.5, 0.6, -0.1]])
    J = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, at, strict=True))
    R = turned(9)
    pulls = [-core.MU * m * (r + R @ p) / np.linalg.norm(r + R @ p) ** 3 for m, p in zip(masses, at, strict=True)]
    torque = sum(np.cross(p, R.T @ f) for p, f in zip(at, pulls, strict=True))
    d = np.linalg.norm(r)
    s = motion.Surroundings(J, np.zeros(3), r / d, core.MU / d**3, np.zeros(3))
    assert J @ motion.rate_of_change(s, R, np.zeros(3), 0.0, np.zeros(3), 0.0) == pytest.approx(torque, rel=1e-6)


@pytest.mark.parametrize("satellite", [SATELLITE, NUTATING], ids=["explicit", "implicit"])
@pytest.mark.parametrize("seed", range(4))
def test_a_stage_comes_to_scipys_motion_in_second_order(seed, satellite, rng):
    x, a, u = state(seed), around(seed), rng.uniform(-0.9, 0.9, 4)
    exact = flown(satellite, a, x, u, 4.0)
    sizes = []
    for n in (2, 4, 8, 16):
        y = x
        for _ in range(n):
            y = core.advanced(satellite, a, y, u, 4.0 / n)
        sizes.append(np.abs(errors(exact, y)).max())
    ratios = [before / after for before, after in pairwise(sizes)]
    assert ratios[-1] == pytest.approx(4.0, rel=0.15)
    assert sizes[-1] < (2e-5 if satellite is SATELLITE else 5e-5)


@pytest.mark.parametrize("h", [1.0, 8.0, 16.0, 50.0])
@pytest.mark.parametrize("axis", np.eye(3), ids=["e1", "e2", "e3"])
def test_nutation_neither_grows_nor_decays_however_long_a_stage_is(axis, h):
    """Of a 1U with its wheel at the limit; without torque its energy is constant, of which a stage of 16 s turns it by 7 rad."""
    satellite = core.Satellite(np.diag([2.47e-3, 2.47e-3, 2.17e-3]), 0.2 * np.eye(3), axis, 1e-4, 1e-3, dipole_max=0.2)
    free = core.Around(np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.0)
    across = np.array([1.0, 1.0, 1.0]) - axis
    x = core.Motion(np.eye(3), 1e-4 * across, 1e-3)
    energies = []
    for _ in range(200):
        energies.append(x.Omega @ satellite.J @ x.Omega)
        x = core.advanced(satellite, free, x, np.zeros(4), h)
    assert energies == pytest.approx([energies[0]] * 200, rel=0.05)


def test_the_wheel_stops_at_its_limit():
    x = core.Motion(np.eye(3), np.zeros(3), 0.029)
    for h in (0.5, 5.0, 25.0):
        assert core.advanced(SATELLITE, around(), x, [0, 0, 0, 1.0], h).h_w <= 0.03 * (1 + 1e-12)
    beyond = core.Motion(np.eye(3), np.zeros(3), 0.035)  # a wheel that is past its limit is brought back
    assert core.advanced(SATELLITE, around(), beyond, [0, 0, 0, 1.0], 10.0).h_w == pytest.approx(0.03)


def differences(x, a, u, h, satellite=SATELLITE):
    """A (7, 7) and G (7, 4) of a stage by differences of its motion."""

    def shifted(d):
        return core.Motion(x.R @ Rotation.from_rotvec(d[:3]).as_matrix(), x.Omega + d[3:6], x.h_w + d[6])

    def motion_of(d, v):
        return core.advanced(satellite, a, shifted(d), v, h)

    size, none = 1e-5, np.zeros(7)
    A = [errors(motion_of(-size * e, u), motion_of(size * e, u)) for e in np.eye(7)]
    G = [errors(motion_of(none, u - size * e), motion_of(none, u + size * e)) for e in np.eye(4)]
    return np.column_stack(A) / (2 * size), np.column_stack(G) / (2 * size)


@pytest.mark.parametrize("satellite", [SATELLITE, NUTATING], ids=["explicit", "implicit"])
@pytest.mark.parametrize("seed", range(5))
def test_a_stages_derivatives_come_to_the_differences_of_its_motion_in_third_order(seed, satellite):
    x, a, u = state(seed, 0.03), around(seed), np.random.default_rng(seed).uniform(-0.5, 0.5, 4)
    parts = [slice(0, 3), slice(3, 6), slice(6, 7)]
    off = []
    for h in (2.0, 1.0):
        found, expected = core.linearised(satellite, a, x, u, h), differences(x, a, u, h, satellite)
        A, G = (np.abs(f - e) for f, e in zip(found, expected, strict=True))
        off.append([*(A[r, c].max() for r in parts for c in parts), *(G[r].max() for r in parts)])
    assert max(off[1]) < 0.01
    for before, after in zip(*off, strict=True):
        assert after < before / 6.0 or before < 1e-8


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
    """First-order optimality of the converged plan, by differences of its cost: inside the box no slope, at a bound none inward."""
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
