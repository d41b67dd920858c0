"""The bounded allocator: SciPy on the whole problem, closed forms, the paper's allocator as its limit, and its laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import allocator
from allocator import bounded
from fmus.interface import load
from tests.blocks import inputs, parameters
from tests.native.driver import Instance

BLOCK = "allocator_bounded"
P = parameters(BLOCK)
RNG = np.random.default_rng(8)
E1 = np.array([1.0, 0.0, 0.0])


def unit(x):
    return np.asarray(x, float) / np.linalg.norm(x)


def given(u, p=P):
    return bounded.outputs(bounded.State(0.0), u, p)


def commands(y):
    return np.array([*y.dipole_cmd, y.wheel_torque_cmd])


def torque(y, u, p=P):
    """Of the commands on the body [14] [16], by NumPy's cross products."""
    rods = np.cross(y.dipole_cmd @ p.U, u.b_B)
    return rods - y.wheel_torque_cmd * E1 - u.h_w * np.cross(u.omega_B, E1)


FIELDS = {
    "any": lambda rng: rng.normal(size=3) * 3e-5,
    "normal to the wheel": lambda rng: np.array([0.0, *rng.normal(size=2)]) * 3e-5,
    "along the wheel": lambda rng: rng.choice([-3e-5, 3e-5]) * E1,
    "along a rod": lambda rng: 3e-5 * P.U[rng.integers(3)],
    "weak": lambda rng: rng.normal(size=3) * 10.0 ** rng.uniform(-11.0, -6.0),
    "none": lambda rng: np.zeros(3),
}


def problem(rng, kind, tuned=True):
    """Inputs and parameters: demands from those that are met to ten times too large, wheels still, running and full."""
    free = rng.random() < 0.5
    u = inputs(
        BLOCK,
        tau_cmd_B=rng.normal(size=3) * 10.0 ** rng.uniform(-6.0, -2.0),
        b_B=FIELDS[kind](rng),
        omega_B=rng.normal(size=3) * 0.05,
        h_w=rng.choice([0.0, 0.03, -0.03, 0.0299, rng.uniform(-0.03, 0.03), 0.04, -0.05]),
        **({} if free else {"dipole_ff": rng.uniform(-30.0, 30.0, 3), "wheel_torque_ff": rng.uniform(-4e-3, 4e-3)}),
    )
    if not tuned:
        return u, P
    rods = np.array([unit(v) for v in rng.normal(size=(3, 3))]) if kind != "along a rod" else P.rod_axes
    p = replace(P, rod_axes=rods, rod_weight=10.0 ** rng.uniform(-7, -6), wheel_weight=rng.uniform(0.0, 0.3))
    return u, replace(p, command_period=rng.choice([0.1, 5.0, 30.0]), wheel_weight_ff=rng.uniform(0.0, 0.3))


PROBLEMS = {kind: [problem(RNG, kind) for _ in range(300)] for kind in FIELDS}


def cost_and_box(u, p):
    """The problem as the interface states it, in A m2 and N m: residuals as a matrix and a vector, and the box."""
    e = np.eye(4)
    with_wheel = abs(u.wheel_torque_ff) < 1e9
    m_p = np.clip(u.dipole_ff, -25.0, 25.0) if np.abs(u.dipole_ff).max() < 1e9 else np.zeros(3)
    m_p = m_p if np.any(u.b_B) else np.zeros(3)
    low, high = -p.wheel_torque_max, p.wheel_torque_max
    if u.h_w + p.command_period * high > p.wheel_momentum_max:
        high = max((p.wheel_momentum_max - u.h_w) / p.command_period, 0.0)
    if u.h_w + p.command_period * low < -p.wheel_momentum_max:
        low = min((-p.wheel_momentum_max - u.h_w) / p.command_period, 0.0)
    d_p = np.clip(u.wheel_torque_ff if with_wheel else -u.h_w / p.desaturation_time, low, high)
    w_w = p.wheel_weight_ff if with_wheel else p.wheel_weight
    gains = u.rod_gains if np.abs(u.rod_gains).max() < 1e9 else np.ones(3)
    by_actuator = [gain * np.cross(axis, u.b_B) for gain, axis in zip(gains, p.U, strict=True)] + [-E1]
    A = np.vstack([np.column_stack(by_actuator), p.rod_weight * e[:3], w_w * e[3:]])
    r = u.tau_cmd_B + u.h_w * np.cross(u.omega_B, E1)
    y = np.concatenate([r, p.rod_weight * m_p, [w_w * d_p]])
    return A, y, np.array([-25.0, -25.0, -25.0, low]), np.array([25.0, 25.0, 25.0, high])


