"""The block without inputs that it can do without."""

import numpy as np
import pytest

from fmus.interface import ABSENT_MIN, load
from tests.native.driver import Instance

from .block import AS_MEASURED, BLOCK, feed, near_target, run, same, started


def without(*names):
    sizes = {"h_w": 1, "b_B": 3, "u_applied": 4}

    def inputs(t):
        absent = {name: np.full(sizes[name], 1e9) if sizes[name] > 1 else 1e9 for name in names}
        return {**near_target(t), **absent}

    return inputs


@pytest.mark.parametrize("names", [("h_w",), ("b_B",), ("u_applied",), ("h_w", "b_B", "u_applied")])
def test_without_its_optional_inputs_it_goes_on(names):
    with started(without(*names)) as it:
        for y in run(it, 0.0, 40.0, inputs=without(*names)):
            assert all(np.isfinite(v).all() for v in y.values())
            assert np.abs(y["dipole_ff"]).max() <= 25.0 * (1 + 1e-12)
            assert abs(y["wheel_torque_ff"]) <= 3e-3 * (1 + 1e-12)


def test_one_absent_element_makes_the_input_absent():
    def partly(t):
        return {**near_target(t), "b_B": [2e-5, 1e9, 3e-5], "u_applied": [1e9, 0.0, 0.0, 0.0]}

    absent = without("b_B", "u_applied")
    with started(partly) as a, started(absent) as b:
        assert all(map(same, run(a, 0.0, 15.0, inputs=partly), run(b, 0.0, 15.0, inputs=absent)))


@pytest.mark.parametrize(("share", "connected"), [(1.0 - 1e-15, True), (1.0, False), (1.0 + 1e-15, False)])
def test_the_wheel_momentum_is_connected_below_the_threshold_only(share, connected):
    with started() as it:
        it.set("h_w", -share * ABSENT_MIN)
        it.step(0.0, 0.5)
        assert (it.get("h_w_estimate") == -share * ABSENT_MIN) == connected


def test_a_field_of_exactly_zero_is_no_field():
    def zero(t):
        return {**near_target(t), "b_B": [0.0, 0.0, 0.0]}

    with started(zero) as a, started(without("b_B")) as b:
        assert all(map(same, run(a, 0.0, 15.0, inputs=zero), run(b, 0.0, 15.0, inputs=without("b_B"))))


def test_without_h_w_the_wheel_is_reckoned_from_what_was_given():
    def inputs(t):
        return {**near_target(t), "h_w": 1e9, "u_applied": [0.0, 0.0, 0.0, 2e-4 if t < 20.0 else -1e-3]}

    with started(inputs) as it:
        found = [float(y["h_w_estimate"]) for y in run(it, 0.0, 60.0, inputs=inputs)]
    t = 0.5 * np.arange(1, 121)
    torque = np.where(t < 20.0, 2e-4, -1e-3)
    assert found == pytest.approx(np.maximum(np.cumsum(0.5 * torque), -0.03), abs=1e-12)


def test_without_a_measured_field_the_controller_goes_on_with_the_difference_that_it_has_seen():
    """The rods' commands of the steering follow the field: with the sign of the difference wrong they would turn
    away."""
    starts = {v.name: v.start for v in load(BLOCK).of("input")}
    with Instance(BLOCK) as it:
        it.set("omega_B", [0.06, -0.05, 0.08])
        it.initialize()
        own = it.get("dipole_ff")  # by the onboard field alone
        assert it.get("phase") == 1
        it.call("Reset")
        it.set("omega_B", [0.06, -0.05, 0.08])
        it.set("b_B", [1.5e-5, -2.5e-5, 1e-5])
        it.initialize()
        measured = it.get("dipole_ff")
        it.set("b_B", starts["b_B"])
        remembered = it.get("dipole_ff")
    assert np.linalg.norm(measured - own) > 1.0
    assert np.linalg.norm(remembered - measured) < 0.5 * np.linalg.norm(remembered - own)


def test_the_difference_of_the_field_is_followed_over_a_minute_and_taken_whole_after_a_longer_step():
    first, second = np.array([3e-6, -4e-6, 5e-6]), np.array([-6e-6, 2e-6, 1e-6])

    def measured(t, bias):
        inputs = near_target(t)
        return {**inputs, "b_B": inputs["b_B"] + inputs["R_NB"].T @ bias}

    def seen(it, t):
        it.set("b_B", [1e9, 1e9, 1e9])
        inputs = near_target(t)
        return inputs["R_NB"] @ (it.get("b_used_B") - inputs["b_B"])

    for h, share in ((0.5, 0.5 / 60.0), (30.0, 0.5), (150.0, 1.0)):
        with started(lambda t: measured(t, first), **AS_MEASURED, find_failures=False) as it:
            assert seen(it, 0.0) == pytest.approx(first, abs=1e-12)
            feed(it, measured(h, second))
            it.step(0.0, h)
            assert seen(it, h) == pytest.approx(first + share * (second - first), abs=1e-9)
