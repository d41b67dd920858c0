"""Momentum that the rods take away in the hold, beside the closed form of averaging along a field that turns."""

from __future__ import annotations

import numpy as np
import pytest

from tests.native.driver import Instance

from .loop import THREE

H, CONE, TIME, FIELD = 10.0, 200.0, 3000.0, 3e-5
"""s, a sample; s, a turn of the field; s, unloading_time; T."""
LEAST, MEAN = 0.03, 2.0 / 3.0
"""docs/how/planned-wheels.md, (12)."""


def field(t: float, axis: int, angle: float) -> np.ndarray:
    """T: on a cone about an axis of N."""
    turn = 2.0 * np.pi * t / CONE
    return FIELD * np.roll([np.cos(angle), np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn)], axis)


@pytest.mark.parametrize("degrees", [10.0, 20.0])
def test_momentum_along_the_mean_field_is_taken_away_as_averaging_says_for_one_mean_and_the_next(
    degrees: float,
) -> None:
    """The field turns about one axis, then about another. The mean is known after some orbits, and momentum
    along it falls by (2/3 + 0.03) s/(s + 0.03)/T, where s, sin^2 of the angle, is the mean of what is across the axis.
    """
    angle, t = np.radians(degrees), 0.0
    share = np.sin(angle) ** 2
    rate = (MEAN + LEAST) * share / (share + LEAST) / TIME
    with Instance("controller_planned_wheels") as law:
        law.set("wheels", 3)
        law.set("wheel_axis", THREE)
        law.set("wheel_momentum_max", [1.0] * 4)
        law.set("rod_axes", np.eye(3))
        law.set("reference", "inertial")
        law.set("unloading_time", TIME)
        law.set("command_period", H)
        law.set("bandwidth", 1e-3)
        law.set("b_B", field(t, 0, angle))
        law.initialize()
        for axis in (0, 2):
            momentum = np.zeros(3)
            for i in range(5000):
                if i == 4500:
                    momentum[axis] = 0.02
                b = field(t, axis, angle)
                law.set("b_B", b)
                law.set("h_w", [*momentum, 0.0])
                law.step(t, H)
                t += H
                momentum = momentum + H * np.cross(law.get("dipole_ff"), b)
            assert momentum[axis] / 0.02 == pytest.approx(np.exp(-rate * 500 * H), rel=0.02)
