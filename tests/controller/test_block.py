import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import controller
from tests.blocks import inputs, parameters

R = Rotation.from_rotvec([0.6, -0.9, 1.3]).as_matrix()
MOVING = inputs("controller", R_NB=R, omega_B=[0.04, -0.0789, 0.0311])


def test_start_values_give_finite_outputs_for_every_choice():
    u = inputs("controller")
    for reference in ("lvlh", "inertial", "rate"):
        p = parameters("controller", reference=reference)
        controller.check(p)
        y = controller.outputs(controller.start(p, u), u, p)
        assert np.isfinite([*y.tau_cmd_B, y.attitude_error, *y.rate_error_B, y.lyapunov, y.gain_k, y.gain_l]).all()


def test_the_scheduled_gains_keep_the_errors_of_the_start():
    p = parameters("controller")
    x = controller.start(p, MOVING)
    first = controller.outputs(x, MOVING, p)
    angle, rate = first.attitude_error, np.linalg.norm(first.rate_error_B)
    assert first.gain_k == pytest.approx(0.098 * (3.5 + angle) / (35.0 + angle), rel=1e-14)
    assert first.gain_l == pytest.approx(1.47 * (2.1 + rate) / (21.0 + rate), rel=1e-14)
    later = replace(
        MOVING, R_NB=Rotation.from_rotvec([0.1, 0.2, -0.3]).as_matrix(), omega_B=np.array([0.01, 0.02, -0.005])
    )
    x, y = controller.step(x, later, p, 0.1)
    assert abs(y.attitude_error - angle) > 0.1
    assert y.gain_k == pytest.approx(0.098 * (3.5 + y.attitude_error) / (35.0 + angle), rel=1e-14)
    assert y.gain_l == pytest.approx(1.47 * (2.1 + np.linalg.norm(y.rate_error_B)) / (21.0 + rate), rel=1e-14)
    x, again = controller.step(x, MOVING, p, 0.1)
    assert again.gain_k == first.gain_k
    assert again.gain_l == first.gain_l


def test_scheduled_gains_scale_both_matrices_of_the_law():
    """The law with gains k, l is the constant law whose kappa0, lambda0 are k, l."""
    scheduled = parameters("controller", phi="logarithm", phi_scale=0.01)
    x = controller.State(4.2, 1.1, 0.07)
    y = controller.outputs(x, MOVING, scheduled)
    constant = replace(scheduled, gain_schedule="constant", kappa0=y.gain_k, lambda0=y.gain_l)
    same = controller.outputs(x, MOVING, constant)
    np.testing.assert_allclose(y.tau_cmd_B, same.tau_cmd_B, rtol=1e-14)
    assert y.lyapunov == pytest.approx(same.lyapunov, rel=1e-14)


def test_outputs_between_steps_commit_nothing():
    p = parameters("controller", reference="rate", Omega_d0=[0.1, -0.2, 0.3])
    x, y = controller.step(controller.start(p, MOVING), MOVING, p, 0.1)
    other = inputs("controller", omega_B=[0.3, 0.1, 0.2])
    assert not np.array_equal(controller.outputs(x, other, p).tau_cmd_B, y.tau_cmd_B)
    np.testing.assert_array_equal(controller.outputs(x, MOVING, p).tau_cmd_B, y.tau_cmd_B)


def test_a_body_that_follows_the_turning_reference_has_no_error():
    """R_d0 typed from four decimals is projected; the outputs of a step are those at its end."""
    start = Rotation.from_rotvec([0.4, -1.1, 0.7])
    rate = np.array([0.3, -0.2, 0.45])
    p = parameters("controller", reference="rate", R_d0=start.as_matrix().round(4), Omega_d0=rate)
    controller.check(p)
    x = controller.start(p, MOVING)
    for i in range(1, 18):
        followed = Rotation.from_matrix(p.desired_attitude_0) * Rotation.from_rotvec(0.1 * i * rate)
        x, y = controller.step(x, replace(MOVING, R_NB=followed.as_matrix(), omega_B=rate), p, 0.1)
        assert y.attitude_error < 1e-14
        np.testing.assert_allclose(y.rate_error_B, 0.0, atol=1e-15)
        assert y.lyapunov < 1e-15
    assert x.t == pytest.approx(1.7)
    assert (start.inv() * Rotation.from_matrix(p.desired_attitude_0)).magnitude() < 1e-4


