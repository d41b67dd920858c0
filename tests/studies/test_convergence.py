"""Convergence with exact torque, and the equilibria."""

from dataclasses import replace

import numpy as np
import pytest

import controller
from studies import convergence
from studies.setup import read
from studies.sweep import wrong_inertias
from studies.vectors import random_rotations

LAW = read("scenarios/paper_no_singularity.yaml").loop.controller
FULL = np.array([[2.9, 0.21, -0.34], [0.21, 3.6, 0.17], [-0.34, 0.17, 4.1]])


def test_random_rotations_are_rotations_and_uniform():
    R = random_rotations(np.random.default_rng(0), 20000)
    np.testing.assert_allclose(np.einsum("ijn,ikn->jkn", R, R) - np.eye(3)[..., None], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(np.moveaxis(R, -1, 0)), 1.0)
    # Under the uniform distribution every element has mean 0 and variance 1/3, and the trace squared has mean 1.
    np.testing.assert_allclose(R.mean(axis=2), 0.0, atol=0.02)
    np.testing.assert_allclose((R**2).mean(axis=2), 1.0 / 3.0, atol=0.01)
    assert (np.trace(R) ** 2).mean() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("which", range(4))
def test_eigenvalues_of_the_controllers_own_loop_are_the_analytic_ones(which):
    p = replace(LAW, J_B=FULL, L0=0.3 * FULL, K0=np.array([0.5, 0.7, 0.8]))
    for n in (convergence.ORBITAL_RATE, 0.05):
        expected = convergence.analytic_eigenvalues(p.J_B, p.kappa0 * p.K0, p.lambda0 * p.L0, which, n)
        np.testing.assert_allclose(convergence.measured_eigenvalues(p, which, n), expected, atol=1e-8)


def test_the_closed_form_is_the_limit_without_orbital_rate():
    p = LAW
    for which in range(4):
        K, L = p.kappa0 * p.K0, p.lambda0 * p.L0
        found = convergence.analytic_eigenvalues(p.J_B, K, L, which, 0.0)
        np.testing.assert_allclose(found, convergence.closed_form(p.J_B, K, L, which), atol=1e-12)


def test_half_turns_about_e1_e2_e3_have_three_two_and_one_unstable_directions():
    K, L = LAW.kappa0 * LAW.K0, LAW.lambda0 * LAW.L0
    unstable = [int((convergence.analytic_eigenvalues(LAW.J_B, K, L, w).real > 0).sum()) for w in range(4)]
    assert unstable == [0, 3, 2, 1]


def test_with_constant_gains_v_never_rises_and_falls_as_the_paper_says():
    flown = convergence.random_cases(LAW, "constant", n=40, duration=60.0)
    assert not flown.steps_up.any()
    assert flown.rate_error < 1e-7


def test_a_start_near_the_goal_settles_and_one_on_an_unstable_equilibrium_stays_there():
    half_turn = np.diag([1.0, -1.0, -1.0])
    near = controller.so3.exp(np.array([0.2, -0.1, 0.3]))
    Q = np.moveaxis(np.array([near, half_turn]), 0, -1)
    J = np.repeat(LAW.J_B[..., None], 2, axis=2)
    flown = convergence.fly([LAW] * 2, J, Q, Q[1] * -convergence.ORBITAL_RATE, 200.0)
    assert 20.0 < flown.converged[0] < 200.0
    assert flown.final_angle[1] == pytest.approx(np.pi, abs=1e-6)


def test_wrong_inertias_are_those_of_bodies_and_as_wrong_as_asked():
    J = np.diag([2.13, 3.04, 3.09])
    found = np.moveaxis(wrong_inertias(J, 100, 5, 0.1), -1, 0)
    inverse_root = np.diag(1.0 / np.sqrt(J.diagonal()))
    relative = np.linalg.eigvalsh(inverse_root @ found @ inverse_root) - 1.0
    assert np.abs(relative).max() <= 0.1 + 1e-12
    assert np.abs(relative).max() > 0.09
    moments = np.linalg.eigvalsh(found)
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1]).all()
