"""The bounded allocator's symmetries: another order, sense or frame of the actuators, another size of the satellite."""

import math
from dataclasses import replace

import numpy as np

from .problems import PROBLEMS, commands, given


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
