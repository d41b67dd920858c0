"""The best hold against closed forms of the momentum along the field."""

import math

import numpy as np
import pytest

from studies.flight.bound import loop, starts
from studies.hold import best
from studies.satellites.classes import tumbles


@pytest.fixture(scope="module")
def tumble():
    """A satellite of 50 kg at an inclination where the field turns."""
    data = starts(tumbles("50 kg", 8, errors=True))
    return next(one for one in data if math.radians(60.0) < one["blocks"]["plant"]["start"]["inclination"])


def plant_of(data, **changes):
    start = data["blocks"]["plant"]["start"] | changes
    return loop({"blocks": {"plant": data["blocks"]["plant"] | {"start": start}}, "shared": data["shared"]}).plant


def test_where_the_field_turns_a_disturbance_of_a_hundredth_of_the_rods_is_held_to_the_end(tumble):
    found = best(plant_of(tumble), 9000.0)
    assert found.gap < 1e-5
    assert found.largest < math.radians(0.1)


@pytest.mark.thorough
def test_a_motion_by_rods_alone_does_not_swing_out_between_the_ends_of_its_intervals(monkeypatch):
    """Intervals of twice the length give the same hold; an error that counted at their ends alone gave a tenth of it."""
    data = starts(tumbles("1U, no wheel", 4))[3]
    fine = best(plant_of(data), 9000.0)
    monkeypatch.setattr("studies.hold.LONGEST", 60.0)
    coarse = best(plant_of(data), 9000.0)
    assert (fine.rms, fine.largest) == pytest.approx((coarse.rms, coarse.largest), rel=0.02)


def test_where_the_largest_error_is_least_it_is_near_the_rms(monkeypatch):
    """At an optimum of a largest error much of the motion is at it, so mean and largest come together; a least mean swings out."""
    monkeypatch.setattr("studies.hold.LONGEST", 240.0)
    p = plant_of(starts(tumbles("50 kg, inertia x10", 41, errors=True))[40])
    mean, even = best(p, 9000.0), best(p, 9000.0, evenly=True)
    assert even.gap < 1e-5
    assert mean.rms <= even.rms <= even.largest < 0.6 * mean.largest
    assert even.largest < 1.1 * even.rms


class AlongTheNormal:
    """A steady field along the orbit's normal, the pitch axis."""

    def __init__(self, p):
        r, v = (np.array(x) for x in p.orbit.position_velocity(0.0))
        self.normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))

    def at(self, t):
        return 3e-5 * self.normal


@pytest.mark.thorough
def test_across_a_steady_field_the_rods_undo_a_disturbance_and_along_it_only_turning_it_away_does(tumble, monkeypatch):
    """H.b grows by d.b: over a motion that ends as it began d.b is zero in the mean, so d is once at 90 deg or more from pitch."""
    monkeypatch.setattr("plant.parameters.Parameters.field", property(AlongTheNormal))
    across = best(plant_of(tumble, disturbance_torque_B=[1e-5, 0.0, 0.0]), 9000.0)
    assert across.gap < 1e-5
    assert across.largest < math.radians(0.1)
    along = best(plant_of(tumble, disturbance_torque_B=[0.0, 1e-5, 0.0]), 9000.0)
    assert along.gap > 1e-4 or along.largest >= math.radians(90.0)
