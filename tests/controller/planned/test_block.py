"""The block as a host sees it: samples, memory, saved states, optional inputs, refusals, and the law's own equation."""

import contextlib
import math
from ctypes import byref, c_void_p
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fmus.interface import ABSENT_MIN, load
from tests.native.driver import Instance, Refused
from tests.native.test_shell import saved, serialized

from . import core
from .block import (
    AS_MEASURED,
    BLOCK,
    E1,
    KNOWN,
    SEARCHED,
    J,
    alike,
    at_target,
    feed,
    lvlh,
    near_target,
    run,
    same,
    started,
    tumbling,
)
from .truth import DAYS, orbit

# ------------------------------------------------------------------------------------------- samples


@pytest.mark.parametrize("inputs", [near_target, tumbling])
def test_samples_are_independent_of_the_communication_step(inputs):
    runs = {}
    for h in (0.1, 0.25, 0.5):
        with started(inputs, **KNOWN) as it:
            runs[h] = run(it, 0.0, 25.0, h, inputs)[round(0.5 / h) - 1 :: round(0.5 / h)]
    assert len({len(r) for r in runs.values()}) == 1
    for a, b, c in zip(*runs.values(), strict=True):
        assert alike(a, c, 1e-6)
        assert alike(b, c, 1e-6)


def test_samples_keep_their_grid_where_steps_do_not_divide_it():
    """Steps of 0.2 s: a sample is the first step at or beyond each half second."""
    with started() as it:
        times, before = [], it.outputs()
        for i in range(20):
            feed(it, near_target(0.2 * (i + 1)))
            it.step(0.2 * i, 0.2)
            now = it.outputs()
            times += [] if same(now, before) else [round(0.2 * (i + 1), 1)]
            before = now
    assert times == [0.6, 1.0, 1.6, 2.0, 2.6, 3.0, 3.6, 4.0]


def test_between_samples_all_outputs_are_held():
    with started() as it:
        after = run(it, 0.0, 3.0, 0.1)
        for i in range(0, 25, 5):  # 0.5 s is the fifth
            sample = after[i + 4]
            assert all(same(sample, held) for held in after[i + 5 : i + 9])
            assert not same(sample, after[i + 9])
        feed(it, {"omega_B": [0.1, 0.0, 0.0]})
        it.step(3.0, 0.1)
        held = it.outputs()
        feed(it, {"omega_B": [0.2, 0.0, 0.0]})
        assert same(it.outputs(), held)


