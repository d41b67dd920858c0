"""The imbalance of the plant's wheels beside the motion of a rotor with a product of inertia, and the forces of a mass
that turns off its axis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.blocks import PYRAMID
from tests.plant.motion import FULL_INERTIA

from .driver import Refused, running

INERTIA, SPEED = 2e-5, 500.0
PRODUCT, MOMENT, POSITION = 1e-8, 2e-7, np.array([0.05, -0.1, 0.08])
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
FREE: dict[str, Any] = {
    "gravity_gradient": False,
    "drag": False,
    "J_B": FULL_INERTIA,
    "wheels": 1,
    "wheel_axis": [AXIS, *np.eye(3)],
    "wheel_inertia": [INERTIA] * 4,
    "wheel_momentum_max": [1.0] * 4,
    "h_w0": [INERTIA * SPEED, 0.0, 0.0, 0.0],
    "omega_B0": [0.0, 0.0, 0.0],
}
DYNAMIC = {"wheel_dynamic_imbalance": [PRODUCT, 0.0, 0.0, 0.0]}
STATIC = {"wheel_static_imbalance": [MOMENT, 0.0, 0.0, 0.0], "wheel_position_B": [POSITION, *np.zeros((3, 3))]}
ACROSS = np.cross(AXIS, [0.0, 1.0, 0.0]) / np.linalg.norm(np.cross(AXIS, [0.0, 1.0, 0.0]))


def across(angle: float) -> np.ndarray:
    """The unit vector (3,) that turns with the wheel: at the angle 0 axis x the body axis furthest from it."""
    return Rotation.from_rotvec(angle * AXIS).apply(ACROSS)


def hat(x: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def test_a_rotor_with_a_product_of_inertia_moves_the_body_as_its_turning_inertia_does() -> None:
    """Against DOP853 on the conserved momentum of body and rotor (Hughes, Spacecraft Attitude Dynamics, 3.4), the
    rotor's inertia being turned with it; the plant leaves out the product's part of the satellite's inertia."""
    torque, omega = 2e-3, np.array([0.03, -0.02, 0.01])

    def rotor(angle: float) -> np.ndarray:
        """The product's part (3,3) of the rotor's inertia."""
        lead = across(angle + 0.5 * np.pi)
        return PRODUCT * (np.outer(AXIS, lead) + np.outer(lead, AXIS))

    def speed(t: float) -> float:
        return SPEED + torque / INERTIA * t

    def angle(t: float) -> float:
        return SPEED * t + 0.5 * torque / INERTIA * t**2

    def momentum(t: float, W: np.ndarray, turning: bool) -> np.ndarray:
        return (
            FULL_INERTIA @ W + turning * rotor(angle(t)) @ W + (INERTIA * np.eye(3) + rotor(angle(t))) @ AXIS * speed(t)
        )

    H = momentum(0.0, omega, False)

    def motion(turning: bool) -> np.ndarray:
        def law(t: float, y: np.ndarray) -> np.ndarray:
            R = y.reshape(3, 3)
            whole = FULL_INERTIA + turning * rotor(angle(t))
            W = np.linalg.solve(whole, R.T @ H - momentum(t, np.zeros(3), False))
            return (R @ hat(W)).ravel()

        end = solve_ivp(law, (0.0, 0.5), np.eye(3).ravel(), method="DOP853", rtol=1e-13, atol=1e-15)
        return end.y[:, -1].reshape(3, 3)

    def beside(R: np.ndarray, S: np.ndarray) -> float:
        return float(Rotation.from_matrix(R.T @ S).magnitude())

    found = {}
    for name, start in {"balanced": {}, "as it is": DYNAMIC}.items():
        with running("plant_wheels", **FREE | {"omega_B0": omega, "initial_attitude": "q_NB0"}, **start) as it:
            it.set("wheel_torque_cmd", [torque, 0.0, 0.0, 0.0])
            for i in range(1000):
                it.step(i * 5e-4, 5e-4)
            found[name] = it.get("R_NB")
    effect = beside(found["balanced"], motion(True))
    assert effect > 1e-8
    assert beside(found["as it is"], motion(False)) < 1e-4 * effect
    assert beside(found["as it is"], motion(True)) < 2e-2 * effect


