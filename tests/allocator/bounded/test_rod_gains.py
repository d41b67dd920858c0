"""The bounded allocator with rods of limits of their own, and rods that give less than they are told, nothing, or the
opposite."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tests.blocks import inputs

from .problems import BLOCK, E1, PROBLEMS, P, commands, cost_and_box, given


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
    """Of a demand along what the rod gives, the command of one at 0.9 is 1/0.9 of that of a sound one, up to the
    limit."""
    b = np.array([0.0, 0.0, 3e-5])
    along = np.cross(P.U[0], b)
    u = inputs(BLOCK, tau_cmd_B=20.0 * along, b_B=b, dipole_ff=[20.0, 0.0, 0.0], wheel_torque_ff=0.0)
    weak = replace(u, rod_gains=np.array([0.9, 1.0, 1.0]))
    y = given(replace(weak, dipole_ff=np.array([20.0 / 0.9, 0.0, 0.0])))
    assert y.dipole_cmd[0] == pytest.approx(20.0 / 0.9, rel=1e-6)
    assert np.linalg.norm(y.tau_residual_B) < 1e-12


def test_with_limits_of_the_rods_scipy_finds_no_better_commands(rng):
    at_limit = 0
    for u, p in PROBLEMS["any"][:100]:
        shares = rng.uniform(0.01, 1.0, 3)
        A, y, low, high = cost_and_box(u, p)
        within = np.array([*(25.0 * shares), np.inf])
        low, high = np.maximum(low, -within), np.minimum(high, within)
        x = commands(given(u, replace(p, rod_limits=shares)))
        assert ((low - 1e-12 <= x) & (x <= high + 1e-12)).all()
        scale = np.array([*(25.0 * shares), 3e-3])
        y[3:6] = np.clip(
            y[3:6], p.rod_weight * low[:3], p.rod_weight * high[:3]
        )  # a preference beyond a limit counts as the limit
        best = lsq_linear(A * scale, y, (low / scale, high / scale), method="bvls", tol=1e-15).cost
        assert 0.5 * np.sum((A @ x - y) ** 2) <= best * (1.0 + 1e-9) + 1e-22
        at_limit += bool((np.abs(x[:3]) > 24.9 * shares).any())
    assert at_limit > 30


def test_rods_that_all_give_half_are_rods_of_half_the_dipole():
    for u, p in PROBLEMS["any"][:100]:
        shares = given(u, replace(p, rod_limits=np.full(3, 0.5)))
        np.testing.assert_array_equal(commands(shares), commands(given(u, replace(p, dipole_max=12.5))))
