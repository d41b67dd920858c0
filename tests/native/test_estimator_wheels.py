"""The estimator of a satellite with a set of wheels: its first wheel is that of the estimator of one; without a gyro
the rate follows from the momenta of all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.blocks import PYRAMID
from tests.plant.motion import FULL_INERTIA

from .driver import Refused, assert_first_of_set, running

AXES = np.asarray(PYRAMID, float)
TORQUES = np.array([2e-3, -1e-3, 3e-3, 5e-4])
"""N m, of each wheel: none of them balances another."""
SECONDS, H = 60, 0.5
NOT_SEEN: dict[str, Any] = {"b_B_measured": [0.0, 0.0, 0.0], "sun_B_measured": [0.0, 0.0, 0.0]}


def turned(momenta: np.ndarray, torques: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Attitude (3,3) and rate (3,) of a body that is free but for its wheels, by SciPy, from rest at R = 1."""

    def derivative(t: float, x: np.ndarray) -> np.ndarray:
        R, w = x[:9].reshape(3, 3), x[9:]
        inside = (momenta + torques * t) @ AXES
        turning = np.linalg.solve(FULL_INERTIA, np.cross(FULL_INERTIA @ w + inside, w) - torques @ AXES)
        hat = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        return np.concatenate(((R @ hat).ravel(), turning))

    found = solve_ivp(derivative, (0.0, seconds), [*np.eye(3).ravel(), 0.0, 0.0, 0.0], rtol=1e-11, atol=1e-13)
    return found.y[:9, -1].reshape(3, 3), found.y[9:, -1]


def in_free_space(**parameters: Any) -> Any:
    """An estimator without a gyro, whose Earth attracts so little that its gradient turns nothing."""
    given: dict[str, Any] = {"rate_source": "dynamics", "J_B": FULL_INERTIA, "rate_bias_sigma": 1e-9}
    given |= {"wheel_axis": AXES, "wheels": 4, "momentum_random_walk": 1e-9}
    given |= {"R_NB_measured": np.eye(3), "r_N_measured": [7e7, 0.0, 0.0], "v_N_measured": [0.0, 2386.0, 0.0]}
    return running("estimator_wheels", **given | NOT_SEEN | parameters)


@pytest.mark.parametrize("given", ["h_w", "wheel_torque", "both"])
def test_without_a_gyro_the_body_turns_against_all_wheels_of_a_set(given: str) -> None:
    momenta = np.array([0.01, 0.02, -0.01, 0.005]) if given != "wheel_torque" else np.zeros(4)
    R, omega = turned(momenta, TORQUES, SECONDS)
    with in_free_space(**({} if given == "wheel_torque" else {"h_w": momenta})) as it:
        it.set("R_NB_measured", np.zeros((3, 3)))
        for i in range(int(SECONDS / H)):
            if given != "wheel_torque":
                it.set("h_w", momenta + TORQUES * (i + 1) * H)
            if given != "h_w":
                it.set("wheel_torque", TORQUES)
            it.step(i * H, H)
        y = it.outputs()
    assert np.linalg.norm(omega) > 0.03
    assert np.linalg.norm(y["omega_B"] - omega) < 2e-3 * np.linalg.norm(omega)
    assert np.linalg.norm(Rotation.from_matrix(R.T @ y["R_NB"]).as_rotvec()) < np.radians(0.2)


def test_one_wheel_of_the_set_is_the_wheel_of_the_estimator_of_one_bit_by_bit() -> None:
    rng = np.random.default_rng(3)
    start: dict[str, Any] = {"J_B": FULL_INERTIA, "rate_source": "dynamics"}
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    axes = np.vstack((axis, rng.uniform(-1.0, 1.0, (3, 3))))  # of those that are not there: of any length
    with (
        running("estimator", **start, wheel_axis=axis) as one,
        running("estimator_wheels", **start, wheel_axis=axes) as of,
    ):
        for i in range(60):
            attitude = Rotation.from_rotvec([0.01 * i, 0.2, -0.1]).as_matrix()
            momentum, torque, others = 1e-3 * i, 2e-3, rng.normal(scale=0.1, size=3)
            one.set("h_w", momentum)
            one.set("wheel_torque", torque)
            of.set("h_w", [momentum, *others])
            of.set("wheel_torque", [torque, *others])
            for it in (one, of):
                it.set("R_NB_measured", attitude)
                it.step(0.5 * i, 0.5)
            assert_first_of_set(one.outputs(), of.outputs())


@pytest.mark.parametrize("wheels", [-1, 5])
def test_a_number_of_wheels_for_which_there_is_no_place_is_refused(wheels: int) -> None:
    with pytest.raises(Refused, match="wheels.*expected 0 to 4"):
        running("estimator_wheels", wheels=wheels)


def test_telemetry_of_a_set_has_noise_of_its_own_for_each_wheel_and_the_bias_of_each() -> None:
    """The noise of the first wheel is that of the block for one."""
    truth, bias, sigma, n = np.array([0.01, -0.02, 0.03, 0.0]), np.array([1e-4, -2e-4, 0.0, 3e-4]), 1e-5, 4000
    given: dict[str, Any] = {"wheel_momentum_noise": sigma, "seed": 7}
    found, first = [], []
    with (
        running("plant_sensors_wheels", **given, h_w=truth, wheel_momentum_bias=bias) as of_set,
        running("plant_sensors", **given, h_w=0.01) as one,
    ):
        for i in range(n):
            of_set.step(i, 1.0)
            one.step(i, 1.0)
            found.append(of_set.get("h_w_measured"))
            first.append(one.get("h_w_measured"))
    off = np.array(found) - truth
    assert np.abs(off.mean(axis=0) - bias).max() < 4.0 * sigma / np.sqrt(n)
    assert np.abs(np.cov(off.T) / sigma**2 - np.eye(4)).max() < 4.0 * np.sqrt(2.0 / n)
    assert np.abs(np.array(first) + bias[0] - np.array(found)[:, 0]).max() < 1e-16
