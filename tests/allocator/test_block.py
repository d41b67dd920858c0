"""The allocator as a block: its hold, what it refuses, its steps.

Shows AL-2.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import allocator
from tests.blocks import inputs, parameters

P = parameters("allocator")
B_B = [2.3e-5, 1.1e-5, -2.9e-5]
OMEGA = [0.03, -0.05, 0.02]


def demand(scale, **changes):
    """Inputs whose demand is `scale` in units that need about a third of a limit."""
    tau = scale * np.array([1.1e-4, -0.7e-4, 1.6e-4])
    return inputs("allocator", **({"tau_cmd_B": tau, "b_B": B_B, "omega_B": OMEGA, "h_w": 0.002} | changes))


SMALL, MIDDLE, LARGE = demand(0.3), demand(0.7), demand(30.0)


def commands(y):
    return [*y.dipole_cmd, y.wheel_torque_cmd]


def achieved(y, u, p=P):
    """Torque on the body of unclipped commands, by hand."""
    e1 = np.array([1.0, 0.0, 0.0])
    return np.cross(y.dipole_cmd @ p.rod_axes, u.b_B) - y.wheel_torque_cmd * e1 - u.h_w * np.cross(u.omega_B, e1)


def test_a_moderate_demand_is_met_without_residual():
    x, y = allocator.step(allocator.start(P, SMALL), SMALL, P, 0.1)
    assert not y.holding
    assert not x.holding
    assert 0.0 < y.demand_fraction < 0.8
    np.testing.assert_allclose(y.tau_residual_B, 0.0, atol=1e-17)
    np.testing.assert_allclose(achieved(y, SMALL), SMALL.tau_cmd_B, rtol=0, atol=1e-17)
    assert y.b_wheel == pytest.approx(2.3 / math.sqrt(2.3**2 + 1.1**2 + 2.9**2))


def test_a_running_command_is_held_and_released():
    x, running = allocator.step(allocator.start(P, SMALL), MIDDLE, P, 0.1)
    assert not running.holding
    for _ in range(3):
        x, held = allocator.step(x, LARGE, P, 0.1)
        assert held.holding
        assert x.holding
        assert held.demand_fraction >= 0.8
        np.testing.assert_array_equal(commands(held), commands(running))
        np.testing.assert_allclose(held.tau_residual_B, LARGE.tau_cmd_B - achieved(running, LARGE), rtol=0, atol=1e-17)
    x, released = allocator.step(x, SMALL, P, 0.1)
    assert not released.holding
    np.testing.assert_allclose(achieved(released, SMALL), SMALL.tau_cmd_B, rtol=0, atol=1e-17)
    x, held = allocator.step(x, LARGE, P, 0.1)
    np.testing.assert_array_equal(commands(held), commands(released))
    assert x.t == pytest.approx(0.6)


def test_a_hold_from_the_start_holds_zero():
    x = allocator.start(P, LARGE)
    y = allocator.outputs(x, LARGE, P)
    assert y.holding
    np.testing.assert_array_equal(commands(y), 0.0)
    x, y = allocator.step(x, LARGE, P, 0.1)
    np.testing.assert_array_equal(commands(y), 0.0)
    x, y = allocator.step(x, SMALL, P, 0.1)
    assert not y.holding


def test_the_command_of_the_start_is_held_by_a_hold_in_the_first_step():
    x = allocator.start(P, SMALL)
    given = allocator.outputs(x, SMALL, P)
    assert not given.holding
    np.testing.assert_allclose(achieved(given, SMALL), SMALL.tau_cmd_B, rtol=0, atol=1e-17)
    _, y = allocator.step(x, LARGE, P, 0.1)
    assert y.holding
    np.testing.assert_array_equal(commands(y), commands(given))


def test_a_state_that_remembers_nothing_holds_zero():
    """The other reading of the paper's "last known value": nothing is known before the first step."""
    x = allocator.State(0.0, np.zeros(3), 0.0, False)
    _, y = allocator.step(x, LARGE, P, 0.1)
    assert y.holding
    np.testing.assert_array_equal(commands(y), 0.0)


