"""What the block refuses, by which message, and when."""

import math

import numpy as np
import pytest

from tests.native.driver import Instance, Refused

from . import core
from .block import BLOCK, at_target, feed, near_target, run, same, started


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"R_NB": np.diag([1.0, 1.0, 1.001])}, r"R_NB: expected a rotation matrix.*found 0.00200"),
        (
            {"R_NB": np.diag([1.0, 1.0, -1.0])},
            r"R_NB: expected a rotation matrix, determinant \+1 \(this is a reflection\)",
        ),
        ({"r_N": [9e5, 0.0, 0.0]}, r"r_N: expected at least 1000 km from the Earth's centre, found 900000"),
        ({"v_N": [100.0, 0.0, 0.0]}, r"v_N: expected a velocity that spans the orbit's plane with r_N.*found 0"),
        ({"v_N": [0.0, 0.0, 0.0]}, r"v_N: expected a velocity that spans the orbit's plane with r_N.*found 0"),
        ({"v_N": [0.0, 0.0, 11e3]}, r"v_N: expected the velocity of a closed orbit, below that of escape, found 11000"),
    ],
)
def test_inputs_from_which_nothing_follows_are_refused_by_name(inputs, message):
    with started() as it:
        before = it.outputs()
        good = {name: it.get(name) for name in inputs}
        feed(it, inputs)
        with pytest.raises(Refused, match=f"fmi2DoStep: {message}"):
            it.step(0.0, 0.5)
        feed(it, good)
        assert same(it.outputs(), before)
        it.step(0.0, 0.5)


@pytest.mark.parametrize("name", ["R_NB", "omega_B", "r_N", "v_N", "h_w", "b_B", "u_applied"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_is_refused_where_it_comes_in(name, value):
    with started() as it:
        before = it.get(name)
        wrong = np.array(before, float)
        wrong[(-1,) * wrong.ndim] = value
        with pytest.raises(Refused, match=rf"{name}.*expected a finite number"):
            it.set(name, wrong if wrong.ndim else float(wrong))
        assert np.array_equal(it.get(name), before)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"epoch": "2039-01-01T00:00:00Z"}, r"epoch: expected a date that igrf14 covers, 2000.0 to 2030.0, found 2039"),
        (
            {"epoch": "1999-06-01T00:00:00Z"},
            r"epoch: expected a date that igrf14 covers, 2000.0 to 2030.0, found 1999.4",
        ),
        ({"field_model": "wmm2020"}, r"epoch: expected a date that wmm2020 covers, 2020.0 to 2025.0, found 2009.6"),
        ({"epoch": "2009-02-30T00:00:00Z"}, r"epoch: expected UTC in ISO 8601, such as.*found '2009-02-30T00:00:00Z'"),
        ({"epoch": "yesterday %s"}, r"epoch: expected UTC in ISO 8601, such as.*found 'yesterday %%s'"),
        ({"J_B": np.diag([1.0, 1.0, 2.5])}, r"J_B: expected the inertia of a body"),
        ({"J_B": [[2, 0.1, 0], [0, 2, 0], [0, 0, 2]]}, r"J_B: expected a symmetric matrix"),
        ({"K0": [1e-3, 1e-3, 2e-3]}, r"K0\[2\]: expected 0 < K0\[1\] < K0\[2\] < K0\[3\], finite, found 0.001"),
        ({"L0": np.diag([0.1, -0.1, 0.1])}, r"L0: expected a positive definite matrix"),
        ({"rod_axes": np.eye(3) * 0.99}, r"rod_axes: expected rows of unit length, to 1e-06, found 0.99"),
        ({"rod_axes": [[1, 0, 0], [0, 1, 0], [0.6, 0.8, 0]]}, r"rod_axes: expected linearly independent axes"),
        ({"rod_gains0": np.zeros(3)}, r"rod_gains0: expected at least one rod that is not dead, found 0"),
        ({"R_d0": np.diag([1.0, 1.0, 0.9])}, r"R_d0: expected a rotation matrix"),
    ],
)
def test_parameters_that_do_not_fit_are_refused_by_name(changes, message):
    with Instance(BLOCK) as it:
        feed(it, changes)
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        with pytest.raises(Refused, match=f"fmi2ExitInitializationMode: {message}"):
            it.call("ExitInitializationMode")


def test_a_measurement_that_is_wildly_wrong_for_once_is_forgotten():
    """A rate of a million rad/s in one sample: the estimates stay, and the law is again that of the measurements."""
    with started(at_target) as hit, started(at_target) as twin:
        for i in range(80):
            for it in (hit, twin):
                values = at_target(0.5 * (i + 1))
                if it is hit and i == 30:
                    values["omega_B"] = [1e6, 0.0, 0.0]
                feed(it, values)
                it.step(0.5 * i, 0.5)
        a, b = hit.outputs(), twin.outputs()
        assert a["phase"] == b["phase"]
        assert a["attitude_error"] == pytest.approx(b["attitude_error"], abs=0.01)
        assert a["rate_error_B"] == pytest.approx(b["rate_error_B"], abs=2e-3)
        assert np.abs(a["J_estimate_B"] - b["J_estimate_B"]).max() < 0.05
        assert np.abs(a["tau_cmd_B"]).max() < 1e-2


@pytest.mark.parametrize(("rate", "heavier"), [(1e3, 1.0), (1e80, 1.0), (1e160, 1.0), (1e300, 1.0), (5e153, 1e6)])
def test_the_flight_code_recovers_from_a_rate_beyond_all_bounds(rate, heavier):
    """No FMI shell is between, which would refuse the sample: what is not finite must not stay in the state."""
    inputs = {**at_target(0.0), "omega_B": np.zeros(3)}  # the same in all samples
    right, found = (core.after_glitch(r, 30, heavier, **inputs) for r in (inputs["omega_B"][0], rate))
    assert all(np.isfinite(value).all() for value in found.values())
    assert found["attitude_error"] == pytest.approx(right["attitude_error"], abs=0.02)
    assert found["rate_error_B"] == pytest.approx(right["rate_error_B"], abs=2e-3)
    assert np.abs(found["J_estimate_B"] - right["J_estimate_B"]).max() < 0.1 * heavier


@pytest.mark.parametrize("gains", [{"K0": [30.0, 40.0, 50.0]}, {"L0": 1e-4 * np.eye(3)}])
def test_gains_too_stiff_for_the_period_are_refused_in_initialization_and_with_the_first_attitude(gains):
    (name,) = gains
    told = rf"{name}: expected .*control_period/L0 below 2"
    with pytest.raises(Refused, match=told), started(near_target, **gains):
        pass

    def late(t):
        return {**near_target(t), "R_NB": np.zeros((3, 3))} if t < 0.7 else near_target(t)

    with started(late, **gains) as it:
        run(it, 0.0, 0.5, inputs=late)
        with pytest.raises(Refused, match=told):
            run(it, 0.5, 1.0, inputs=late)