@pytest.mark.parametrize("kind", FIELDS)
def test_scipy_finds_no_better_commands_within_the_limits(kind):
    same = 0
    for u, p in PROBLEMS[kind]:
        A, y, low, high = cost_and_box(u, p)
        x = commands(given(u, p))
        assert ((low - 1e-15 <= x) & (x <= high + 1e-15)).all()
        scale = np.array([25.0, 25.0, 25.0, 3e-3])
        z = lsq_linear(A * scale, y, (low / scale, high / scale), method="bvls", tol=1e-15).x * scale
        ours, theirs = (np.sum((A @ v - y) ** 2) for v in (x, z))
        assert ours <= theirs * (1.0 + 1e-9) + 1e-28
        same += bool(np.abs((x - z) / scale).max() < 1e-6)
    assert same > 285  # SciPy stops early now and then


@pytest.mark.parametrize("kind", FIELDS)
def test_the_residual_is_the_demand_less_what_the_commands_give(kind):
    for u, p in PROBLEMS[kind]:
        y = given(u, p)
        np.testing.assert_allclose(y.tau_residual_B, u.tau_cmd_B - torque(y, u, p), rtol=0, atol=1e-17)


@pytest.mark.parametrize("kind", FIELDS)
def test_every_output_is_finite_and_never_held(kind):
    for u, p in PROBLEMS[kind]:
        y = given(u, p)
        for variable in load(BLOCK).of("output"):
            assert np.shape(getattr(y, variable.name)) == variable.shape
            assert np.isfinite(getattr(y, variable.name)).all()
        assert y.holding is False


def test_without_limits_in_the_way_it_is_the_closed_form_of_weighted_least_squares(rng):
    """x = p + W^-2 A^T (A W^-2 A^T + I)^-1 (r - A p), by the push-through identity."""
    compared = 0
    for u, p in (problem(rng, k) for k in ("any", "normal to the wheel", "weak") for _ in range(200)):
        u = replace(u, tau_cmd_B=1e-5 * unit(u.tau_cmd_B), h_w=rng.uniform(-5e-3, 5e-3), omega_B=np.zeros(3))
        p = replace(p, wheel_weight=0.1, wheel_weight_ff=0.1, command_period=0.5)
        A, y, low, high = cost_and_box(u, p)
        inverse = np.diag(np.array([p.rod_weight, p.rod_weight, p.rod_weight, 0.1]) ** -2)
        wanted = y[3:] / [p.rod_weight, p.rod_weight, p.rod_weight, 0.1]
        T = A[:3]
        x = wanted + inverse @ T.T @ np.linalg.solve(T @ inverse @ T.T + np.eye(3), y[:3] - T @ wanted)
        if ((low < x) & (x < high)).all():
            np.testing.assert_allclose(commands(given(u, p)) / [25, 25, 25, 3e-3], x / [25, 25, 25, 3e-3], atol=1e-8)
            compared += 1
    assert compared > 250


