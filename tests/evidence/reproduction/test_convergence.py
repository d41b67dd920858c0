"""Convergence with exact torque, and the rest at the goal."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import controller
from design.loop import read
from evidence.paper import SCENARIOS
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


def test_the_controller_rings_about_the_goal_at_the_eigenvalue_of_gains_without_error():
    """The block itself, started a millionth of a radian off about e3: half periods and their decay.

    Of [10] with |zeta| = 0 by hand: k = 0.098 x 3.5/35, h3 = k (0.0117 + 0.0130), l = 1.47 x 2.1/21 x 0.018."""
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


def test_wrong_inertias_are_those_of_bodies_and_as_wrong_as_asked():
    J = np.diag([2.13, 3.04, 3.09])
    found = wrong_inertias(J, 100, 5, 0.1)
    inverse_root = np.diag(1.0 / np.sqrt(J.diagonal()))
    relative = np.linalg.eigvalsh(inverse_root @ found @ inverse_root) - 1.0
    assert np.abs(relative).max() <= 0.1 + 1e-12
    assert np.abs(relative).max() > 0.09
    moments = np.linalg.eigvalsh(found)
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1]).all()
