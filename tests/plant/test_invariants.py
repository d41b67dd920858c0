"""What the variational integrator keeps. Long runs of it are authorities: tests/authorities/structure.py."""

from __future__ import annotations

import math

import numpy as np
import pytest

import plant
from tests.plant.motion import FULL_INERTIA, bare, checked, command, fly


def test_the_body_slows_about_the_wheel_axis_by_what_the_wheel_takes():
    """About a principal axis the exchange is exact: J1 Omega1 + l_w stays."""
    p = checked(gravity_gradient=False, omega_B0=[0.01, 0.0, 0.0], step_max=0.5)
    x = fly(p, command(wheel_torque_cmd=1e-3), 0.5, 40)[-1]
    assert x.l_w[0] == pytest.approx(0.02, rel=1e-13)
    assert x.Omega(p) == pytest.approx([0.01 - 0.02 / 2.13, 0.0, 0.0], abs=1e-16)
    # and the angle is the integral of that rate
    angle = 0.01 * 20.0 - 0.5 * 1e-3 * 20.0**2 / 2.13
    turned = p.R_NB0.T @ x.R
    assert math.atan2(turned[2, 1], turned[1, 1]) == pytest.approx(angle, abs=1e-6)


def test_a_constant_wheel_makes_the_body_precess_as_a_gyrostat_does():
    """J = diag(A, B, B), wheel on the axis of symmetry: Omega2 + i Omega3 turns at ((A - B) Omega1 + l_w)/B."""
    A, B, l_w, spin, cross = 2.0, 3.0, 0.028, 0.05, 0.04
    p = checked(
        J_B=np.diag([A, B, B]),
        gravity_gradient=False,
        h_w0=l_w,
        omega_B0=[spin, cross, 0.0],
        integrator_order=6,
        step_max=0.25,
    )
    x = fly(p, command(), 1.0, 60)[-1]
    turn = ((A - B) * spin + l_w) / B * 60.0
    assert x.Omega(p) == pytest.approx([spin, cross * math.cos(turn), cross * math.sin(turn)], abs=1e-11)


def kinetic_energy_error(order: int, l_w: float) -> np.ndarray:
    """Of a tumble without moments at steps of 1 s, relative, with the wheel's momentum constant."""
    J, Omega, wheel = FULL_INERTIA, np.array([0.06, -0.08, 0.05]), np.array([l_w, 0.0, 0.0])
    inverse, T = np.linalg.inv(J), []
    bare(
        order, 1.0, 2000, np.eye(3), Omega, J, wheel=lambda t: l_w, wheel_mean=lambda t0, t1: l_w,
        seen=lambda R, Pi: T.append(0.5 * (Pi - wheel) @ inverse @ (Pi - wheel)),
    )  # fmt: skip
    return np.array(T) / (0.5 * Omega @ J @ Omega) - 1.0


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_energy_of_a_free_body_is_conserved_exactly(order):
    """The discrete Moser-Veselov algorithm does (McLachlan and Zanna, Found. Comput. Math. 5, 2005); RK4 does not."""
    assert np.abs(kinetic_energy_error(order, 0.0)).max() < 5e-14


@pytest.mark.parametrize(("order", "bound"), [(2, 3e-4), (4, 2e-7), (6, 2e-8)])
def test_the_energy_of_a_free_gyrostat_stays_within_a_bound_that_does_not_grow(order, bound):
    error = np.abs(kinetic_energy_error(order, 0.02))
    assert 1e-3 * bound < error[:1000].max() < bound
    assert error[1000:].max() < 1.001 * error[:1000].max()


def test_the_energy_output_is_the_sum_that_its_description_names():
    p = checked(J_B=FULL_INERTIA, omega_B0=[0.002, -0.003, 0.001], h_w0=0.01)
    y = plant.outputs(plant.start(p, command()), command(), p)
    r = np.linalg.norm(y.r_N)
    omega_o = np.cross(y.r_N, y.v_N) / r**2
    down = y.R_NB.T @ y.r_N / r
    k = 3.986004418e14 / r**3
    T = 0.5 * y.omega_B @ FULL_INERTIA @ y.omega_B
    # the attitude's part of -mu integral dm/|r + x|, to second order in x
    U = -k * (0.5 * np.trace(FULL_INERTIA) - 1.5 * down @ FULL_INERTIA @ down)
    Pi = FULL_INERTIA @ y.omega_B + [0.01, 0.0, 0.0]
    assert y.energy == pytest.approx(T + U - omega_o @ y.R_NB @ Pi, rel=1e-12)
    assert pytest.approx(y.R_NB @ Pi, rel=1e-13) == y.H_N
    free = checked(J_B=FULL_INERTIA, omega_B0=[0.002, -0.003, 0.001], h_w0=0.01, gravity_gradient=False)
    assert plant.outputs(plant.start(free, command()), command(), free).energy == pytest.approx(T, rel=1e-13)


def test_the_momentum_output_obeys_the_moments_that_the_outputs_show():
    """dH_N/dt = R (tau_gg + tau_mag + disturbance) [13], by central differences."""
    p = checked(
        J_B=FULL_INERTIA, omega_B0=[0.02, -0.03, 0.01], integrator_order=6, disturbance_torque_B=[1e-3, -2e-3, 1.5e-3]
    )
    u = command([20.0, -15.0, 10.0], 1e-3)
    h = 0.05
    x = plant.start(p, u)
    before = plant.outputs(x, u, p)
    x, middle = plant.step(x, u, p, h)
    _, after = plant.step(x, u, p, h)
    rate = (after.H_N - before.H_N) / (2.0 * h)
    moment = middle.R_NB @ (middle.tau_gg_B + middle.tau_mag_B + [1e-3, -2e-3, 1.5e-3])
    assert rate == pytest.approx(moment, rel=1e-5, abs=1e-9)
