"""Convergence with exact torque, and the equilibria."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import controller
from design.loop import read
from evidence.paper import SCENARIOS
from evidence.reproduction import equilibria
from evidence.samples import random_rotations, wrong_inertias

LAW = read(SCENARIOS["V.B"]).loop.controller
FULL = np.array([[2.9, 0.21, -0.34], [0.21, 3.6, 0.17], [-0.34, 0.17, 4.1]])


def test_random_rotations_are_rotations_and_uniform():
    R = random_rotations(np.random.default_rng(0), 20000)
    np.testing.assert_allclose(np.swapaxes(R, 1, 2) @ R - np.eye(3), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0)
    # Under the uniform distribution every element has mean 0 and variance 1/3, and the trace squared has mean 1.
    np.testing.assert_allclose(R.mean(axis=0), 0.0, atol=0.02)
    np.testing.assert_allclose((R**2).mean(axis=0), 1.0 / 3.0, atol=0.01)
    assert (np.trace(R, axis1=1, axis2=2) ** 2).mean() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("which", range(4))
def test_eigenvalues_of_the_controllers_own_loop_are_the_analytic_ones(which):
    p = replace(LAW, J_B=FULL, L0=0.3 * FULL, K0=np.array([0.5, 0.7, 0.8]))
    for n in (equilibria.ORBITAL_RATE, 0.05):
        expected = equilibria.analytic_eigenvalues(p.J_B, p.kappa0 * p.K0, p.lambda0 * p.L0, which, n)
        np.testing.assert_allclose(equilibria.measured_eigenvalues(p, which, n), expected, atol=1e-8)


def test_at_the_goal_the_gains_are_those_of_no_error_and_the_eigenvalue_is_so():
    """Of [10] with |zeta| = 0 by hand: k = 0.098 x 3.5/35, h3 = k (0.0117 + 0.0130), l = 1.47 x 2.1/21 x 0.018."""
    law = equilibria.at_rest(LAW, 0)
    found = equilibria.measured_eigenvalues(law, 0)
    by_hand = complex(-0.5 * 0.147 * 0.018, math.sqrt(0.0618 * 0.0098 * 0.0247 - (0.5 * 0.147 * 0.018) ** 2)) / 0.0618
    assert by_hand == pytest.approx(-0.0214 + 0.0588j, abs=5e-5)
    assert np.abs(found - by_hand).min() < 2e-5  # the orbital rate moves it by so much
    # At a half turn |zeta| = pi.
    assert equilibria.at_rest(LAW, 2).kappa0 == pytest.approx(0.098 * (3.5 + math.pi) / (35.0 + math.pi))


def test_the_controller_rings_at_that_eigenvalue_about_the_goal():
    """The block itself, started a millionth of a radian off about e3: half periods and their decay."""
    p = replace(LAW, reference="inertial", compensate_gravity=False)
    position, velocity = np.array([7e6, 0.0, 0.0]), np.array([0.0, 7.5e3, 0.0])

    def inputs(y):
        return controller.Inputs(
            controller.so3.exp(np.array([0.0, 0.0, y[0]])), np.array([0.0, 0.0, y[1]]), position, velocity
        )

    x = controller.start(p, inputs((1e-6, 0.0)))

    def slope(t, y):
        return [y[1], controller.outputs(x, inputs(y), p).tau_cmd_B[2] / p.J_B[2, 2]]

    def still(t, y):
        return y[1]

    rung = solve_ivp(slope, (0.0, 170.0), (1e-6, 0.0), rtol=1e-10, atol=1e-18, events=still)
    turns = np.array([t for t in rung.t_events[0] if t > 1.0])
    peaks = np.abs(rung.sol(turns)[0]) if rung.sol else np.abs([y[0] for y in rung.y_events[0]][-len(turns) :])
    assert math.pi / np.diff(turns) == pytest.approx(0.0588, abs=1e-4)
    assert np.log(peaks[1:] / peaks[:-1]) / np.diff(turns) == pytest.approx(-0.0214, abs=1e-4)


def test_the_closed_form_is_the_limit_without_orbital_rate():
    p = LAW
    for which in range(4):
        K, L = p.kappa0 * p.K0, p.lambda0 * p.L0
        found = equilibria.analytic_eigenvalues(p.J_B, K, L, which, 0.0)
        np.testing.assert_allclose(found, equilibria.closed_form(p.J_B, K, L, which), atol=1e-12)


def test_half_turns_about_e1_e2_e3_have_three_two_and_one_unstable_directions():
    K, L = LAW.kappa0 * LAW.K0, LAW.lambda0 * LAW.L0
    unstable = [int((equilibria.analytic_eigenvalues(LAW.J_B, K, L, w).real > 0).sum()) for w in range(4)]
    assert unstable == [0, 3, 2, 1]


def test_wrong_inertias_are_those_of_bodies_and_as_wrong_as_asked():
    J = np.diag([2.13, 3.04, 3.09])
    found = wrong_inertias(J, 100, 5, 0.1)
    inverse_root = np.diag(1.0 / np.sqrt(J.diagonal()))
    relative = np.linalg.eigvalsh(inverse_root @ found @ inverse_root) - 1.0
    assert np.abs(relative).max() <= 0.1 + 1e-12
    assert np.abs(relative).max() > 0.09
    moments = np.linalg.eigvalsh(found)
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1]).all()
