"""Pointing in the mode safe, by field or Sun in body axes alone: a rigid body that takes the rate that is asked for is
the witness.

Shows SV-3.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import supervisor
from supervisor.ports import ACQUIRE, SAFE
from supervisor.safe import rate_towards
from tests.blocks import inputs, parameters

H = 1.0
FIELD_RATE_N = np.array([0.0, 2e-3, 5e-4])
"""rad/s: the field along a polar orbit turns twice in an orbit."""


class Body:
    """A body that turns as it is asked to, in a field that turns; its attitude is not known to the supervisor."""

    def __init__(self, attitude: Rotation, omega_B: Any = (0.0, 0.0, 0.0), **changes: Any) -> None:
        self.p = parameters("supervisor", rate_time=5.0, safe_time=50.0, **changes)
        supervisor.check(self.p)
        self.attitude, self.omega_B, self.t = attitude, np.array(omega_B), 0.0
        self.x = supervisor.start(self.p, self._measured())

    @property
    def field_N(self) -> Any:
        return Rotation.from_rotvec(self.t * FIELD_RATE_N).apply([0.0, 0.0, 3e-5])

    def _measured(self) -> Any:
        directions = {
            "b_B": self.attitude.inv().apply(self.field_N),
            "sun_B": self.attitude.inv().apply([2.0, 0.0, 0.0]),
        }
        return inputs("supervisor", R_NB=np.zeros((3, 3)), omega_B=self.omega_B, attitude_valid=False, **directions)

    def fly(self, steps: int, **changes: Any) -> Any:
        """The outputs after so many steps, in each of which the body takes the rate that was asked for before."""
        for _ in range(steps):
            self.attitude = self.attitude * Rotation.from_rotvec(H * self.omega_B)
            self.t += H
            self.x, y = supervisor.step(self.x, replace(self._measured(), **changes), self.p, H)
            assert y.mode == SAFE
            assert not y.R_ref.any()
            self.omega_B = y.Omega_ref
        return y

    def angle(self, axis_B: Any, direction_N: Any) -> float:
        """Degrees between a body axis and a direction."""
        away = self.attitude.inv().apply(direction_N)
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(axis_B, away)), np.dot(axis_B, away))))


@pytest.mark.parametrize("turn", [[0.3, -0.2, 0.1], [0.0, 2.5, 1.0], [0.0, -np.pi / 2, 0.0], [0.0, np.pi / 2, 0.0]])
def test_the_axis_comes_along_the_field_and_stays_as_the_field_turns(turn: list[float]) -> None:
    """Of the last two the axis begins along the field, and opposite to it."""
    body = Body(Rotation.from_rotvec(turn), safe_pointing="field")
    body.fly(800)
    assert body.angle(body.p.safe_axis_B, body.field_N) < 0.5
    np.testing.assert_allclose(
        body.omega_B @ body.p.safe_axis_B, 0.0, atol=3e-5
    )  # no turn about the field is asked for
    assert np.linalg.norm(body.omega_B) == pytest.approx(np.linalg.norm(FIELD_RATE_N[:2]), rel=0.03)


def test_without_the_rate_of_the_field_the_axis_would_lag() -> None:
    """The lag of a proportional law is the field's rate times safe_time, 5.7 deg here."""
    body = Body(Rotation.identity(), safe_pointing="field")
    body.fly(600)
    y = body.fly(1)
    lag = np.degrees(np.linalg.norm(y.Omega_ref) * body.p.safe_time)
    assert lag > 5.0
    assert body.angle(body.p.safe_axis_B, body.field_N) < 0.1 * lag


def test_the_axis_comes_to_the_sun_and_rests_where_it_is_not_seen() -> None:
    body = Body(Rotation.from_rotvec([0.5, 1.0, -0.4]), safe_pointing="sun")
    body.fly(700)
    assert body.angle(body.p.sun_axis_B, [1.0, 0.0, 0.0]) < 0.1
    assert not body.fly(1, sun_B=np.zeros(3)).Omega_ref.any()


def test_the_rate_that_is_asked_for_is_limited_and_has_an_axis_even_between_opposite_directions() -> None:
    x, y = np.eye(3)[:2]
    np.testing.assert_allclose(rate_towards(x, y, 100.0, 1.0), [0.0, 0.0, 0.5 * np.pi / 100.0])
    np.testing.assert_allclose(rate_towards(x, y, 100.0, 0.01), [0.0, 0.0, 0.01])
    back = rate_towards(x, -x, 100.0, 1.0)
    assert back @ x == 0.0
    assert np.linalg.norm(back) == pytest.approx(np.pi / 100.0)
    np.testing.assert_array_equal(rate_towards(x, x, 100.0, 1.0), np.zeros(3))


def test_with_an_attitude_pointing_gives_way_to_acquisition() -> None:
    p = parameters("supervisor", rate_time=5.0, safe_pointing="field")
    u = inputs("supervisor", b_B=[3e-5, 0.0, 0.0], attitude_valid=True)
    x = supervisor.start(p, u)
    for _ in range(11):
        x, y = supervisor.step(x, u, p, H)
    assert y.mode == ACQUIRE
    assert y.R_ref.any()


@pytest.mark.parametrize(("pointing", "name"), [("field", "b_B"), ("sun", "sun_B")])
def test_a_direction_that_is_not_connected_is_refused(pointing: str, name: str) -> None:
    p = parameters("supervisor", safe_pointing=pointing)
    with pytest.raises(ValueError, match=f"{name}: expected a value, since safe_pointing is '{pointing}'"):
        supervisor.start(p, inputs("supervisor"))
