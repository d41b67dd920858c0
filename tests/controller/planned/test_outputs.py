"""What the block gives: the torque of the law, the errors from the target, and the feed-forward."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from . import core, flat
from .block import AS_MEASURED, E1, SEARCHED, J, feed, lvlh, near_target, run, started, tumbling
from .truth import DAYS, orbit


@pytest.mark.parametrize("seed", range(12))
def test_under_the_law_the_lyapunov_function_falls_as_the_paper_says(seed):
    """dV/dt = -omega.L omega for a body that the demanded torque moves, by differences of V along the exact motion
    [11]."""
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
        torque = np.cross(y["dipole_ff"] @ flat.RODS, B) - y["wheel_torque_ff"] * E1
        rho = R.T @ r / np.linalg.norm(r)
        Pi = J @ Omega + y["h_w_ref"] * E1
        torque = torque + np.cross(Pi, Omega) + 3.0 * core.MU / np.linalg.norm(r) ** 3 * np.cross(rho, J @ rho)
        assert y["dOmega_d"] == pytest.approx(np.linalg.solve(J, torque), rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("period", [0.3, 0.35, 0.5])
def test_the_controls_of_a_sample_are_the_plans_in_the_middle_of_the_time_for_which_they_act(period):
    """Stages of 10 s are no multiple of 0.3 s nor of 0.35 s, so a sample has two: read at its start it would take the
    first for too long by 0.3 s, at its end the second too early by 0.35 s."""
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
                np.cross((y["dipole_ff"] * y["rod_gains_estimate"]) @ flat.RODS, u["b_B"]) - y["wheel_torque_ff"] * E1
            )
            assert y["tau_cmd_B"] + np.cross(u["omega_B"], u["h_w"] * E1) == pytest.approx(given, abs=2e-6)