def test_samples_stay_in_time_over_hundreds_of_thousands_of_steps():
    """Sums of a tenth drift by far more than what a sample may be early; the samples must not drift with them."""
    with started(control_period=0.5, plan_period=1000.0) as it:
        feed(it, near_target(0.0))
        late = 0
        for i in range(200_000):
            it.step(0.1 * i, 0.1)
            if i % 1000 == 3:  # the step before a sample, and the sample
                before = it.get("tau_cmd_B")
                feed(it, {"omega_B": [1e-4 * (i // 1000 % 7), -1e-3, 0.0]})
                late += not np.array_equal(it.get("tau_cmd_B"), before)
            if i % 1000 == 4:
                now = it.get("tau_cmd_B")
                late += np.array_equal(now, before)
    assert late == 0


def test_a_step_of_any_length_takes_bounded_time():
    with started() as it:
        feed(it, near_target(0.0))
        for t, h in ((0.0, 3.0), (3.0, 1e4), (10003.0, 0.5)):
            it.step(t, h)
            assert all(np.isfinite(v).all() for v in it.outputs().values())
    with started() as it, contextlib.suppress(Refused):  # to the end of time: refused or not, but at once
        it.step(0.0, 1e300)


# ------------------------------------------------------------------------------------------- memory


@pytest.mark.parametrize("inputs", [at_target, tumbling])
def test_get_after_set_evaluates_the_law_anew_and_leaves_no_trace(inputs):
    with started(inputs) as it, started(inputs) as twin:
        for i in range(40):
            for each in (it, twin):
                feed(each, inputs(0.5 * (i + 1)))
                each.step(0.5 * i, 0.5)
            first = it.outputs()
            feed(
                it,
                {"omega_B": [0.01, 0.02, -0.03], "R_NB": Rotation.from_rotvec([0.3, 1, 0.1]).as_matrix(), "h_w": 0.02},
            )
            other = it.outputs()
            assert not np.array_equal(other["tau_cmd_B"], first["tau_cmd_B"])
            assert not np.array_equal(other["attitude_error"], first["attitude_error"])
            feed(it, inputs(0.5 * (i + 1)))
            assert same(it.outputs(), first)
            assert same(twin.outputs(), first)


def test_a_state_saved_after_a_plan_goes_on_in_the_same_bits():
    with started() as it, started(tumbling) as other:
        run(it, 0.0, 45.0)
        state = saved(it)
        data = serialized(it, state)
        end = run(it, 45.0, 100.0)
        assert end[0]["phase"] == 2
        bytes_at_end = serialized(it, saved(it))
        it.call("SetFMUstate", state)
        assert all(map(same, run(it, 45.0, 100.0), end))
        run(other, 0.0, 7.0, inputs=tumbling)  # a life of its own before
        read = c_void_p()
        other.call("DeSerializeFMUstate", data, len(data), byref(read))
        other.call("SetFMUstate", read)
        assert all(map(same, run(other, 45.0, 100.0), end))
        assert serialized(other, saved(other)) == bytes_at_end


def test_a_states_bytes_depend_on_its_own_history_only():
    """Nothing of what the instance did before, and no memory that was never written, is in it."""

    def quick(t):
        """A light body that turns fast: its plans have more stages."""
        return {**near_target(t), "omega_B": [0.036, -0.022, 0.011]}

    with started() as fresh, started(quick, J_B=np.diag([0.4, 0.5, 0.55])) as again:
        assert run(again, 0.0, 12.0, inputs=quick)[-1]["phase"] == 2
        again.call("Reset")
        feed(again, near_target(0.0))
        again.initialize()
        assert serialized(fresh, saved(fresh)) == serialized(again, saved(again))
        for t in (0.0, 30.0):
            assert all(map(same, run(fresh, t, t + 30.0), run(again, t, t + 30.0)))
            assert serialized(fresh, saved(fresh)) == serialized(again, saved(again))


def test_instances_side_by_side_do_as_each_alone():
    with started() as a:
        alone_a = run(a, 0.0, 12.0)
    with started(tumbling) as b:
        alone_b = run(b, 0.0, 12.0, inputs=tumbling)
    with started() as a, started(tumbling) as b:
        for i in range(24):
            (now_a,) = run(a, 0.5 * i, 0.5 * (i + 1))
            (now_b,) = run(b, 0.5 * i, 0.5 * (i + 1), inputs=tumbling)
            assert same(now_a, alone_a[i])
            assert same(now_b, alone_b[i])


# ------------------------------------------------------------------------------------------- optional inputs


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
    """The rods' commands of the steering follow the field: with the sign of the difference wrong they would turn away."""
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


# ------------------------------------------------------------------------------------------- refusals


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


# ------------------------------------------------------------------------------------------- the law


@pytest.mark.parametrize("seed", range(12))
def test_under_the_law_the_lyapunov_function_falls_as_the_paper_says(seed):
    """dV/dt = -omega.L omega for a body that the demanded torque moves, by differences of V along the exact motion [11]."""
    rng = np.random.default_rng(seed)
    full = np.array([[2.13, 0.11, -0.07], [0.11, 3.04, 0.19], [-0.07, 0.19, 3.09]])
    L = np.diag([0.05, 0.06, 0.07]) + 0.01
    with started(J_B=full, L0=L, K0=[4e-4, 5e-4, 7e-4], **AS_MEASURED) as it:
        y = run(it, 0.0, SEARCHED)[-1]
        assert y["phase"] == 2
        R = y["R_d"] @ Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
        Omega = rng.normal(size=3) * 0.02
        r, _ = orbit(SEARCHED)
        feed(it, {"R_NB": R, "omega_B": Omega})  # the plan stays as it was
        y = it.outputs()
        rho = R.T @ r / np.linalg.norm(r)
        gravity = 3.0 * core.MU / np.linalg.norm(r) ** 3 * np.cross(rho, full @ rho)
        dOmega = np.linalg.solve(full, np.cross(full @ Omega, Omega) + y["tau_cmd_B"] + gravity + y["disturbance_B"])

        def V(dt):
            """Of body and plan moved on by dt: the plan's rate is Omega_d + dOmega_d dt."""
            A = R @ Rotation.from_rotvec(dt * (Omega + 0.5 * dt * dOmega)).as_matrix()
            D = y["R_d"] @ Rotation.from_rotvec(dt * (y["Omega_d"] + 0.5 * dt * y["dOmega_d"])).as_matrix()
            Q = D.T @ A
            w = Omega + dt * dOmega - Q.T @ (y["Omega_d"] + dt * y["dOmega_d"])
            return 0.5 * w @ full @ w + np.trace(np.diag([4e-4, 5e-4, 7e-4]) @ (np.eye(3) - Q)), w

        value, omega = V(0.0)
        assert y["lyapunov"] == pytest.approx(value, rel=1e-9)
        slope = (V(1e-3)[0] - V(-1e-3)[0]) / 2e-3
        assert slope == pytest.approx(-omega @ L @ omega, rel=1e-5)


def test_the_errors_are_those_from_the_target_not_from_the_plan():
    with started() as it:
        for y in run(it, 0.0, 10.0)[::5]:
            assert y["gain_k"] == y["gain_l"] == 1.0
        t, u = 10.0, near_target(10.0)
        Q = lvlh(t).T @ u["R_NB"]
        assert y["attitude_error"] == pytest.approx(Rotation.from_matrix(Q).magnitude(), abs=0.02)
    with started(R_d0=lvlh(0.0), reference="inertial") as it:
        y = it.outputs()
        assert y["attitude_error"] == pytest.approx(
            Rotation.from_matrix(lvlh(0.0).T @ near_target(0.0)["R_NB"]).magnitude(), rel=1e-9
        )
        assert y["rate_error_B"] == pytest.approx(near_target(0.0)["omega_B"])


def test_the_feed_forward_is_the_plan_and_the_plan_moves_as_the_controller_believes():
    """dOmega_d is the right-hand side of the motion under the dipoles and the wheel torque that go with it."""
    with started(**AS_MEASURED) as it:
        y = run(it, 0.0, SEARCHED)[-1]
        r, _ = orbit(SEARCHED)
        R, Omega = y["R_d"], y["Omega_d"]
        B = R.T @ core.field_at("igrf14", DAYS, 10, r, SEARCHED)
        torque = np.cross(y["dipole_ff"] @ core.RODS, B) - y["wheel_torque_ff"] * E1
        rho = R.T @ r / np.linalg.norm(r)
        Pi = J @ Omega + y["h_w_ref"] * E1
        torque = torque + np.cross(Pi, Omega) + 3.0 * core.MU / np.linalg.norm(r) ** 3 * np.cross(rho, J @ rho)
        assert y["dOmega_d"] == pytest.approx(np.linalg.solve(J, torque), rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("period", [0.3, 0.35, 0.5])
def test_the_controls_of_a_sample_are_the_plans_in_the_middle_of_the_time_for_which_they_act(period):
    """Stages of 10 s are no multiple of 0.3 s nor of 0.35 s, so a sample has two: read at its start it would take the first
    for too long by 0.3 s, at its end the second too early by 0.35 s."""
    plan, cost = [], []
    with started(control_period=period, plan_period=1000.0) as it:
        for i in range(round(60.0 / period)):
            plan.append(it.get("dipole_ff"))
            cost.append(it.get("plan_cost"))
            feed(it, near_target((i + 1) * period))
            it.step(i * period, period)
            assert it.get("phase") in {2, 3}
    first = max(i for i in range(1, len(cost)) if cost[i] != cost[i - 1])  # sample of the plan that follows the search
    assert 0 < first * period < 15.0
    changes = [i - first for i, (a, b) in enumerate(pairwise(plan), 1) if i > first and not np.array_equal(a, b)]
    assert changes[:4] == [math.ceil(round(end / period - 0.5, 9)) for end in (10.0, 20.0, 30.0, 40.0)]


def test_while_steering_the_torque_is_that_of_the_feed_forward():
    with started(tumbling) as it:
        for y, t in zip(run(it, 0.0, 20.0, inputs=tumbling), 0.5 * np.arange(1, 41), strict=True):
            u = tumbling(t)
            assert y["phase"] == 1
            assert y["plan_cost"] == 0.0
            assert 20.0 < np.abs(y["dipole_ff"]).max() <= 25.0 * (1.0 + 1e-12)
            given = (
                np.cross((y["dipole_ff"] * y["rod_gains_estimate"]) @ core.RODS, u["b_B"]) - y["wheel_torque_ff"] * E1
            )
            assert y["tau_cmd_B"] + np.cross(u["omega_B"], u["h_w"] * E1) == pytest.approx(given, abs=2e-6)