def test_with_small_weights_it_becomes_the_papers_allocation():
    """Which is another method: wheel along the field, least dipoles across it. What differs goes with the square of the weight."""
    paper = parameters("allocator", hold_fraction=1.0)
    differences = []
    for weight in (1e-6, 1e-7):
        p = replace(P, rod_weight=weight, wheel_weight=1e4 * weight)
        worst = 0.0
        for b, tau in zip(*np.random.default_rng(5).normal(size=(2, 100, 3)), strict=True):
            b = 4e-5 * unit([1.0 + abs(b[0]), b[1], b[2]])
            u = inputs(BLOCK, tau_cmd_B=1e-4 * unit(tau), b_B=b, omega_B=[0.02, -0.01, 0.03], h_w=1e-3)
            v = allocator.Inputs(u.tau_cmd_B, u.b_B, u.omega_B, u.h_w)
            z = allocator.outputs(allocator.start(paper, v), v, paper)
            assert not z.holding
            y = given(u, p)
            worst = max(worst, np.abs((commands(y) - commands(z)) / [25, 25, 25, 3e-3]).max())
            assert y.demand_fraction == pytest.approx(z.demand_fraction, abs=2 * worst)
            assert y.b_wheel == z.b_wheel
        differences.append(worst)
    assert differences[0] / differences[1] == pytest.approx(100.0, rel=0.1)
    assert differences[1] < 1e-4


def test_dipoles_by_hand():
    # Field along z, rods along the axes, no wheel: m = (-tau_y, tau_x)/B, less w_r^2/(B^2 + w_r^2) of it; none along z.
    p = replace(P, rod_axes=np.eye(3), rod_weight=4e-6, wheel_torque_max=1e-12)
    u = inputs(BLOCK, tau_cmd_B=[2e-4, 1e-4, 5e-3], b_B=[0.0, 0.0, 4e-5])
    less = 1.0 - 0.01 / 1.01
    np.testing.assert_allclose(given(u, p).dipole_cmd, [-2.5 * less, 5.0 * less, 0.0], rtol=1e-6, atol=1e-9)


def test_a_demand_along_the_wheel_in_a_field_along_it_is_the_wheels_alone():
    u = inputs(BLOCK, tau_cmd_B=[1e-3, 0.0, 0.0], b_B=[3e-5, 0.0, 0.0])
    y = given(u, replace(P, wheel_weight=0.2))
    np.testing.assert_allclose(y.dipole_cmd, 0.0, atol=1e-12)
    assert y.wheel_torque_cmd == pytest.approx(-1e-3 / 1.04)


def test_feed_forward_decides_where_torque_does_not(rng):
    """Of a moment along the field nothing is felt: the preferred dipole comes through, and the torque stays."""
    compared = 0
    for _ in range(100):
        u, _ = problem(rng, "any", tuned=False)
        u = replace(u, tau_cmd_B=1e-4 * unit(u.tau_cmd_B), omega_B=np.zeros(3), h_w=0.0)
        b = unit(u.b_B) * 3e-5
        along = np.linalg.solve(P.U.T, rng.uniform(-6.0, 6.0) * unit(b))  # dipoles whose moment lies along the field
        absent = replace(u, b_B=b, dipole_ff=np.full(3, 1e9), wheel_torque_ff=0.0)
        with_it = replace(absent, dipole_ff=along)
        y, z = given(absent), given(with_it)
        if max(y.demand_fraction, z.demand_fraction) < 1.0:
            moved = z.dipole_cmd - y.dipole_cmd
            null = np.linalg.solve(P.U.T, unit(b))
            null /= np.linalg.norm(null)
            np.testing.assert_allclose(moved, (along @ null) * null, rtol=0, atol=1e-6)
            np.testing.assert_allclose(torque(z, with_it), torque(y, absent), rtol=0, atol=1e-13)
            compared += 1
    assert compared > 90


def test_a_plan_that_gives_the_demand_is_followed(rng):
    for _ in range(100):
        u, _ = problem(rng, "any", tuned=False)
        m, d = rng.uniform(-25.0, 25.0, 3), rng.uniform(-3e-3, 3e-3)
        u = replace(u, dipole_ff=m, wheel_torque_ff=d, h_w=0.01)
        planned = torque(replace(given(u), dipole_cmd=m, wheel_torque_cmd=d), u)
        y = given(replace(u, tau_cmd_B=planned))
        np.testing.assert_allclose(y.dipole_cmd, m, rtol=0, atol=1e-9)
        assert y.wheel_torque_cmd == pytest.approx(d, abs=1e-12)
        assert y.demand_fraction <= 1.0 + 1e-9


