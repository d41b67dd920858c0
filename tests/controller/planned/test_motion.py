"""The motion that a plan is made of, and its derivatives, against SciPy and closed forms."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from . import core, motion
from .states import FULL_J, SATELLITE, around, differences, errors, flown, reference, state, turned

NUTATING = replace(SATELLITE, wheel_momentum_max=0.3)
"""At its limit by 5 rad in T = 50 s, so its stages are implicit."""


@pytest.mark.parametrize("seed", range(20))
def test_the_acceleration_is_that_of_the_equations(seed, rng):
    x, a, u = state(seed), around(seed), rng.uniform(-1, 1, 4)
    expected = motion.rate_of_change(
        reference(SATELLITE, a),
        x.R,
        x.Omega,
        x.h_w,
        u[:3] @ SATELLITE.rods + SATELLITE.residual_B,
        u[3] * SATELLITE.wheel_torque_max,
    )
    assert core.acceleration(SATELLITE, a, x, u) == pytest.approx(expected, rel=1e-12, abs=1e-18)


def test_the_equations_conserve_the_total_momentum_without_torque_from_outside():
    """R (J Omega + l e1) in N is at rest while the wheel spins up: no term is lost and no sign is turned."""
    free = motion.Surroundings(FULL_J, np.zeros(3), np.array([1.0, 0, 0]), 0.0, np.zeros(3))
    x = state(3)
    dOmega = motion.rate_of_change(free, x.R, x.Omega, x.h_w, np.zeros(3), 2e-3)
    Pi = FULL_J @ x.Omega + x.h_w * motion.E1
    assert np.cross(x.Omega, Pi) + FULL_J @ dOmega + 2e-3 * motion.E1 == pytest.approx(np.zeros(3), abs=1e-17)


def test_the_gravity_gradient_of_the_equations_is_that_of_two_masses():
    """Four points on two axes in the field of a point mass: their torque to the first order in size over distance."""
    masses, r = np.array([1.5, 1.5, 0.8, 0.8]), np.array([3e6, -4e6, 5e6])
    at = np.array([[0.3, 0, 0.4], [-0.3, 0, -0.4], [0.5, -0.6, 0.1], [-0.5, 0.6, -0.1]])
    J = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, at, strict=True))
    R = turned(9)
    pulls = [-core.MU * m * (r + R @ p) / np.linalg.norm(r + R @ p) ** 3 for m, p in zip(masses, at, strict=True)]
    torque = sum(np.cross(p, R.T @ f) for p, f in zip(at, pulls, strict=True))
    d = np.linalg.norm(r)
    s = motion.Surroundings(J, np.zeros(3), r / d, core.MU / d**3, np.zeros(3))
    assert J @ motion.rate_of_change(s, R, np.zeros(3), 0.0, np.zeros(3), 0.0) == pytest.approx(torque, rel=1e-6)


@pytest.mark.parametrize("satellite", [SATELLITE, NUTATING], ids=["explicit", "implicit"])
@pytest.mark.parametrize("seed", range(4))
def test_a_stage_comes_to_scipys_motion_in_second_order(seed, satellite, rng):
    x, a, u = state(seed), around(seed), rng.uniform(-0.9, 0.9, 4)
    exact = flown(satellite, a, x, u, 4.0)
    sizes = []
    for n in (2, 4, 8, 16):
        y = x
        for _ in range(n):
            y = core.advanced(satellite, a, y, u, 4.0 / n)
        sizes.append(np.abs(errors(exact, y)).max())
    ratios = [before / after for before, after in pairwise(sizes)]
    assert ratios[-1] == pytest.approx(4.0, rel=0.15)
    assert sizes[-1] < (2e-5 if satellite is SATELLITE else 5e-5)


@pytest.mark.parametrize("h", [1.0, 8.0, 16.0, 50.0])
@pytest.mark.parametrize("axis", np.eye(3), ids=["e1", "e2", "e3"])
def test_nutation_neither_grows_nor_decays_however_long_a_stage_is(axis, h):
    """Of a 1U with its wheel at the limit; without torque its energy is constant, of which a stage of 16 s turns it by
    7 rad."""
    satellite = core.Satellite(np.diag([2.47e-3, 2.47e-3, 2.17e-3]), 0.2 * np.eye(3), axis, 1e-4, 1e-3, dipole_max=0.2)
    free = core.Around(np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.0)
    across = np.array([1.0, 1.0, 1.0]) - axis
    x = core.Motion(np.eye(3), 1e-4 * across, 1e-3)
    energies = []
    for _ in range(200):
        energies.append(x.Omega @ satellite.J @ x.Omega)
        x = core.advanced(satellite, free, x, np.zeros(4), h)
    assert energies == pytest.approx([energies[0]] * 200, rel=0.05)


def test_the_wheel_stops_at_its_limit():
    x = core.Motion(np.eye(3), np.zeros(3), 0.029)
    for h in (0.5, 5.0, 25.0):
        assert core.advanced(SATELLITE, around(), x, [0, 0, 0, 1.0], h).h_w <= 0.03 * (1 + 1e-12)
    beyond = core.Motion(np.eye(3), np.zeros(3), 0.035)  # a wheel that is past its limit is brought back
    assert core.advanced(SATELLITE, around(), beyond, [0, 0, 0, 1.0], 10.0).h_w == pytest.approx(0.03)


@pytest.mark.parametrize("satellite", [SATELLITE, NUTATING], ids=["explicit", "implicit"])
@pytest.mark.parametrize("seed", range(5))
def test_a_stages_derivatives_come_to_the_differences_of_its_motion_in_third_order(seed, satellite):
    x, a, u = state(seed, 0.03), around(seed), np.random.default_rng(seed).uniform(-0.5, 0.5, 4)
    parts = [slice(0, 3), slice(3, 6), slice(6, 7)]
    off = []
    for h in (2.0, 1.0):
        found, expected = core.linearised(satellite, a, x, u, h), differences(x, a, u, h, satellite)
        A, G = (np.abs(f - e) for f, e in zip(found, expected, strict=True))
        off.append([*(A[r, c].max() for r in parts for c in parts), *(G[r].max() for r in parts)])
    assert max(off[1]) < 0.01
    for before, after in zip(*off, strict=True):
        assert after < before / 6.0 or before < 1e-8
