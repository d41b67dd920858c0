"""The bounded allocator: SciPy on the whole problem, closed forms, the paper's allocator as its limit, and its laws.

Shows AB-1.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import allocator
from fmus.interface import load
from tests.blocks import inputs, parameters

from .problems import BLOCK, FIELDS, PROBLEMS, P, commands, cost_and_box, given, problem, torque, unit


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
    """Which is another method: wheel along the field, least dipoles across it. What differs goes with the square of the
    weight."""
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