@pytest.mark.parametrize("start", [DYNAMIC, STATIC, DYNAMIC | STATIC], ids=["dynamic", "static", "both"])
def test_at_a_constant_speed_it_acts_by_the_square_of_the_speed(start: dict[str, Any]) -> None:
    """U_d w^2 e and r x U_s w^2 e, e turning at w: twice integrated from rest, with the rate at the start that the
    wheel's wobble has then."""
    product, moment = PRODUCT * ("wheel_dynamic_imbalance" in start), MOMENT * ("wheel_static_imbalance" in start)

    def torque(t: float) -> np.ndarray:
        e = across(SPEED * t)
        return SPEED**2 * (product * e + moment * np.cross(POSITION, e))

    with running("plant_wheels", **FREE, **start) as it:
        rates, h = [it.get("omega_B")], 1e-5
        for i in range(200):
            it.step(i * h, h)
            rates.append(it.get("omega_B"))
    for i in range(1, 200, 7):
        slope = (rates[i + 1] - rates[i - 1]) / (2.0 * h)
        wanted = np.linalg.solve(FULL_INERTIA, torque(i * h))
        assert slope == pytest.approx(wanted, abs=2e-5 * np.linalg.norm(np.linalg.solve(FULL_INERTIA, torque(0.0))))


def test_a_step_of_many_turns_of_the_wheel_ends_where_steps_of_a_hundredth_turn_do() -> None:
    """80 turns a second: 8 turns in a step of 0.1 s, and of 1 s 80. The body's wobble is some 1e-9 rad."""
    ends = {}
    for h in (1.0, 0.1, 1.25e-4):
        with running("plant_wheels", **FREE, **DYNAMIC, **STATIC) as it:
            for i in range(round(1.0 / h)):
                it.step(i * h, h)
            ends[h] = it.get("R_NB")
    with running("plant_wheels", **FREE) as it:
        balanced = it.get("R_NB")
    fine = Rotation.from_matrix(balanced.T @ ends[1.25e-4]).as_rotvec()
    for h in (0.1, 1.0):
        assert Rotation.from_matrix(balanced.T @ ends[h]).as_rotvec() == pytest.approx(
            fine, abs=1e-4 * np.abs(fine).max()
        )


def test_the_total_momentum_is_conserved_while_four_wheels_out_of_balance_are_commanded_at_random() -> None:
    rng = np.random.default_rng(3)
    start = {
        **FREE,
        "wheels": 4,
        "wheel_axis": PYRAMID,
        "wheel_inertia": [1e-5, 2e-5, 3e-5, 4e-5],
        "wheel_momentum_max": [0.03] * 4,
        "wheel_coulomb_friction": [1e-4, 0.0, 2e-4, 0.0],
        "h_w0": [0.02, -0.01, 0.0, 0.015],
        "omega_B0": [0.05, -0.04, 0.03],
        "wheel_dynamic_imbalance": [1e-8, 2e-8, 0.0, 1e-8],
        "wheel_static_imbalance": [0.0, 1e-7, 2e-7, 1e-7],
        "wheel_position_B": rng.uniform(-0.2, 0.2, (4, 3)),
    }
    with running("plant_wheels", **start) as it:
        first, worst, still = it.get("H_N"), 0.0, {**start, "wheel_dynamic_imbalance": [0.0] * 4}
        for i in range(5800):
            it.set("wheel_torque_cmd", rng.normal(scale=2e-3, size=4))
            it.step(float(i), 1.0)
            worst = max(worst, float(np.linalg.norm(it.get("H_N") - first)))
    assert worst < 1e-12 * np.linalg.norm(first)
    with running("plant_wheels", **still | {"wheel_static_imbalance": [0.0] * 4}) as it:
        assert np.linalg.norm(it.get("H_N") - first) > 1e-9, "the wobble has momentum"


@pytest.mark.parametrize(
    ("name", "value"),
    [("wheel_dynamic_imbalance", 3e-5), ("wheel_dynamic_imbalance", -1e-9), ("wheel_static_imbalance", -1e-9)],
)
def test_an_imbalance_that_no_wheel_has_is_refused(name: str, value: float) -> None:
    with (
        pytest.raises(Refused, match=rf"{name}\[2\]"),
        running("plant_wheels", **FREE | {"wheels": 2, name: [0.0, value, 0.0, 0.0]}),
    ):
        pass


def test_a_wheel_at_rest_or_not_there_wobbles_nothing() -> None:
    start = {**FREE, "h_w0": [0.0] * 4, "omega_B0": [0.03, -0.02, 0.01], **DYNAMIC, **STATIC}
    ends = []
    for extra in ({}, {"wheels": 0}, {"wheel_dynamic_imbalance": [0.0] * 4, "wheel_static_imbalance": [0.0] * 4}):
        with running("plant_wheels", **start | extra) as it:
            for i in range(20):
                it.step(float(i), 1.0)
            ends.append(it.get("R_NB"))
    assert ends[0] == pytest.approx(ends[2], abs=1e-15)
    assert ends[1] == pytest.approx(ends[2], abs=1e-15)
