"""The bounded allocator's feed-forward: what is preferred, where the torque leaves a choice."""

from dataclasses import replace

import numpy as np
import pytest

from .problems import P, commands, given, problem, torque, unit


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
