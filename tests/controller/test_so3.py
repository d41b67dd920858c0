import math

import numpy as np
import pytest
from scipy.linalg import expm, polar
from scipy.spatial.transform import Rotation

from controller import so3

RNG = np.random.default_rng(20090810)
AXES = [v / np.linalg.norm(v) for v in (*np.eye(3), *RNG.normal(size=(6, 3)), np.array([1.0, 1e-8, -1.0]))]
ANGLES = [0.0, 1e-9, 1e-4, 0.7, math.pi / 2, 2.5, math.pi - 1e-4, math.pi - 1e-9, math.pi]


@pytest.mark.parametrize("angle", ANGLES)
def test_principal_angle_is_scipys_magnitude_from_identity_to_half_turn(angle):
    for axis in AXES:
        Q = Rotation.from_rotvec(angle * axis)
        assert so3.principal_angle(Q.as_matrix()) == pytest.approx(Q.magnitude(), abs=1e-15, rel=1e-15)
        assert so3.principal_angle(Q.as_matrix()) == pytest.approx(angle, abs=1e-15, rel=1e-15)


def test_principal_angle_of_a_single_precision_attitude_stays_finite_near_identity_and_half_turn():
    for axis in AXES:
        for angle in ANGLES:
            Q = Rotation.from_rotvec(angle * axis).as_matrix().astype(np.float32).astype(np.float64)
            assert so3.principal_angle(Q) == pytest.approx(angle, abs=5e-7)


def test_hat_multiplies_as_numpys_cross_product(rng):
    for x, y in rng.normal(size=(20, 2, 3)):
        np.testing.assert_allclose(so3.hat(x) @ y, np.cross(x, y), rtol=0, atol=1e-15)
        np.testing.assert_allclose(so3.cross(x, y), np.cross(x, y), rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", [*ANGLES, 4.0, 100.0])
def test_exp_is_the_matrix_exponential(angle):
    for axis in AXES:
        np.testing.assert_allclose(so3.exp(angle * axis), expm(so3.hat(angle * axis)), rtol=0, atol=2e-13)
        np.testing.assert_allclose(
            so3.exp(angle * axis), Rotation.from_rotvec(angle * axis).as_matrix(), rtol=0, atol=2e-15
        )


def test_projection_is_the_polar_factor_and_leaves_rotations_alone(rng):
    for R in Rotation.random(20, random_state=7).as_matrix():
        np.testing.assert_allclose(so3.project(R), R, rtol=0, atol=2e-15)
        near = R + 1e-3 * rng.uniform(-1, 1, size=(3, 3))
        np.testing.assert_allclose(so3.project(near), polar(near)[0], rtol=0, atol=1e-14)


def test_projection_of_a_reflection_is_the_rotation_that_best_aligns_its_columns(rng):
    for M in rng.normal(size=(20, 3, 3)):
        left_handed = -np.sign(np.linalg.det(M)) * M
        nearest = Rotation.align_vectors(left_handed.T, np.eye(3))[0].as_matrix()
        np.testing.assert_allclose(so3.project(left_handed), nearest, rtol=0, atol=1e-9)


def test_a_matrix_that_is_no_rotation_is_refused_with_its_deviation():
    R = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()
    so3.require_rotation("R_NB", R * (1.0 + 0.49e-4), 1e-4)
    with pytest.raises(ValueError, match=r"R_NB: .* at most 0\.0001, found 0\.002"):
        so3.require_rotation("R_NB", R * 1.001, 1e-4)
    for row, column in np.ndindex(3, 3):
        bent = R.copy()
        bent[row, column] += 1e-3
        with pytest.raises(ValueError, match="R_NB"):
            so3.require_rotation("R_NB", bent, 1e-4)
        for bad in (math.nan, math.inf, -math.inf):
            bent[row, column] = bad
            with pytest.raises(ValueError, match=r"R_NB.*found (nan|inf)"):
                so3.require_rotation("R_NB", bent, 1e-4)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        sheared = np.eye(3)
        sheared[i, j] = sheared[j, i] = 1e-3  # lengths change by 1e-6 only
        with pytest.raises(ValueError, match=r"found 0\.002"):
            so3.require_rotation("R_NB", R @ sheared, 1e-4)
    with pytest.raises(ValueError, match=r"determinant \+1, found -1"):
        so3.require_rotation("R_NB", -R, 1e-4)


def test_rotations_pass_within_the_tolerance_and_their_mirror_images_and_smaller_copies_do_not():
    for R in Rotation.random(20, random_state=11).as_matrix():
        for scale in (1.0, 1.0 + 0.49e-4, 1.0 - 0.49e-4):
            so3.require_rotation("R_NB", scale * R, 1e-4)
        with pytest.raises(ValueError, match=r"found 0\.002"):
            so3.require_rotation("R_NB", 0.999 * R, 1e-4)
        for axis in range(3):
            mirror = np.diag(np.where(np.arange(3) == axis, -1.0, 1.0))
            with pytest.raises(ValueError, match=r"determinant \+1, found -1 \(a reflection\)"):
                so3.require_rotation("R_NB", R @ mirror, 1e-4)
