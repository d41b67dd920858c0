"""The torquer rods and the constant disturbances."""

from __future__ import annotations

import math

import numpy as np
import pytest

import plant
from tests.plant.motion import FULL_INERTIA, checked, command, fly

U = np.array([[1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [0.0, 0.0, math.sqrt(3.0)]]) / math.sqrt(3.0)
"""The paper's axes, one a row."""


def at_start(u, **changes):
    p = checked(**changes)
    return plant.outputs(plant.start(p, u), u, p)


def test_the_moment_is_the_sum_over_the_rods_of_mu_u_cross_b():
    """[16], with each rod's own axis: dipole_cmd[i] lies along u_i, not along body axis i."""
    mu = [3.0, -7.0, 11.0]
    y = at_start(command(mu))
    by_rods = sum(m * np.cross(u, y.b_B) for m, u in zip(mu, U, strict=True))
    assert y.tau_mag_B == pytest.approx(by_rods, rel=1e-12)
    assert np.abs(by_rods).max() > 1e-4
    assert y.dipole.tolist() == mu
    assert not y.dipole_saturated


def test_the_moment_has_no_part_along_the_field():
    y = at_start(command([20.0, -13.0, 4.0]))
    assert abs(y.tau_mag_B @ y.b_B) < 1e-15 * np.linalg.norm(y.tau_mag_B) * np.linalg.norm(y.b_B) * 10.0


@pytest.mark.parametrize("beyond", [25.0000001, 1e9, math.inf])
def test_a_demand_beyond_the_rods_is_clipped_to_their_limit_and_flagged(beyond):
    y = at_start(command([beyond, -beyond, 3.0]))
    assert y.dipole.tolist() == [25.0, -25.0, 3.0]
    assert y.dipole_saturated
    clipped = at_start(command([25.0, -25.0, 3.0]))
    assert not clipped.dipole_saturated
    assert np.array_equal(y.tau_mag_B, clipped.tau_mag_B)


def test_each_rod_is_clipped_at_a_limit_of_its_own():
    y = at_start(command([20.0, -20.0, 20.0]), rod_limits=[0.4, 1.0, 0.8])
    assert y.dipole == pytest.approx([10.0, -20.0, 20.0], rel=1e-15)
    assert y.dipole_saturated
    assert not at_start(command([10.0, -20.0, 20.0]), rod_limits=[0.4, 1.0, 0.8]).dipole_saturated
    weak = at_start(command([20.0, -20.0, 20.0]), rod_limits=[0.4, 1.0, 0.8], rod_gain=[0.5, 1.0, -1.0])
    assert weak.dipole == pytest.approx([5.0, -20.0, -20.0], rel=1e-15)


def test_the_motion_feels_the_clipped_dipole_not_the_demand():
    p = checked()
    over, at_limit = (fly(p, command(d), 0.5, 4)[-1] for d in ([90.0, -4.0, -70.0], [25.0, -4.0, -25.0]))
    assert np.array_equal(over.R, at_limit.R)
    assert np.array_equal(over.Pi, at_limit.Pi)


def test_residual_dipole_adds_to_the_rods_in_body_axes():
    y = at_start(command([2.0, 0.0, 0.0]), residual_dipole_B=[0.3, -0.5, 0.7])
    assert y.tau_mag_B == pytest.approx(np.cross(2.0 * U[0] + [0.3, -0.5, 0.7], y.b_B), rel=1e-12)
    assert y.dipole.tolist() == [2.0, 0.0, 0.0]


def test_the_motion_feels_the_residual_dipole_as_it_does_the_rods():
    rods = fly(checked(), command([0.0, 0.0, 5.0]), 1.0, 5)[-1]
    residual = fly(checked(residual_dipole_B=[0.0, 0.0, 5.0]), command(), 1.0, 5)[-1]
    assert np.array_equal(rods.R, residual.R)


def test_a_constant_disturbance_about_a_principal_axis_accelerates_the_body():
    p = checked(
        J_B=np.diag([2.0, 3.0, 4.0]),
        gravity_gradient=False,
        omega_B0=[0.0, 0.0, 0.0],
        disturbance_torque_B=[0.0, 0.0, 4e-3],
    )
    x = fly(p, command(), 1.0, 10)[-1]
    assert x.Omega(p) == pytest.approx([0.0, 0.0, 1e-2], abs=1e-15)


def test_the_plant_moves_with_the_inertia_it_has_beyond_the_one_it_is_told():
    error = np.diag([0.1, -0.05, 0.02])
    told = fly(
        checked(J_B=FULL_INERTIA, J_error_B=error, omega_B0=[0.05, 0.02, -0.03]), command([5.0, 1.0, 2.0]), 1.0, 3
    )[-1]
    true = fly(checked(J_B=FULL_INERTIA + error, omega_B0=[0.05, 0.02, -0.03]), command([5.0, 1.0, 2.0]), 1.0, 3)[-1]
    assert pytest.approx(true.R, abs=1e-15) == told.R
    assert told.Pi == pytest.approx(true.Pi, abs=1e-16)


def test_five_percent_of_a_rods_range_as_residual_dipole_outweighs_the_papers_drag():
    y = at_start(command(), residual_dipole_B=[0.05 * 25.0, 0.0, 0.0])
    assert np.linalg.norm(y.tau_mag_B) > 1e-5


def test_rod_axes_off_unit_by_less_than_their_tolerance_are_normalised():
    y = at_start(command([1.0, 0.0, 0.0]), rod_axes=U * (1.0 + 5e-7))
    assert y.tau_mag_B == pytest.approx(np.cross(U[0], y.b_B), rel=1e-12)
