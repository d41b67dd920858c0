"""Matrices as engineers state them, against SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration.quantities import QuantityError
from orchestration.scenario.forms import matrix

ANGLES = [0.0, 1e-9, 37.0, 90.0, 180.0 - 1e-7, 180.0, -270.0, 725.0]


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("axis", [[1, 0, 0], [2, -1, 2], [-0.3, 40.0, 1e-3]])
def test_an_axis_and_an_angle_turn_as_scipy_does(axis, angle):
    turn = np.array(axis) / np.linalg.norm(axis) * math.radians(angle)
    found = matrix({"axis": axis, "angle": f"{angle!r} deg"})
    assert np.abs(np.array(found) - Rotation.from_rotvec(turn).as_matrix()).max() < 4e-15


def test_a_quarter_turn_about_an_axis_of_the_frame_is_exact():
    assert matrix({"axis": [0, 0, 2], "angle": "90 deg"}) == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]


@pytest.mark.parametrize("sequence", ["ZYX", "XYZ", "ZXZ", "YXY", "zyx", "xyz", "zxz", "yzx"])
def test_euler_angles_turn_as_scipy_does_about_turned_axes_in_capitals_and_fixed_ones_in_small_letters(sequence):
    found = matrix({"euler": ["10 deg", "-35 deg", 1.2], "sequence": sequence})
    expected = Rotation.from_euler(sequence, [math.radians(10.0), math.radians(-35.0), 1.2]).as_matrix()
    assert np.abs(np.array(found) - expected).max() < 1e-15


def test_a_quaternion_is_scalar_first_and_of_unit_length_after_rounding():
    q = [0.5, -0.1, 0.7, 0.499]
    expected = Rotation.from_quat([*q[1:], q[0]]).as_matrix()
    assert np.abs(np.array(matrix({"quaternion": q})) - expected).max() < 1e-15


def test_a_diagonal_keeps_its_units():
    assert matrix({"diagonal": ["2 kg.m2", 3]}) == [["2 kg.m2", 0.0], [0.0, 3]]


@pytest.mark.parametrize(
    ("form", "message"),
    [
        ({"axis": [1, 0, 0]}, "expected the keys axis and angle, found axis"),
        ({"axes": [1, 0, 0], "angle": 1}, "found axes and angle; did you mean 'axis'?"),
        ({"quaternion": [1, 0, 0, 0], "angle": 1}, "expected the key quaternion, found quaternion and angle"),
        ({}, "expected one of diagonal, axis, euler, quaternion, found none"),
        ({"axis": [0, 0, 0], "angle": 1}, "axis: expected a direction, found [0.0, 0.0, 0.0]"),
        ({"axis": [1, 0], "angle": 1}, "axis: expected a list of 3, found a list of 2"),
        ({"axis": [1, 0, 0], "angle": "90 m"}, "angle: the unit 'm' does not fit 'rad'"),
        ({"euler": [1, 0, 0], "sequence": "ZZX"}, "sequence: expected three axes"),
        ({"euler": [1, 0, 0], "sequence": "ZyX"}, "found 'ZyX'"),
        ({"euler": [1, 0, 0], "sequence": 321}, "found 321"),
        ({"quaternion": [1, 1, 0, 0]}, "expected a quaternion of length 1, to 0.001, found one of 1.41421"),
        ({"quaternion": ["1 m", 1, 0, 0]}, "quaternion: the unit 'm' does not fit '1'"),
        ({"diagonal": 3}, "diagonal: expected a list of the values, found 3"),
    ],
)
def test_a_wrong_form_says_what_was_expected(form, message):
    with pytest.raises(QuantityError) as error:
        matrix(form)
    assert message in str(error.value)
