"""The least angle of a hold with a rod stuck on, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from evidence.health.stuck_on import Held, least_angle

DT, COUNT = 10.0, 60
FIELD = np.tile([0.0, 0.0, 3e-5], (COUNT, 1))
REST = Held(
    np.diag([2.0, 3.0, 4.0]), np.zeros((0, 3)), 0.0, np.array([1.0, 0.0, 0.0]), 0.0, 0.0, np.zeros(3), np.zeros(3)
)


def test_a_constant_torque_that_nothing_opposes_turns_by_the_least_of_all_parabolas():
    """Of theta = a t^2/2 + w t + c over a time T the largest is a T^2/16 at least (Chebyshev)."""
    found = least_angle(replace(REST, disturbance=np.array([0.0, 0.0, 1e-6])), FIELD, np.zeros(3), DT)
    assert found == pytest.approx(1e-6 / 4.0 * (DT * COUNT) ** 2 / 16.0, rel=1e-6)


def test_rods_at_right_angles_to_the_field_oppose_a_dipole_that_is_stuck_on_within_their_limit():
    rods = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    strong, m = replace(REST, rods=rods, dipole_max=5.0), np.array([3.0, 4.0, 9.0])
    assert least_angle(strong, FIELD, m, DT) == pytest.approx(0.0, abs=1e-9)
    assert least_angle(replace(strong, dipole_max=3.5), FIELD, m, DT) > 1e-3


def test_a_wheel_takes_what_is_along_its_axis_up_to_its_momentum():
    pushed = replace(REST, torque_max=1e-3, disturbance=np.array([1e-6, 0.0, 0.0]))
    full = 1e-6 * DT * COUNT
    assert least_angle(replace(pushed, momentum_max=0.5 * full), FIELD, np.zeros(3), DT) == pytest.approx(0.0, abs=1e-9)
    assert least_angle(replace(pushed, momentum_max=0.25 * full), FIELD, np.zeros(3), DT) > 1e-4
