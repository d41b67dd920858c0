"""The maps on SO(3), against SciPy's Rotation: angles 0, 1e-9, generic, pi - 1e-9, pi."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plant import so3

ANGLES = [0.0, 1e-9, 0.3, 2.0, math.pi - 1e-9, math.pi]
AXES = [
    np.eye(3)[0],
    np.eye(3)[1],
    np.eye(3)[2],
    np.array([1.0, -2.0, 2.0]) / 3.0,
    np.array([-2.0, -1.0, 2.0]) / 3.0,
    np.array([6.0, 2.0, -3.0]) / 7.0,
    np.array([2.0, 6.0, 3.0]) / 7.0,
    np.array([-2.0, 3.0, 6.0]) / 7.0,
]


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("axis", AXES)
def test_quaternions_are_scipys_and_their_scalar_is_not_negative(angle, axis):
    rotation = Rotation.from_rotvec(angle * axis)
    R = rotation.as_matrix()
    q = so3.to_quaternion(R)
    x, y, z, w = rotation.as_quat(canonical=True)
    expected = np.array([w, x, y, z])
    assert q[0] >= 0.0
    assert min(np.abs(q - expected).max(), np.abs(q + expected).max() if q[0] < 1e-8 else 1.0) < 1e-15 * 4
    assert so3.from_quaternion(q) == pytest.approx(R, abs=1e-15)
    assert so3.from_quaternion(-3.0 * q) == pytest.approx(R, abs=1e-15)


@pytest.mark.parametrize("angle", ANGLES[:-1])
@pytest.mark.parametrize("axis", AXES)
def test_the_cayley_map_turns_by_twice_the_arc_tangent(angle, axis):
    F = so3.cayley(math.tan(0.5 * angle) * axis)
    assert pytest.approx(Rotation.from_rotvec(angle * axis).as_matrix(), abs=1e-15) == F


def test_the_cayley_map_is_its_definition():
    f = np.array([0.3, -0.7, 0.2])
    skew = np.array([[0.0, -f[2], f[1]], [f[2], 0.0, -f[0]], [-f[1], f[0], 0.0]])
    assert so3.cayley(f) == pytest.approx((np.eye(3) + skew) @ np.linalg.inv(np.eye(3) - skew), abs=1e-15)


def test_projection_gives_the_nearest_rotation():
    rng = np.random.default_rng(4)
    for _ in range(20):
        R = Rotation.random(random_state=rng).as_matrix()
        rough = R + 5e-4 * rng.normal(size=(3, 3))
        near = so3.project(rough)
        assert near.T @ near == pytest.approx(np.eye(3), abs=4e-15)
        assert np.linalg.det(near) == pytest.approx(1.0)
        # SciPy finds the same by Wahba's problem on the columns
        wahba, _ = Rotation.align_vectors(rough.T, np.eye(3))
        assert near == pytest.approx(wahba.as_matrix(), abs=1e-13)
    assert np.linalg.det(so3.project(-np.eye(3))) == pytest.approx(1.0)


def test_three_equations_are_solved_as_by_numpy():
    random = np.random.default_rng(14)
    for A, y in zip(random.normal(size=(100, 3, 3)), random.normal(size=(100, 3)), strict=True):
        x = np.array(so3.solve(A.tolist(), y.tolist()))
        assert np.abs(x - np.linalg.solve(A, y)).max() < 1e-14 * np.linalg.cond(A) * np.abs(x).max()