def test_a_body_at_the_projected_attitude_has_no_inertial_error():
    p = parameters("controller", reference="inertial", R_d0=R.round(4), compensate_gravity=False)
    u = replace(MOVING, R_NB=p.desired_attitude_0, omega_B=np.zeros(3))
    y = controller.outputs(controller.start(p, u), u, p)
    assert np.abs(R.round(4) - p.desired_attitude_0).max() > 1e-6
    assert y.lyapunov < 1e-15
    np.testing.assert_allclose(y.tau_cmd_B, 0.0, atol=1e-15)


def test_a_single_precision_plant_is_accepted():
    p = parameters("controller")
    u = replace(MOVING, R_NB=R.astype(np.float32).astype(np.float64))
    exact = controller.outputs(controller.start(p, MOVING), MOVING, p)
    single = controller.outputs(controller.start(p, u), u, p)
    np.testing.assert_allclose(single.tau_cmd_B, exact.tau_cmd_B, rtol=1e-4)


def test_an_attitude_that_is_no_rotation_is_refused_with_its_deviation():
    p = parameters("controller")
    with pytest.raises(ValueError, match=r"R_NB: expected a rotation matrix.*at most 0\.0001, found 0\.0201"):
        controller.outputs(controller.State(0.0, 1.0, 1.0), replace(MOVING, R_NB=1.01 * R), p)


def test_the_position_matters_only_where_it_is_used():
    at_centre = replace(MOVING, r_N=np.zeros(3))
    free = parameters("controller", reference="inertial", compensate_gravity=False)
    controller.outputs(controller.start(free, at_centre), at_centre, free)
    for changes in ({"reference": "lvlh", "compensate_gravity": False}, {"reference": "inertial"}):
        p = parameters("controller", **changes)
        with pytest.raises(ValueError, match="r_N"):
            controller.outputs(controller.State(0.0, 1.0, 1.0), at_centre, p)


EYE = np.eye(3)
WRONG = [
    ({"K0": [0.3, 0.2, 0.4]}, r"K0: expected 0 < K0\[1\] < K0\[2\] < K0\[3\], found \[0.3, 0.2, 0.4\]"),
    ({"K0": [0.2, 0.2, 0.4]}, "K0: expected"),
    ({"K0": [0.1, 0.4, 0.4]}, "K0: expected"),
    ({"K0": [0.0, 0.2, 0.4]}, "K0: expected"),
    ({"K0": [0.1, math.nan, 0.4]}, "K0: expected finite"),
    ({"L0": EYE + np.eye(3, k=1)}, "L0: expected a symmetric matrix"),
    ({"L0": np.diag([1.0, 2.0, -1e-3])}, "L0: expected a positive definite matrix, found its least eigenvalue -0.001"),
    ({"L0": np.diag([1.0, 2.0, 0.0])}, "L0: expected a positive definite"),
    ({"J_B": EYE + 1e-3 * np.eye(3, k=2)}, "J_B: expected a symmetric matrix"),
    ({"J_B": EYE - 2.0}, "J_B: expected a positive definite"),
    ({"J_B": np.diag([1.0, 2.0, 3.1])}, "J_B: expected the inertia of a body.*1, 2, 3.1"),
    ({"J_B": np.full((3, 3), math.inf)}, "J_B: expected finite"),
    ({"R_d0": 1.01 * EYE}, "R_d0: expected a rotation matrix"),
    ({"R_d0": np.diag([1.0, 1.0, -1.0])}, "R_d0: .*reflection"),
    ({"Omega_d0": [0.0, math.nan, 0.0]}, "Omega_d0: expected finite"),
    ({"phi": "cubic"}, "phi: expected one of linear, logarithm, square_root, found 'cubic'"),
    ({"gain_schedule": "none"}, "gain_schedule: expected one of error, constant"),
    ({"reference": "sun"}, "reference: expected one of lvlh, inertial, rate"),
    *(
        ({name: bad}, f"{name}: expected a finite number above 0, found")
        for name in ("phi_scale", "gravitational_parameter", "kappa0", "lambda0", "a1", "a2", "c1", "c2")
        for bad in (0.0, -1.0, math.inf, math.nan)
    ),
]


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name_and_value(changes, message):
    with pytest.raises(ValueError, match=message):
        controller.check(parameters("controller", **changes))


def test_right_parameters_pass():
    controller.check(parameters("controller"))
    turned = R @ np.diag([1.0, 2.0, 3.0]) @ R.T  # a plate: the triangle inequality's limit
    controller.check(parameters("controller", J_B=(turned + turned.T) / 2))
