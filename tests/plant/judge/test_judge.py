"""The judge against closed forms and SciPy, in both flavours."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plant.judge as judge
from tests.blocks import inputs, parameters
from tests.native.driver import Instance, Refused

RNG = np.random.default_rng(1)
AXES = [v / np.linalg.norm(v) for v in (*np.eye(3), *RNG.normal(size=(5, 3)), np.array([1.0, 1e-8, -1.0]))]
ANGLES = [0.0, 1e-9, 1.234, math.pi - 1e-9, math.pi]
RADIUS = 7.0e6
N = 1.1e-3
"""rad/s, of a circular orbit about the axis (1, 2, 2)/3."""
PLANE = np.column_stack(([2.0, 1.0, -2.0], [-2.0, 2.0, -1.0], [1.0, 2.0, 2.0])) / 3.0
"""Columns: the position at t = 0, the direction of flight, the orbit's normal. A rotation by hand."""


def orbit(t: float) -> dict[str, Any]:
    """Position and velocity on the circle."""
    c, s = math.cos(N * t), math.sin(N * t)
    return {"r_N": RADIUS * PLANE @ [c, s, 0.0], "v_N": RADIUS * N * PLANE @ [-s, c, 0.0]}


def lvlh(t: float) -> np.ndarray:
    """X along the velocity, Y against the normal, Z down, as columns: by hand on the circle."""
    c, s = math.cos(N * t), math.sin(N * t)
    return PLANE @ np.array([[-s, 0.0, -c], [c, 0.0, -s], [0.0, -1.0, 0.0]])


def python(changes: dict[str, Any], steps: int, **u: Any) -> tuple[float, np.ndarray]:
    """Errors after some steps of 0.5 s with these inputs."""
    p = parameters("plant_judge", **changes)
    judge.check(p)
    truth = inputs("plant_judge", **u)
    x = judge.start(p, truth)
    y = judge.outputs(x, truth, p)
    for _ in range(steps):
        x, y = judge.step(x, truth, p, 0.5)
    return y.attitude_error, y.rate_error_B


def native(changes: dict[str, Any], steps: int, **u: Any) -> tuple[float, np.ndarray]:
    with Instance("plant_judge") as it:
        it.set_all(parameters("plant_judge", **changes))
        it.set_all(inputs("plant_judge", **u))
        it.initialize()
        for k in range(steps):
            it.step(0.5 * k, 0.5)
        y = it.outputs()
    return float(y["attitude_error"]), np.asarray(y["rate_error_B"])


@pytest.fixture(params=[python, native], ids=["python", "native"])
def errors(request):
    return request.param


@pytest.mark.parametrize("angle", ANGLES)
def test_the_attitude_error_to_lvlh_is_the_angle_of_the_turn_from_identity_to_half_turn(errors, angle):
    for k, axis in enumerate(AXES):
        turn = Rotation.from_rotvec(angle * axis)
        t = 700.0 * k
        found, _ = errors({}, 0, R_NB=lvlh(t) @ turn.as_matrix(), **orbit(t))
        assert found == pytest.approx(angle, abs=1e-15, rel=2e-15)
        assert found == pytest.approx(turn.magnitude(), abs=1e-15, rel=2e-15)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_rate_error_to_lvlh_is_the_body_rate_less_the_orbits_rate_in_body_axes(errors, angle):
    for k, axis in enumerate(AXES):
        R = lvlh(700.0 * k) @ Rotation.from_rotvec(angle * axis).as_matrix()
        orbital_B = R.T @ (N * PLANE[:, 2])  # the orbit's angular velocity, by hand
        own = np.array([0.04, -0.08, 0.02])
        _, found = errors({}, 0, R_NB=R, omega_B=orbital_B + own, **orbit(700.0 * k))
        assert found == pytest.approx(own, abs=1e-16, rel=1e-12)


@pytest.mark.parametrize("vector", [[0.0, 0.0, 0.0], [0.4, -1.1, 0.7]])
def test_at_rest_in_lvlh_both_errors_are_zero_round_the_orbit(errors, vector):
    Q = Rotation.from_rotvec(vector).as_matrix()
    for t in np.linspace(0.0, 2.0 * math.pi / N, 9):
        attitude, rate = errors({"R_d0": Q}, 1, R_NB=lvlh(t) @ Q, omega_B=Q.T @ [0.0, -N, 0.0], **orbit(t))
        assert attitude <= 1e-15
        assert np.abs(rate).max() <= 1e-18


@pytest.mark.parametrize("angle", ANGLES)
def test_errors_to_a_fixed_attitude_are_angle_and_body_rate_at_any_time(errors, angle):
    R_d0 = Rotation.from_rotvec([0.9, -0.7, 0.5]).as_matrix()
    for axis in AXES:
        R = R_d0 @ Rotation.from_rotvec(angle * axis).as_matrix()
        attitude, rate = errors({"reference": "inertial", "R_d0": R_d0}, 3, R_NB=R, omega_B=[0.04, -0.08, 0.02])
        assert attitude == pytest.approx(angle, abs=1e-15, rel=2e-15)
        assert rate.tolist() == [0.04, -0.08, 0.02]