def test_outputs_between_steps_commit_nothing():
    x, first = allocator.step(allocator.start(P, SMALL), SMALL, P, 0.1)
    assert not allocator.outputs(x, MIDDLE, P).holding
    np.testing.assert_array_equal(commands(allocator.outputs(x, LARGE, P)), commands(first))
    np.testing.assert_array_equal(commands(allocator.outputs(x, SMALL, P)), commands(first))


def test_the_hold_begins_at_its_fraction_exactly_for_rods_and_wheel():
    # On the field (0.6, 0.8, 0) a wheel torque of dh takes tau = (-dh, 0, 0) + what rods add; here the rods do it all.
    axes = parameters("allocator", rod_axes=np.eye(3), dipole_max=10.0, wheel_torque_max=1e-3, hold_fraction=0.5)
    still = {"b_B": [5e-5, 0.0, 0.0], "omega_B": np.zeros(3), "h_w": 0.0}
    for limit, unit_torque in ((10.0 * 5e-5, [0.0, 0.0, -1.0]), (1e-3, [-1.0, 0.0, 0.0])):
        for share, holding in ((0.4999999, False), (0.5000001, True)):
            for sign in (1.0, -1.0):
                u = demand(1.0, tau_cmd_B=sign * share * limit * np.array(unit_torque), **still)
                y = allocator.outputs(allocator.start(axes, u), u, axes)
                assert y.demand_fraction == pytest.approx(share, rel=1e-12)
                assert y.holding is holding
    exactly = replace(axes, hold_fraction=0.5)
    u = demand(1.0, tau_cmd_B=[-0.5e-3, 0.0, 0.0], **still)
    assert allocator.outputs(allocator.start(exactly, u), u, exactly).holding


def test_residual_counts_the_actuators_limits_against_a_held_command():
    x = allocator.State(3.0, np.array([40.0, -3.0, -99.0]), 0.02, True)
    y = allocator.outputs(x, LARGE, P)
    np.testing.assert_array_equal(commands(y), [40.0, -3.0, -99.0, 0.02])
    clipped = replace(y, dipole_cmd=np.array([25.0, -3.0, -25.0]), wheel_torque_cmd=0.003)
    np.testing.assert_allclose(y.tau_residual_B, LARGE.tau_cmd_B - achieved(clipped, LARGE), rtol=0, atol=1e-17)


def test_a_full_wheel_leaves_its_torque_in_the_residual():
    full = demand(0.3, h_w=-0.03, omega_B=np.zeros(3))
    y = allocator.outputs(allocator.start(P, full), full, P)
    inward = demand(0.3, h_w=0.03, omega_B=np.zeros(3))
    z = allocator.outputs(allocator.start(P, inward), inward, P)
    assert not y.holding
    assert not z.holding
    outward_first = (y, z) if y.wheel_torque_cmd < 0 else (z, y)
    np.testing.assert_allclose(
        outward_first[0].tau_residual_B, [-outward_first[0].wheel_torque_cmd, 0.0, 0.0], atol=1e-17
    )
    np.testing.assert_allclose(outward_first[1].tau_residual_B, 0.0, atol=1e-17)


