"""The plant with a set of wheels: what is conserved, closed forms, its order, and one of its wheels beside the plant of
one wheel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.blocks import PYRAMID
from tests.plant.motion import FULL_INERTIA, measured_order

from .driver import Instance, Refused, assert_first_of_set, running

FREE: dict[str, Any] = {"gravity_gradient": False, "drag": False, "J_B": FULL_INERTIA}
FOUR: dict[str, Any] = {**FREE, "wheels": 4, "wheel_axis": PYRAMID}


def flown(it: Instance, h: float, n: int, **inputs: Any) -> Instance:
    for name, value in inputs.items():
        it.set(name, value)
    for i in range(n):
        it.step(i * h, h)
    return it


def test_one_wheel_of_the_set_is_the_wheel_of_the_plant_bit_by_bit() -> None:
    rng = np.random.default_rng(1)
    start: dict[str, Any] = {"J_B": FULL_INERTIA, "omega_B0": [0.03, -0.02, 0.01]}
    wheel = {"h_w0": 0.025, "wheel_viscous_friction": 1e-7, "wheel_coulomb_friction": 2e-4}
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    of_set = {name: [value, 0.0, 0.0, 0.0] for name, value in wheel.items()}
    unused = rng.normal(size=(3, 3))
    axes = np.vstack((axis, unused / np.abs(unused).max()))
    with (
        running("plant", **start, **wheel, wheel_axis=axis) as one,
        running("plant_wheels", **start, **of_set, wheel_axis=axes) as four,
    ):
        for i in range(100):
            dipole, torque = rng.normal(scale=20.0, size=3), rng.choice([3e-3, -3e-3, 1e-4])
            one.set("wheel_torque_cmd", torque)
            four.set("wheel_torque_cmd", [torque, *rng.normal(scale=1e-3, size=3)])
            for it in (one, four):
                it.set("dipole_cmd", dipole)
                it.step(0.7 * i, 0.7)
            assert_first_of_set(one.outputs(), four.outputs())


def test_the_total_momentum_is_conserved_over_an_orbit_while_four_wheels_are_commanded_at_random() -> None:
    rng = np.random.default_rng(2)
    start = {"omega_B0": [0.05, -0.04, 0.03], "h_w0": [0.02, -0.01, 0.0, 0.015], "step_max": 0.5}
    friction = {"wheel_coulomb_friction": [1e-4, 0.0, 2e-4, 0.0], "wheel_viscous_friction": [0.0, 1e-7, 0.0, 3e-7]}
    with running("plant_wheels", **FOUR, **start, **friction) as it:
        first = it.get("H_N")
        worst, moved, full = 0.0, 0.0, False
        for i in range(5800):
            it.set("wheel_torque_cmd", rng.normal(scale=2e-3, size=4))
            it.step(float(i), 1.0)
            worst = max(worst, float(np.linalg.norm(it.get("H_N") - first)))
            full = full or bool(it.get("wheel_momentum_saturated").any())
            moved = max(moved, float(np.abs(it.get("h_w")).max()))
    assert worst < 1e-12 * np.linalg.norm(first)
    assert moved == pytest.approx(0.03), "the wheels were driven into their limits"
    assert full


def test_wheels_that_spin_up_turn_a_free_body_from_rest_about_one_axis_as_the_closed_form_says() -> None:
    """The total momentum is zero, so J Omega = -sum l_i u_i: about J^-1 sum tau_i u_i by half its length times t^2."""
    torques = np.array([1e-3, -5e-4, 2e-3, 0.0])
    with running("plant_wheels", **FOUR, omega_B0=[0.0, 0.0, 0.0], integrator_order=6) as it:
        R0 = it.get("R_NB")
        flown(it, 0.5, 20, wheel_torque_cmd=torques)
        rate = -np.linalg.solve(FULL_INERTIA, torques @ PYRAMID)
        assert it.get("omega_B") == pytest.approx(rate * 10.0, rel=1e-12, abs=1e-18)
        turned = Rotation.from_matrix(R0.T @ it.get("R_NB")).as_rotvec()
        assert turned == pytest.approx(rate * 50.0, rel=1e-9)
        assert it.get("h_w") == pytest.approx(torques * 10.0, rel=1e-13)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_order_is_kept_with_four_wheels_of_which_some_stop_or_reach_their_limits(order: int) -> None:
    """Against DOP853 on J dOmega/dt = -Omega x (J Omega + sum l_i u_i) - sum u_i dl_i/dt, stopped where a wheel is."""
    torques, start = np.array([2e-3, -1e-3, 1.5e-3, -3e-3]), np.array([0.025, 0.004, -0.01, 0.012])
    coulomb, omega = np.array([0.0, 2e-4, 0.0, 0.0]), np.array([0.08, -0.1, 0.07])
    # Wheel 1 reaches 30 mN m s at 2.5 s; wheel 2 stands at 4/1.2 s and turns on under 0.8 mN m.
    rates = ((2e-3, -1.2e-3, 1.5e-3, -3e-3), (0.0, -1.2e-3, 1.5e-3, -3e-3), (0.0, -0.8e-3, 1.5e-3, -3e-3))
    y = np.concatenate((np.eye(3).ravel(), omega, start))
    for dl, (t0, t1) in zip(rates, ((0.0, 2.5), (2.5, 4.0 / 1.2), (4.0 / 1.2, 8.0)), strict=True):

        def law(t: float, y: np.ndarray, dl: tuple[float, ...] = dl) -> np.ndarray:
            R, W, wheels = y[:9].reshape(3, 3), y[9:12], y[12:]
            dW = np.linalg.solve(FULL_INERTIA, -np.cross(W, FULL_INERTIA @ W + wheels @ PYRAMID) - dl @ PYRAMID)
            return np.concatenate(((R @ hat(W)).ravel(), dW, dl))

        y = solve_ivp(law, (t0, t1), y, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    errors = {}
    for step in {2: (1.0, 0.5, 0.25), 4: (2.0, 1.0, 0.5), 6: (2.0, 1.0, 0.5)}[order]:
        options = {"integrator_order": order, "step_max": step, "wheel_coulomb_friction": coulomb}
        with running("plant_wheels", **FOUR, omega_B0=omega, h_w0=start, initial_attitude="q_NB0", **options) as it:
            flown(it, 8.0, 1, wheel_torque_cmd=torques)
            turned = Rotation.from_matrix(it.get("R_NB").T @ y[:9].reshape(3, 3)).magnitude()
            errors[step] = turned + np.abs(it.get("omega_B") - y[9:12]).max()
            assert it.get("h_w") == pytest.approx(y[12:], abs=1e-14)
    assert measured_order(errors) > order - 0.35


def hat(x: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def test_without_wheels_no_command_moves_the_body_and_nothing_is_told_of_them() -> None:
    given = {"h_w0": [0.01] * 4, "omega_B0": [0.03, -0.02, 0.01], "wheel_axis": np.zeros((4, 3))}
    with (
        running("plant_wheels", **FREE, wheels=0, **given) as it,
        running("plant", **FREE, omega_B0=given["omega_B0"]) as still,
    ):
        flown(it, 1.0, 20, wheel_torque_cmd=[1e-3] * 4)
        flown(still, 1.0, 20)
        assert np.array_equal(it.get("R_NB"), still.get("R_NB"))
        for name in ("h_w", "wheel_torque", "wheel_speed", "wheel_torque_saturated", "wheel_momentum_saturated"):
            assert not it.get(name).any(), name


def test_a_drive_that_is_dead_reversed_or_weak_gives_its_share_of_the_clipped_command() -> None:
    with running("plant_wheels", **FOUR, wheel_gain=[1.0, 0.0, -1.0, 0.5]) as it:
        it.set("wheel_torque_cmd", [1e-3, 1e-3, 1e-3, 1.0])
        assert it.get("wheel_torque") == pytest.approx([1e-3, 0.0, -1e-3, 0.5 * 3e-3])
        assert it.get("wheel_torque_saturated").tolist() == [False, False, False, True]


def test_a_wheel_at_rest_breaks_away_above_its_breakaway_friction_and_then_feels_coulombs() -> None:
    friction = {"wheel_coulomb_friction": [1e-4] * 4, "wheel_breakaway_friction": [4e-4, 4e-4, 0.0, 0.0]}
    with running("plant_wheels", **FOUR, **friction, h_w0=[0.0, 0.0, 0.0, 0.01]) as it:
        flown(it, 1.0, 1, wheel_torque_cmd=[3.9e-4, -4.1e-4, 1.1e-4, 3.9e-4])
        assert it.get("h_w") == pytest.approx([0.0, -3.1e-4, 1e-5, 0.01 + 2.9e-4], abs=1e-17)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wheels": 5}, "wheels: expected 0 to 4, found 5"),
        (
            {"wheels": 3, "wheel_axis": [*PYRAMID[:2], [0.0, 0.0, 0.5], [0.0] * 3]},
            r"wheel_axis\[3\]: expected a vector",
        ),
        ({"wheels": 2, "h_w0": [0.0, 0.04, 0.0, 0.0]}, r"h_w0\[2\]: expected within wheel_momentum_max, found 0.04"),
    ],
)
def test_wheels_that_cannot_be_are_refused_by_their_numbers(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(Refused, match=message):
        running("plant_wheels", **changes)