@pytest.mark.parametrize("steps", [0, 1, 7])
def test_errors_to_a_reference_with_constant_rate_follow_its_turn(errors, steps):
    """Witness: SciPy's exponential, and the composition of rotations."""
    start, rate_d, own = (
        Rotation.from_rotvec([0.9, -0.7, 0.5]),
        np.array([0.2, -0.1, 0.3]),
        np.array([0.01, 0.02, -0.03]),
    )
    desired = start * Rotation.from_rotvec(0.5 * steps * rate_d)
    turn = Rotation.from_rotvec([0.3, 0.4, 1.2])
    changes = {"reference": "rate", "R_d0": start.as_matrix(), "Omega_d0": rate_d}
    omega = turn.inv().apply(rate_d) + own
    attitude, rate = errors(changes, steps, R_NB=(desired * turn).as_matrix(), omega_B=omega)
    assert attitude == pytest.approx(1.3, rel=1e-14)
    assert rate == pytest.approx(own, abs=1e-16, rel=1e-13)


def test_connected_r_d_and_omega_d_take_the_place_of_each_parameter_reference(errors):
    desired, turn = Rotation.from_rotvec([-1.0, 2.0, 0.4]), Rotation.from_rotvec([0.0, -0.6, 0.8])
    rate_d, own = np.array([0.2, -0.1, 0.3]), np.array([0.01, 0.02, -0.03])
    truth = {"R_NB": (desired * turn).as_matrix(), "omega_B": turn.inv().apply(rate_d) + own}
    for reference in ("lvlh", "inertial", "rate"):
        changes = {"reference": reference, "Omega_d0": [0.1, 0.1, 0.1]}
        attitude, rate = errors(changes, 2, **truth, R_d=desired.as_matrix(), Omega_d=rate_d)
        assert attitude == pytest.approx(1.0, rel=1e-14)
        assert rate == pytest.approx(own, abs=1e-16, rel=1e-13)


@pytest.mark.parametrize(("present", "missing"), [("R_d", "Omega_d"), ("Omega_d", "R_d")])
def test_one_of_r_d_and_omega_d_without_the_other_is_refused(errors, present, missing):
    value = {"R_d": np.eye(3), "Omega_d": np.zeros(3)}[present]
    with pytest.raises(
        (ValueError, Refused), match=rf"{missing}: expected .*since {present} is.* connect both or neither"
    ):
        errors({}, 0, **{present: value})


def test_an_attitude_of_almost_zeros_is_refused_and_not_called_an_angle(errors):
    # Exact zeros mean that there is none yet: tests/fmus/test_no_attitude.py.
    with pytest.raises((ValueError, Refused), match="R_NB: expected a rotation matrix, .*found 1"):
        errors({}, 0, R_NB=np.full((3, 3), 1e-12))


def test_a_single_precision_attitude_is_judged_to_its_own_precision(errors):
    for angle in ANGLES:
        R = (lvlh(0.0) @ Rotation.from_rotvec(angle * AXES[4]).as_matrix()).astype(np.float32).astype(float)
        attitude, _ = errors({}, 0, R_NB=R, **orbit(0.0))
        assert attitude == pytest.approx(angle, abs=1e-6)


def test_four_printed_decimals_of_the_reference_are_projected_onto_a_rotation(errors):
    exact = Rotation.from_rotvec([0.9, -0.7, 0.5]).as_matrix()
    attitude, _ = errors({"reference": "inertial", "R_d0": exact.round(4)}, 0, R_NB=exact)
    assert 1e-6 < attitude < 1e-4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reference": "sun"}, "reference: expected one of lvlh, inertial, rate, found 'sun'"),
        ({"Omega_d0": [0.0, math.nan, 0.0]}, r"Omega_d0: expected finite numbers, found \[0.0, nan, 0.0\]"),
        ({"R_d0": np.diag([1.0, 1.0, 0.99])}, "R_d0: expected a rotation matrix, max .* at most 0.001, found 0.0199"),
        ({"R_d0": np.diag([1.0, 1.0, -1.0])}, r"R_d0: expected a rotation matrix, determinant \+1, found -1"),
    ],
)
def test_parameters_it_cannot_work_with_are_refused_with_name_and_value(changes, message):
    with pytest.raises(ValueError, match=message):
        judge.check(parameters("plant_judge", **changes))


def test_an_input_that_is_not_finite_is_refused():
    for name, value in {
        "omega_B": [0.0, math.nan, 0.0],
        "r_N": [math.inf, 0.0, 0.0],
        "v_N": [0.0, 0.0, math.nan],
    }.items():
        with pytest.raises(ValueError, match=f"{name}: expected finite numbers"):
            python({}, 0, **{name: value})
