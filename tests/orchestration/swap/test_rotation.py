"""A quaternion that stands for a rotation matrix."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration import rotation

from .. import mocks
from ..mocks import Mock, real
from .behind import echo, fitted, through


@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("last", [False, True])
def test_a_quaternion_stands_for_a_rotation_matrix(last, inverse):
    ours = mocks.model("ours", real("R", "input", shape=(3, 3)), real("S", "output", shape=(3, 3)))
    theirs = mocks.model("theirs", real("q", "input", shape=(4,)), real("p", "output", shape=(4,)))
    entry = {"quaternion": f"scalar {'last' if last else 'first'}", "inverse": inverse}
    found = fitted(ours, theirs, ports={"R": {"theirs": "q", **entry}, "S": {"theirs": "p", **entry}})
    near_half_turns = Rotation.from_rotvec(np.pi * (1 - 1e-9) * np.eye(3))
    for R in [*Rotation.random(20, random_state=2).as_matrix(), *near_half_turns.as_matrix(), np.eye(3)]:
        block = echo("x", theirs, {"p": "q"})
        back = through(found, block, R=R)
        q = block.vector("q")
        expected = Rotation.from_matrix(R.T if inverse else R).as_quat(scalar_first=not last)
        np.testing.assert_allclose(q * np.sign(q @ expected), expected, atol=1e-12)
        np.testing.assert_allclose(np.reshape(list(back.values()), (3, 3)), R, atol=1e-12)


def test_a_course_of_quaternions_has_no_jumps():
    course: list[list[float]] = []
    turns = [Rotation.from_rotvec(angle * np.array([0.36, 0.48, 0.8])) for angle in np.linspace(0.0, 4 * np.pi, 400)]
    matrices = np.array([turn.as_matrix().ravel() for turn in turns])
    for R in matrices.tolist():
        course.append(rotation.quaternion(R, course[-1] if course else None))
    assert np.abs(np.diff(course, axis=0)).max() < 0.05
    np.testing.assert_allclose(rotation.quaternions(matrices), course, rtol=0.0, atol=1e-15)


def test_what_is_no_unit_quaternion_ends_the_run_with_its_name():
    ours = mocks.model("ours", real("u", "input"), real("S", "output", shape=(3, 3)))
    theirs = mocks.model("theirs", real("u", "input"), real("p", "output", shape=(4,)))
    found = fitted(ours, theirs, ports={"S": {"theirs": "p", "quaternion": "scalar first"}})
    block = Mock("x", theirs, lambda b: None)
    with pytest.raises(Exception, match=r"x: output p .*stands for our S: expected a quaternion of length 1"):
        through(found, block, u=0.0)


@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-6, 1.0, 2.5, np.pi - 1e-6, np.pi - 1e-10, np.pi])
@pytest.mark.parametrize("axis", [(0.6, -0.8, 0.0), (-0.48, 0.6, 0.64), (0.0, 0.0, -1.0)])
def test_the_rotation_vector_of_a_matrix_is_scipys_also_at_half_a_turn(axis, angle):
    R = Rotation.from_rotvec(angle * np.array(axis)).as_matrix()
    found = rotation.three(R.ravel().tolist(), "rotation vector")
    np.testing.assert_allclose(Rotation.from_rotvec(found).as_matrix(), R, atol=1e-12)
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-9)
