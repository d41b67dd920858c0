"""The usual controller: its torque by linear algebra and closed forms, its limits, and slews against the least time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.blocks import PYRAMID
from tests.native.driver import Instance, Refused, running
from tests.plant.motion import FULL_INERTIA

BODY: dict[str, Any] = {"J_B": FULL_INERTIA, "wheels": 4, "wheel_axis": PYRAMID}
INERTIAL: dict[str, Any] = {**BODY, "reference": "inertial"}
NO_FIELD = {"b_B": [0.0, 0.0, 0.0]}


def commanded(parameters: dict[str, Any], **inputs: Any) -> dict[str, Any]:
    with running("controller_wheels", **parameters, **inputs) as it:
        return it.outputs()


def on_body(y: dict[str, Any]) -> np.ndarray:
    """The wheels' torque on the body, N m."""
    return -y["wheel_torque_cmd"] @ PYRAMID


def test_a_small_error_is_answered_by_a_critically_damped_spring_beside_the_gyroscopic_torque() -> None:
    zeta, Omega, h_w = (
        np.array([1e-4, -2e-4, 1.5e-4]),
        np.array([1e-5, 2e-5, -1e-5]),
        np.array([0.01, 0.0, -0.02, 0.01]),
    )
    k = 0.2
    y = commanded(INERTIAL, R_NB=Rotation.from_rotvec(zeta).as_matrix(), omega_B=Omega, h_w=h_w, **NO_FIELD)
    axis = zeta / np.linalg.norm(zeta)
    acceleration = -4.0 * k * (k * zeta + Omega) - k * axis * (axis @ Omega)
    gyroscopic = np.cross(Omega, FULL_INERTIA @ Omega + h_w @ PYRAMID)
    assert on_body(y) == pytest.approx(FULL_INERTIA @ acceleration + gyroscopic, rel=1e-7)
    assert y["attitude_error"] == pytest.approx(np.linalg.norm(zeta), rel=1e-9)


def test_of_all_commands_that_give_the_torque_it_takes_that_with_the_least_squares_over_the_limits() -> None:
    limits = np.array([1e-3, 2e-3, 3e-3, 5e-3])
    y = commanded({**INERTIAL, "wheel_torque_max": limits}, omega_B=[1e-4, -2e-4, 1e-4], **NO_FIELD)
    least = np.linalg.lstsq(-PYRAMID.T * limits, on_body(y), rcond=None)[0] * limits
    assert y["wheel_torque_cmd"] == pytest.approx(least, rel=1e-7)


def test_a_demand_beyond_the_limits_keeps_its_direction() -> None:
    small = commanded(INERTIAL, omega_B=[1e-6, -2e-6, 1e-6], **NO_FIELD)
    large = commanded(INERTIAL, omega_B=[0.1, -0.2, 0.1], **NO_FIELD)
    assert large["demand_fraction"] > 1.0
    assert np.abs(large["wheel_torque_cmd"]).max() == pytest.approx(3e-3)
    gyroscopic = np.cross([0.1, -0.2, 0.1], FULL_INERTIA @ [0.1, -0.2, 0.1])
    wanted = on_body(small) * 1e5 + gyroscopic
    assert np.cross(on_body(large), wanted) == pytest.approx(np.zeros(3), abs=1e-5 * np.linalg.norm(wanted) * 3e-3)


def test_no_command_takes_a_wheel_beyond_its_momentum_within_a_period() -> None:
    y = commanded(
        {**INERTIAL, "command_period": 2.0}, omega_B=[0.05, 0.05, 0.05], h_w=[0.029, -0.029, 0.0, 0.031], **NO_FIELD
    )
    after = np.array([0.029, -0.029, 0.0, 0.031]) + 2.0 * y["wheel_torque_cmd"]
    assert (np.abs(after[:3]) <= 0.03 + 1e-15).all()
    assert after[3] <= 0.031


