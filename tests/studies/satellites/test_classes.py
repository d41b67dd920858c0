"""The classes of docs/satellites.md: bodies that exist, and tumbles of each that can be flown."""

import numpy as np
import pytest

from studies.satellites.classes import CLASSES, DURATION, box, settled, tumbles


@pytest.mark.parametrize("name", CLASSES)
def test_each_class_is_a_body(name):
    moments = sorted(CLASSES[name].moments)
    assert moments[0] > 0.0
    assert moments[2] <= moments[0] + moments[1]


def test_a_box_has_the_moments_of_its_points():
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.5, 0.5, (400_000, 3)) * [0.1, 0.2, 0.3]
    squares = (points**2).mean(axis=0)
    assert box(2.0, 0.1, 0.2, 0.3) == pytest.approx(2.0 * (squares.sum() - squares), rel=0.01)


@pytest.mark.parametrize("errors", [False, True])
def test_the_tumbles_of_a_class_are_a_campaign(errors):
    assert tumbles("3U", 5, errors).case.runs == 5


def test_settled_is_the_later_of_both_and_not_at_the_end():
    angle = np.array([100.0, 50.0, np.nan, DURATION - 1.0])
    rate = np.array([40.0, 60.0, 10.0, 10.0])
    assert settled(angle, rate).tolist() == [100.0, 60.0, np.inf, np.inf]
