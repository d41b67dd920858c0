"""The gravity-gradient moment: the potential's form, Newton's law on point masses. Librations:
tests/authorities/libration.py."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plant
from plant import gravity_gradient
from tests.authorities import libration
from tests.plant.motion import FULL_INERTIA, checked, command

MU = 3.986004418e14


@pytest.fixture(params=range(6))
def pose(request):
    """R and r_N, m, at random."""
    rng = np.random.default_rng(request.param)
    direction = rng.normal(size=3)
    return Rotation.random(random_state=rng).as_matrix(), direction / np.linalg.norm(direction) * rng.uniform(
        6.6e6, 9e6
    )


def closed_form(R, r_N):
    r = np.linalg.norm(r_N)
    return gravity_gradient.moment(R.T @ r_N / r, FULL_INERTIA, MU / r**3)


def test_the_moment_is_the_papers_form_of_the_potential(pose):
    """[2]: M_g = sum r_i x v_ri, r_i and v_ri the rows of R and of dU/dR, the latter by complex steps of each
    element."""
    R, r_N = pose
    r = np.linalg.norm(r_N)

    def U(R):
        down = R.T @ r_N / r
        return MU / r**3 * (1.5 * down @ FULL_INERTIA @ down - 0.5 * np.trace(FULL_INERTIA))

    slope = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            step = np.zeros((3, 3), complex)
            step[i, j] = 1e-20j
            slope[i, j] = U(R + step).imag / 1e-20
    by_rows = sum(np.cross(R[i], slope[i]) for i in range(3))
    assert closed_form(R, r_N) == pytest.approx(by_rows, rel=1e-12, abs=1e-20)
    matrix = slope.T @ R - R.T @ slope  # M_g^ = (dU/dR)^T R - R^T (dU/dR)
    assert closed_form(R, r_N) == pytest.approx([matrix[2, 1], matrix[0, 2], matrix[1, 0]], rel=1e-12, abs=1e-20)


def test_the_moment_is_what_newtons_law_gives_on_six_masses(pose):
    """Pairs of masses on the principal axes with this inertia, each attracted for itself."""
    R, r_N = pose
    moments, axes = np.linalg.eigh(FULL_INERTIA)
    second = 0.5 * moments.sum() - moments  # integral of x_i^2 dm
    arm = 10.0
    moment, total = np.zeros(3), np.zeros(3)
    for share, axis in zip(second, axes.T, strict=True):
        for side in (arm, -arm):
            x = side * axis
            place = r_N + R @ x
            force = -MU * share / (2.0 * arm**2) * (place / np.linalg.norm(place) ** 3 - r_N / np.linalg.norm(r_N) ** 3)
            moment += np.cross(x, R.T @ force)
            total += force
    assert closed_form(R, r_N) == pytest.approx(moment, rel=1e-6, abs=1e-6 * np.abs(moment).max())


def test_the_potentials_slope_along_a_turn_is_minus_the_moment(pose):
    R, r_N = pose
    r = np.linalg.norm(r_N)
    for i in range(3):

        def U(angle, i=i):
            turned = R @ Rotation.from_rotvec(angle * np.eye(3)[i]).as_matrix()
            return gravity_gradient.potential(turned.T @ r_N / r, FULL_INERTIA, MU / r**3)

        slope = (U(1e-4) - U(-1e-4)) / 2e-4
        assert slope == pytest.approx(-closed_form(R, r_N)[i], abs=1e-12)


def test_the_block_gives_the_moment_at_the_satellites_place():
    p = checked(J_B=FULL_INERTIA, Q0=Rotation.random(random_state=3).as_matrix())
    y = plant.outputs(plant.start(p, command()), command(), p)
    r = y.R_NB.T @ y.r_N
    assert y.tau_gg_B == pytest.approx(3 * MU / np.linalg.norm(r) ** 5 * np.cross(r, FULL_INERTIA @ r), rel=1e-12)
    off = checked(J_B=FULL_INERTIA, gravity_gradient=False)
    assert not plant.outputs(plant.start(off, command()), command(), off).tau_gg_B.any()


def test_a_body_of_equal_moments_feels_none():
    assert np.abs(gravity_gradient.moment(np.array([0.6, 0.0, 0.8]), 3.0 * np.eye(3), 1.2e-6)).max() < 1e-21


def test_the_papers_inertia_is_unstable_in_pitch():
    """The authority measures the growth at the closed form."""
    assert libration.pitch_closed_form(libration.PAPER) == pytest.approx(-0.947, abs=5e-4)
