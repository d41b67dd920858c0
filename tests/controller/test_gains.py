"""The gain schedule [9], [10].

Shows CT-2.
"""

import math

import pytest

from controller import gains


def test_gain_scales_of_the_paper_by_hand():
    # A start 90 deg off: (3.5 + 1.570796)/(35 + 1.570796) = 0.1386570; later, 0.2 rad off: 3.7/36.570796 = 0.1011736.
    assert gains.attitude_scale(0.098, 3.5, 35.0, math.pi / 2, math.pi / 2) == pytest.approx(
        0.098 * 0.1386570, rel=1e-6
    )
    assert gains.attitude_scale(0.098, 3.5, 35.0, 0.2, math.pi / 2) == pytest.approx(0.098 * 0.1011736, rel=1e-6)
    # A start at 0.1 rad/s: 2.2/21.1 = 0.1042654; later, 0.03 rad/s: 2.13/21.1 = 0.1009479.
    assert gains.rate_scale(1.47, 2.1, 21.0, 0.1, 0.1) == pytest.approx(1.47 * 0.1042654, rel=1e-6)
    assert gains.rate_scale(1.47, 2.1, 21.0, 0.03, 0.1) == pytest.approx(1.47 * 0.1009479, rel=1e-6)


def test_gain_scales_at_rest_are_a_tenth_when_started_at_rest():
    assert gains.attitude_scale(0.098, 3.5, 35.0, 0.0, 0.0) == pytest.approx(0.0098)
    assert gains.rate_scale(1.47, 2.1, 21.0, 0.0, 0.0) == pytest.approx(0.147)