@pytest.mark.parametrize("size", [1e9, -1e9, 3e12])
def test_one_element_at_1e9_disconnects_a_feed_forward(size, rng):
    u, _ = problem(rng, "any", tuned=False)
    absent = replace(u, dipole_ff=np.full(3, 1e9), wheel_torque_ff=1e9)
    for i in range(3):
        dipole = np.array([3.0, -2.0, 5.0])
        dipole[i] = size
        np.testing.assert_array_equal(
            commands(given(replace(absent, dipole_ff=dipole))), commands(given(replace(absent, wheel_torque_ff=size)))
        )


def test_a_preference_beyond_a_limit_counts_as_the_limit(rng):
    u, _ = problem(rng, "any", tuned=False)
    u = replace(u, h_w=0.0)
    beyond = replace(u, dipole_ff=np.array([99.0, -25.1, 3.0]), wheel_torque_ff=1.0)
    at = replace(u, dipole_ff=np.array([25.0, -25.0, 3.0]), wheel_torque_ff=0.003)
    np.testing.assert_array_equal(commands(given(beyond)), commands(given(at)))
    hurried = replace(P, desaturation_time=1e-3)
    u = replace(u, h_w=0.02, dipole_ff=np.full(3, 1e9))
    np.testing.assert_array_equal(
        commands(given(replace(u, wheel_torque_ff=1e9), hurried)),
        commands(given(replace(u, wheel_torque_ff=-0.003), replace(P, wheel_weight_ff=P.wheel_weight))),
    )


def test_a_running_wheel_is_drawn_to_rest_at_the_price_stated():
    """The share w^2/(w^2 + b1^2) of -l/T, where rods can make good what lies across the field."""
    for b1 in (0.0, 0.05, 0.1, 0.3, 0.8, 1.0):
        b = np.array([b1, math.sqrt(1.0 - b1**2), 0.0])
        u = inputs(BLOCK, b_B=3e-5 * b, h_w=6e-3)
        y = given(u, replace(P, rod_weight=1e-8))
        expected = -6e-3 / 60.0 * 0.01 / (0.01 + b1**2)
        assert y.wheel_torque_cmd == pytest.approx(expected, rel=1e-4)
        assert abs(y.tau_residual_B @ b) == pytest.approx(abs(b1 * expected), rel=1e-4, abs=1e-15)
        assert np.linalg.norm(y.tau_residual_B) <= 0.1 * 1e-4 / 2.0 + 1e-12


def test_renaming_rods_renames_their_dipoles(rng):
    for u, p in PROBLEMS["any"][:100]:
        order = rng.permutation(3)
        y = given(u, p)
        z = given(
            replace(u, dipole_ff=u.dipole_ff[order], rod_gains=u.rod_gains[order]),
            replace(p, rod_axes=p.rod_axes[order]),
        )
        np.testing.assert_allclose(z.dipole_cmd, y.dipole_cmd[order], rtol=0, atol=1e-7)
        np.testing.assert_allclose(z.wheel_torque_cmd, y.wheel_torque_cmd, rtol=0, atol=1e-11)


def test_turning_a_rod_end_for_end_turns_its_dipole_over():
    for u, p in PROBLEMS["any"][:100]:
        signs = np.array([1.0, -1.0, 1.0])
        y = given(u, p)
        z = given(
            replace(u, dipole_ff=signs * u.dipole_ff if np.abs(u.dipole_ff).max() < 1e9 else u.dipole_ff),
            replace(p, rod_axes=p.rod_axes * signs[:, None]),
        )
        np.testing.assert_allclose(z.dipole_cmd, signs * y.dipole_cmd, rtol=0, atol=1e-7)