def test_the_rods_take_the_momentum_across_the_field_away_in_the_unloading_time_and_the_wheels_bear_it() -> None:
    h_w, b = np.array([1e-4, 2e-4, -1e-4, 3e-4]), np.array([2e-5, 1e-5, -3e-5])
    with running("controller_wheels", **INERTIAL, b_B=b, h_w=h_w) as it:
        y, rods = it.outputs(), it.get("rod_axes")
    torque = np.cross(y["dipole_cmd"] @ rods, b)
    H = h_w @ PYRAMID
    across = H - b * (b @ H) / (b @ b)
    assert torque == pytest.approx(-across / 500.0, rel=1e-9)
    assert on_body(y) == pytest.approx(-torque, rel=1e-7)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_directions_without_wheels_are_left_alone(count: int) -> None:
    axes = np.vstack((np.eye(3), [1.0, 0.0, 0.0]))
    y = commanded({**INERTIAL, "wheels": count, "wheel_axis": axes}, omega_B=[1e-4, 1e-4, 1e-4], **NO_FIELD)
    assert not y["wheel_torque_cmd"][count:].any()
    assert (np.abs(y["wheel_torque_cmd"][:count]) > 1e-6).all()


@pytest.mark.parametrize(
    ("angle", "axis"),
    [(10.0, [1.0, 2.0, -1.0]), (30.0, [0.0, 0.0, 1.0]), (90.0, [1.0, 0.0, 0.0]), (180.0, [2.0, -1.0, 2.0])],
)
def test_a_slew_settles_near_the_least_time_of_a_turn_about_its_axis_with_this_distribution(
    angle: float, axis: list[float]
) -> None:
    least, settled = slewed(angle, np.array(axis) / np.linalg.norm(axis))
    assert least < settled < 1.2 * least + 6.0


def slewed(angle: float, axis: np.ndarray, **parameters: Any) -> tuple[float, float]:
    """Least time of a turn from rest to rest about the axis within all limits of the wheels, and the time from which on
    the error is below 0.1 deg, both in s; angle in deg."""
    shares = np.abs(np.linalg.pinv(PYRAMID.T) @ FULL_INERTIA @ axis).max()  # of the wheel that bears most
    a, rate, turn = 3e-3 / shares, 0.03 / shares, math.radians(angle)
    least = 2.0 * math.sqrt(turn / a) if turn < rate**2 / a else turn / rate + rate / a
    h, settled = 0.5, 0.0
    still = {"gravity_gradient": False, "drag": False, "initial_attitude": "q_NB0", "omega_B0": [0.0, 0.0, 0.0]}
    q = np.roll(Rotation.from_rotvec(turn * axis).as_quat(), 1)
    with running("plant_wheels", **BODY, **still, q_NB0=q) as body, Instance("controller_wheels") as law:
        for name, value in {**INERTIAL, **parameters, **NO_FIELD}.items():
            law.set(name, value)
        for i in range(int(4.0 * least / h) + 100):
            for name in ("R_NB", "omega_B", "h_w"):
                law.set(name, body.get(name))
            law.initialize() if i == 0 else law.step((i - 1) * h, h)
            if law.get("attitude_error") > math.radians(0.1):
                settled = (i + 1) * h
            body.set("wheel_torque_cmd", law.get("wheel_torque_cmd"))
            body.step(i * h, h)
    return least, settled


def test_an_attitude_that_is_none_is_refused() -> None:
    with pytest.raises(Refused, match="R_NB: expected a rotation matrix"):
        running("controller_wheels", R_NB=np.diag([1.0, 1.0, 0.9]))
    with pytest.raises(Refused, match=r"wheel_axis\[2\]: expected a vector of unit length"):
        running("controller_wheels", wheels=2, wheel_axis=np.vstack((np.eye(3)[0], np.zeros((3, 3)))))


def test_without_an_attitude_it_damps_the_rate_alone() -> None:
    Omega = np.array([1e-4, -2e-4, 1e-4])
    y = commanded({**INERTIAL, "reference": "lvlh"}, R_NB=np.zeros((3, 3)), omega_B=Omega, **NO_FIELD)
    expected = -4.0 * 0.2 * FULL_INERTIA @ Omega + np.cross(Omega, FULL_INERTIA @ Omega)
    assert on_body(y) == pytest.approx(expected, rel=1e-7)
    assert y["attitude_error"] == pytest.approx(math.pi)
    assert y["rate_error_B"] == pytest.approx(Omega)
