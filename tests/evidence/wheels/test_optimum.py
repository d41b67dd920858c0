"""The least time of sets of wheels: turns by their closed form, and by an optimum that is known."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evidence.optimum.courses import Course, of
from evidence.optimum.motion import Motion
from evidence.optimum.problem import HOLD, Grid
from evidence.optimum.transcription import solve
from evidence.wheels.bound import of_plant
from evidence.wheels.kept import load_least

J, TORQUE = 2.0, 3e-3


def cube(momentum=1.0):
    """A body of equal moments with wheels along its axes, far out, where LVLH and the field hardly move."""
    start = {
        "J_B": {"diagonal": [J] * 3},
        "wheels": 3,
        "wheel_axis": np.vstack((np.eye(3), [1.0, 0.0, 0.0])),
        "wheel_torque_max": [TORQUE] * 4,
        "wheel_momentum_max": [momentum] * 4,
        "orbit_radius": 1e9,
        "drag": False,
        "dipole_max": 1e-3,
    }
    return of_plant({}, start)


def turn(p, angle, wobble=0.0):
    """From rest to rest about e1; `wobble`: of the guess, rad."""
    motion = Motion(p, 400.0)
    times = np.arange(0.0, 100.0 + HOLD + 1.0)
    left = angle * np.clip(1.0 - times / 100.0, 0.0, 1.0)
    beside = wobble * np.sin(np.pi * np.clip(times / 100.0, 0.0, 1.0))
    attitudes = Rotation.from_rotvec(np.column_stack((left, beside, beside)))
    n = len(times)
    course = Course(times, attitudes, np.zeros((n, 3)), np.zeros((n, p.wheels)), np.zeros((n, 3 + p.wheels)))
    return of(solve(motion.task(math.radians(0.1), 1e-4), course.guess(Grid(5.0, 40))))


def test_a_short_turn_about_a_wheels_axis_takes_twice_the_root_of_the_angle_over_the_acceleration():
    found = turn(cube(), 0.5)
    assert found.end == pytest.approx(2.0 * math.sqrt(0.5 * J / TORQUE), rel=0.02)
    np.testing.assert_allclose(np.abs(found.u[2:17, 3]), 1.0, atol=0.02)


def test_the_momentum_of_the_wheels_bounds_the_rate_of_a_turn():
    """About one axis over L/tau and then at the rate L/J; about changing axes it is some percent sooner over."""
    found, momentum = turn(cube(0.02), 0.5), 0.02
    assert 2.0 * math.sqrt(0.5 * J / TORQUE) < found.end < 0.5 * J / momentum + momentum / TORQUE
    assert np.abs(found.l_w).max() == pytest.approx(momentum, rel=1e-4)


def test_half_a_turn_is_sooner_over_about_changing_axes_as_bilimoria_and_wie_found():
    """J. Guidance 16(3), 1993: 3.2431 in the unit sqrt(J/tau), 2 sqrt(pi) = 3.5449 about one axis."""
    found = turn(cube(), math.radians(179.9), wobble=0.5)
    assert found.end == pytest.approx(3.2431 * math.sqrt(J / TORQUE), rel=0.02)


# ---------------------------------------------------------------- docs/evidence/wheels_optimum.csv


def test_each_best_motion_is_confirmed_of_ten_starts_and_not_below_the_bound_of_momentum():
    for line in load_least():
        assert line.tried >= 10
        assert line.check_angle_deg < 5.0
        assert line.check_rate_rad_s < 1e-3
        assert not line.best_s < line.bound_s