def test_with_gains_of_the_rods_scipy_finds_no_better_commands(rng):
    for u, p in PROBLEMS["any"][:100]:
        known = replace(u, rod_gains=rng.choice([0.0, -1.0, 0.5, 0.9, 1.1], 3))
        A, y, low, high = cost_and_box(known, p)
        scale = np.array([25.0, 25.0, 25.0, 3e-3])
        best = lsq_linear(A * scale, y, (low / scale, high / scale), method="bvls", tol=1e-15).cost
        assert 0.5 * np.sum((A @ commands(given(known, p)) - y) ** 2) <= best * (1.0 + 1e-9) + 1e-22


def test_a_reversed_rod_gets_the_opposite_dipole_and_a_dead_one_what_is_preferred():
    u = inputs(
        BLOCK, tau_cmd_B=[2e-4, -1e-4, 3e-4], b_B=[2e-5, 1e-5, -3e-5], dipole_ff=[1.0, -2.0, 3.0], wheel_torque_ff=0.0
    )
    sound = given(u)
    turned = given(replace(u, dipole_ff=u.dipole_ff * [1, -1, 1], rod_gains=np.array([1.0, -1.0, 1.0])))
    np.testing.assert_allclose(turned.dipole_cmd, sound.dipole_cmd * [1, -1, 1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(turned.tau_residual_B, sound.tau_residual_B, rtol=0, atol=1e-15)
    dead = given(replace(u, rod_gains=np.array([1.0, 1.0, 0.0])))
    assert dead.dipole_cmd[2] == pytest.approx(3.0)
    by_two = np.cross(P.U[:2].T @ dead.dipole_cmd[:2], u.b_B) - dead.wheel_torque_cmd * E1
    np.testing.assert_allclose(dead.tau_residual_B, u.tau_cmd_B - by_two, rtol=0, atol=1e-15)


def test_a_weak_rod_gives_all_that_it_has():
    """Of a demand along what the rod gives, the command of one at 0.9 is 1/0.9 of that of a sound one, up to the limit."""
    b = np.array([0.0, 0.0, 3e-5])
    along = np.cross(P.U[0], b)
    u = inputs(BLOCK, tau_cmd_B=20.0 * along, b_B=b, dipole_ff=[20.0, 0.0, 0.0], wheel_torque_ff=0.0)
    weak = replace(u, rod_gains=np.array([0.9, 1.0, 1.0]))
    y = given(replace(weak, dipole_ff=np.array([20.0 / 0.9, 0.0, 0.0])))
    assert y.dipole_cmd[0] == pytest.approx(20.0 / 0.9, rel=1e-6)
    assert np.linalg.norm(y.tau_residual_B) < 1e-12


def test_turning_the_satellite_about_the_wheel_turns_nothing_that_is_commanded():
    c, s = math.cos(0.7), math.sin(0.7)
    Q = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    for u, p in PROBLEMS["any"][:100]:
        v = replace(u, tau_cmd_B=Q @ u.tau_cmd_B, b_B=Q @ u.b_B, omega_B=Q @ u.omega_B)
        y, z = given(u, p), given(v, replace(p, rod_axes=p.rod_axes @ Q.T))
        np.testing.assert_allclose(commands(z) / [25, 25, 25, 3e-3], commands(y) / [25, 25, 25, 3e-3], atol=1e-7)


def test_a_satellite_of_another_size_gets_the_same_shares_of_its_limits():
    """Torques, dipoles and momenta times 50 with the same field: the weights need no change."""
    k = 50.0
    for u, p in PROBLEMS["any"][:100]:
        ff = {"dipole_ff": k * u.dipole_ff, "wheel_torque_ff": k * u.wheel_torque_ff}
        v = replace(u, tau_cmd_B=k * u.tau_cmd_B, h_w=k * u.h_w, **(ff if abs(u.wheel_torque_ff) < 1e9 else {}))
        q = replace(p, dipole_max=k * p.dipole_max, wheel_torque_max=k * p.wheel_torque_max)
        q = replace(q, wheel_momentum_max=k * p.wheel_momentum_max)
        np.testing.assert_allclose(
            commands(given(v, q)) / [25, 25, 25, 3e-3], k * commands(given(u, p)) / [25, 25, 25, 3e-3], atol=k * 1e-7
        )


def test_a_limit_that_does_not_act_has_no_say():
    """Of small demands, without preferences, and where no torque of the motor fills the wheel in a period."""
    compared = 0
    for u, p in PROBLEMS["any"]:
        u = replace(u, tau_cmd_B=0.02 * u.tau_cmd_B, h_w=0.2 * u.h_w, dipole_ff=np.full(3, 1e9), wheel_torque_ff=1e9)
        p = replace(p, command_period=0.5)
        y = given(u, p)
        if y.demand_fraction < 0.99:
            z = given(u, replace(p, dipole_max=1e9, wheel_torque_max=1e9, wheel_momentum_max=1e9))
            np.testing.assert_allclose(commands(z), commands(y), rtol=1e-6, atol=1e-9)
            compared += 1
    assert compared > 100


def test_what_is_given_never_works_against_the_demand():
    """Without preferences, of a wheel at rest; it holds for any demand since giving nothing is allowed."""
    for kind in FIELDS:
        for u, p in PROBLEMS[kind]:
            u = replace(u, h_w=0.0, dipole_ff=np.full(3, 1e9), wheel_torque_ff=1e9)
            t = torque(given(u, p), u, p)
            assert t @ u.tau_cmd_B >= t @ t - 1e-18


def test_a_larger_demand_is_served_no_worse_and_its_direction_may_turn(rng):
    b, turned = np.array([2e-5, 1e-5, -3e-5]), 0.0
    for direction in rng.normal(size=(50, 3)):
        gained = 0.0
        for size in (1e-5, 1e-4, 1e-3, 1e-2, 1e-1):
            u = inputs(BLOCK, tau_cmd_B=size * unit(direction), b_B=b)
            t = torque(given(u), u)
            assert t @ unit(direction) >= gained - 1e-9
            gained = t @ unit(direction)
        turned = max(turned, 1.0 - gained / np.linalg.norm(t))
    assert turned > 0.1


def test_commands_are_continuous_where_the_field_passes_the_normal_to_the_wheel():
    """Where the paper's law is singular and holds."""
    tau = np.array([1e-4, 2e-4, -1e-4])
    last, steps = None, []
    for b1 in np.linspace(-0.01, 0.01, 501):
        u = inputs(BLOCK, tau_cmd_B=tau, b_B=3e-5 * unit([b1, 0.6, 0.8]), omega_B=[0.01, 0.02, 0.0], h_w=0.004)
        now = commands(given(u)) / [25, 25, 25, 3e-3]
        steps.append(0.0 if last is None else np.abs(now - last).max())
        last = now
    assert max(steps) < 4e-3
    u = inputs(BLOCK, tau_cmd_B=tau, b_B=3e-5 * np.array([0.0, 0.6, 0.8]))
    # All of it across the field is given, nothing along.
    b = np.array([0.0, 0.6, 0.8])
    np.testing.assert_allclose(given(u).tau_residual_B, (tau @ b) * b, rtol=0, atol=2e-3 * np.linalg.norm(tau))


def test_without_a_field_only_the_wheel_acts():
    for b_B in ([0.0, 0.0, 0.0], [1e-13, -1e-13, 1e-13]):
        u = inputs(BLOCK, tau_cmd_B=[1e-3, 2e-3, -1e-3], b_B=b_B, dipole_ff=[5.0, 5.0, 5.0], wheel_torque_ff=0.0)
        y = given(u, replace(P, wheel_weight_ff=0.0))
        np.testing.assert_array_equal(y.dipole_cmd, 0.0)
        assert y.wheel_torque_cmd == pytest.approx(-1e-3)
        np.testing.assert_allclose(y.tau_residual_B, [0.0, 2e-3, -1e-3], atol=1e-15)
        assert y.b_wheel == 0.0


def test_nothing_wanted_of_a_still_wheel_is_nothing_commanded(rng):
    for kind in FIELDS:
        u = inputs(BLOCK, b_B=FIELDS[kind](rng), omega_B=[0.1, 0.2, 0.3])
        y = given(u)
        np.testing.assert_array_equal(commands(y), 0.0)
        np.testing.assert_array_equal(y.tau_residual_B, 0.0)
        assert y.demand_fraction == 0.0


@pytest.mark.parametrize("period", [0.1, 0.5, 12.0])
def test_the_wheel_meets_its_momentum_limit_at_the_end_of_the_period_and_not_before(period):
    p = replace(P, command_period=period)
    for h_w in (0.0299, 0.03 - 1e-3 * period, 0.03, 0.0, -0.02):
        u = inputs(BLOCK, tau_cmd_B=[-0.05, 0.0, 0.0], b_B=[3e-5, 0.0, 0.0], h_w=h_w)
        expected = min(0.003, (0.03 - h_w) / period)
        assert given(u, p).wheel_torque_cmd == pytest.approx(expected, rel=1e-12, abs=1e-18)
        mirrored = replace(u, tau_cmd_B=-u.tau_cmd_B, h_w=-h_w)
        assert given(mirrored, p).wheel_torque_cmd == pytest.approx(-expected, rel=1e-12, abs=1e-18)


def test_a_wheel_past_its_limit_is_not_driven_further_and_may_come_back():
    b = [3e-5, 0.0, 0.0]
    for h_w in (0.03 + 1e-17, 0.031, 0.1):
        out, back = (inputs(BLOCK, tau_cmd_B=[tau, 0.0, 0.0], b_B=b, h_w=h_w) for tau in (-1e-3, 1e-3))
        assert given(out).wheel_torque_cmd == 0.0
        assert given(back).wheel_torque_cmd == pytest.approx(-1e-3 / 1.01 - 0.01 / 1.01 * h_w / 60.0)


@pytest.mark.fly
def test_the_wheel_never_passes_its_limit_on_the_plant_over_hours():
    """A tumbling satellite whose demand would fill the wheel at once: the plant itself never has to cut its torque."""
    near, full, expected, h = 0, 0.0, 0.0, 2.0
    with Instance("plant") as body, Instance(BLOCK) as law:
        body.set("omega_B0", [0.01, 0.02, -0.015])
        body.set("drag", False)
        law.set("command_period", h)
        law.set("wheel_weight", 0.0)
        body.initialize()
        law.initialize()
        for k in range(5400):  # three hours
            body.step(h * k, h)
            h_w = body.get("h_w")
            assert h_w == pytest.approx(expected, abs=1e-16)
            full, near = max(full, abs(h_w)), near + (abs(h_w) > 0.029)
            for name in ("b_B", "omega_B", "h_w"):
                law.set(name, body.get(name))
            law.set("tau_cmd_B", 2e-3 * np.array([math.cos(1e-3 * k), 0.3, math.sin(0.05 * k)]))
            law.step(h * k, h)
            for name in ("dipole_cmd", "wheel_torque_cmd"):
                body.set(name, law.get(name))
            expected = h_w + h * law.get("wheel_torque_cmd")
    assert near > 500
    assert full == pytest.approx(0.03, abs=1e-16)


@pytest.mark.filterwarnings("ignore:overflow|invalid:RuntimeWarning")
@pytest.mark.parametrize(
    "changes",
    [
        {"tau_cmd_B": [1e12, -1e12, 1e11]},
        {"tau_cmd_B": [1e200, 0.0, 1e200]},
        {"b_B": [1e-9, 1e-200, 0.0]},
        {"b_B": [1e200, 1e200, 0.0]},
        {"h_w": 1e200},
        {"omega_B": [1e300, -1e300, 1e300]},
        {"dipole_ff": [9.9e8, -9.9e8, 0.0], "wheel_torque_ff": 9.9e8},
    ],
)
def test_absurd_inputs_give_commands_within_the_limits(changes):
    y = given(inputs(BLOCK, **({"tau_cmd_B": [1e-4, 2e-4, 0.0], "h_w": 0.01} | changes)))
    assert np.isfinite(commands(y)).all()
    assert np.abs(y.dipole_cmd).max() <= 25.0
    assert abs(y.wheel_torque_cmd) <= 0.003
    assert 0.0 <= y.demand_fraction <= 1e6