@pytest.mark.parametrize(
    "u",
    [
        demand(0.3, b_B=[0.0, 2e-5, -3e-5]),
        demand(0.3, b_B=[1e-18, 2e-5, -3e-5]),
        demand(0.3, b_B=[1e-12, 2e-5, -3e-5]),
        demand(0.3, b_B=[0.0, 0.0, 0.0]),
        demand(0.0, b_B=[0.0, 0.0, 0.0]),
        demand(0.3, b_B=[1e-14, -1e-14, 1e-14]),
        demand(1e12),
        demand(1e200),
        demand(0.3, h_w=1e160, omega_B=[1e160, 1e160, -1e160]),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow|invalid:RuntimeWarning")
def test_singular_and_absurd_demands_hold_and_report_the_cap(u):
    x = allocator.State(7.0, np.array([3.0, -2.0, 1.0]), 5e-4, False)
    x, y = allocator.step(x, u, P, 0.1)
    assert y.holding
    assert x.holding
    assert y.demand_fraction == 1e6 or (abs(y.b_wheel) < 1e-6 and y.demand_fraction > 1e3)
    np.testing.assert_array_equal(commands(y), [3.0, -2.0, 1.0, 5e-4])
    if abs(u.h_w) < P.wheel_momentum_max:
        np.testing.assert_allclose(y.tau_residual_B, u.tau_cmd_B - achieved(y, u), rtol=1e-12, atol=1e-17)


def test_a_field_too_weak_to_have_a_direction_has_no_part_along_the_wheel():
    for strength, b_wheel in ((0.9e-12, 0.0), (1.1e-12, 1.0)):
        u = demand(0.3, b_B=[strength, 0.0, 0.0])
        assert allocator.outputs(allocator.start(P, u), u, P).b_wheel == b_wheel


def test_without_a_field_b_wheel_is_zero_and_only_the_wheel_acts():
    x = allocator.State(7.0, np.array([3.0, -2.0, 1.0]), 5e-4, False)
    u = demand(0.3, b_B=[0.0, 0.0, 0.0], omega_B=np.zeros(3))
    y = allocator.outputs(x, u, P)
    assert y.b_wheel == 0.0
    np.testing.assert_allclose(y.tau_residual_B, u.tau_cmd_B + np.array([5e-4, 0.0, 0.0]), rtol=0, atol=1e-18)


def test_a_field_normal_to_the_wheel_serves_a_demand_that_wants_nothing_along_it():
    u = demand(1.0, b_B=[0.0, 4e-5, 0.0], tau_cmd_B=[1e-4, 0.0, 2e-4], omega_B=np.zeros(3))
    y = allocator.outputs(allocator.start(P, u), u, P)
    assert not y.holding
    assert y.b_wheel == 0.0
    assert y.wheel_torque_cmd == 0.0
    np.testing.assert_allclose(y.tau_residual_B, 0.0, atol=1e-18)


def test_zero_demand_of_a_still_wheel_commands_zero():
    u = demand(0.0, h_w=0.0)
    y = allocator.outputs(allocator.State(1.0, np.ones(3), 1e-3, True), u, P)
    np.testing.assert_array_equal(commands(y), 0.0)
    assert not y.holding
    assert y.demand_fraction == 0.0


def test_rod_axes_are_normalised_on_use():
    rounded = parameters("allocator", rod_axes=P.rod_axes * (1.0 + 9e-7))
    allocator.check(rounded)
    y, z = (allocator.outputs(allocator.start(p, SMALL), SMALL, p) for p in (P, rounded))
    np.testing.assert_allclose(commands(y), commands(z), rtol=1e-12)


WRONG = [
    ({"rod_axes": 1.001 * P.rod_axes}, r"rod_axes: expected rows of unit length to 1e-06, found \|u1\| = 1.001"),
    ({"rod_axes": [[1, 0, 0], [0, 1, 0], [0, 0, 0.9]]}, r"rod_axes: .*\|u3\| = 0.9"),
    ({"rod_axes": [[1, 0, 0], [0.6, 0.8, 0], [0, 1, 0]]}, "rod_axes: expected linearly independent axes.*found 0"),
    ({"rod_axes": [[1, 0, 0], [1, 0, 0], [0, 1, 0]]}, "rod_axes: expected linearly independent axes"),
    ({"rod_axes": np.full((3, 3), math.nan)}, "rod_axes: expected finite"),
    ({"hold_fraction": 1.01}, "hold_fraction: expected a number above 0 and at most 1, found 1.01"),
    ({"hold_fraction": 0.0}, "hold_fraction: expected"),
    ({"hold_fraction": math.nan}, "hold_fraction: expected"),
    *(
        ({name: bad}, f"{name}: expected a finite number above 0, found")
        for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max")
        for bad in (0.0, -1.0, math.inf, math.nan)
    ),
]


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name_and_value(changes, message):
    with pytest.raises(ValueError, match=message):
        allocator.check(parameters("allocator", **changes))


def test_right_parameters_pass():
    allocator.check(P)
    allocator.check(parameters("allocator", hold_fraction=1.0, rod_axes=-np.eye(3)))
