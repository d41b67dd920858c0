"""The planner's gains: feedback of the plan against a condensed least-squares problem, the filter's against Riccati's
equation."""

import numpy as np
import pytest
from scipy.linalg import block_diag, cho_factor, cho_solve, solve_discrete_are
from scipy.spatial.transform import Rotation

from tests.native.driver import Instance

from . import core
from .block import AS_MEASURED, feed, orbit
from .states import differences

# ------------------------------------------------------------------------------------------- the plan's feedback

WEIGHT_CONTROL = 0.005
FINAL, FINAL_WHEEL = 300.0, 30.0
"""As docs/how/planned-plan.md has them: of |u|^2, and s by which the cost at the end counts, the wheel's apart."""


def hessian(satellite, R_d, x):
    """Of the cost rate in the seven errors, by second differences of the cost."""

    def cost(d):
        y = core.Motion(x.R @ Rotation.from_rotvec(d[:3]).as_matrix(), x.Omega + d[3:6], x.h_w + d[6])
        return core.cost_rate(satellite, R_d, np.zeros(3), y)[0]

    steps = np.diag([1e-4] * 3 + [1e-6] * 3 + [1e-4])
    rows = [[cost(a + b) - cost(a - b) - cost(b - a) + cost(-a - b) for b in steps] for a in steps]
    return np.array(rows) / (4.0 * np.outer(np.diag(steps), np.diag(steps)))


@pytest.fixture(scope="module")
def hold():
    """A round body at rest at its target: no torque acts, so the motion without controls stays there."""
    satellite = core.Satellite(J=2.5 * np.eye(3), dipole_max=25.0 * 2.5 / 2.7533)  # T = 50 s
    R_d = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    r, v = orbit(0.0)
    ahead = core.Ahead(r, v, target=2, R_d0=R_d)
    x = core.Motion(R_d, np.zeros(3), 0.0)
    h, K, path = core.feedback(satellite, ahead, x)
    starts = np.concatenate([[0.0], np.cumsum(h)])
    stages = [
        differences(x, core.around(ahead, t + 0.5 * dt)[0], np.zeros(4), dt, satellite)
        for t, dt in zip(starts, h, strict=False)
    ]
    return satellite, R_d, x, h, K, path, stages


def test_the_motion_without_controls_stays_at_the_target(hold):
    _, R_d, _, h, K, path, _ = hold
    assert h.sum() == pytest.approx(1500.0)
    assert max(np.abs(y.R - R_d).max() for y in path) < 1e-9
    assert np.abs(K).max() > 1.0


@pytest.mark.parametrize("first", [0, 60, 89])
def test_the_feedback_is_the_slope_of_the_best_controls_of_the_rest_of_the_plan(hold, first):
    """All controls from a stage on at once, as one quadratic problem in them: its solution is linear in the errors
    there."""
    satellite, R_d, x, h, K, _, stages = hold
    L = hessian(satellite, R_d, x)
    end = np.diag([FINAL] * 6 + [FINAL_WHEEL])
    n = len(h) - first
    onward, forced, weights = np.eye(7), np.zeros((7, 4 * n)), [h[first] * L]
    rows_x, rows_u = [onward], [forced]
    for k, (A, G) in enumerate(stages[first:]):
        onward, forced = A @ onward, A @ forced
        forced[:, 4 * k : 4 * k + 4] += G
        rows_x.append(onward)
        rows_u.append(forced)
        weights.append(L @ end if k == n - 1 else h[first + k + 1] * L)
    X, U, W = np.vstack(rows_x), np.vstack(rows_u), block_diag(*weights)
    control = np.diag(np.repeat(2.0 * WEIGHT_CONTROL * h[first:], 4))
    best = -cho_solve(cho_factor(U.T @ W @ U + control), U.T @ W @ X)
    for found, expected in zip(K[first].T, best[:4].T, strict=True):
        assert found == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())


# ------------------------------------------------------------------------------------------- the filter's

DENSITY = 2.5e-4**2 / 50.0**3
"""Of the model's error at rest, rad2/s3: 2.5e-4/T in T = 50 s."""
DT = 0.5


def kalman(rate_noise, attitude_noise):
    """Steady gains (2, 2) of turn and rate by both measurements, from SciPy's discrete Riccati equation."""
    F = np.array([[1.0, DT], [0.0, 1.0]])
    Q = DENSITY * np.array([[DT**3 / 3.0, DT**2 / 2.0], [DT**2 / 2.0, DT]])
    R = np.diag([attitude_noise**2, rate_noise**2])
    unit = np.array([attitude_noise, rate_noise])  # the equation is solved in units of the noise
    A, q = F * unit / unit[:, None], Q / unit / unit[:, None]
    P = solve_discrete_are(A.T, np.eye(2), q, np.eye(2)) * unit * unit[:, None]
    return P @ np.linalg.inv(P + R)


@pytest.mark.parametrize("rate_noise", [1e-6, 1e-5])
@pytest.mark.parametrize("attitude_noise", [1e-5, 1e-4])
def test_rate_and_attitude_are_corrected_by_the_steady_gains_of_a_kalman_filter(rate_noise, attitude_noise):
    """At rest, with nothing to learn. The gains are read off the outputs: how far they follow a measurement that is
    moved after the sample."""
    r, v = orbit(0.0)
    values = {"r_N": r, "v_N": v, "h_w": 0.0, "u_applied": np.zeros(4), "omega_B": np.zeros(3), "R_NB": np.eye(3)}
    noise = {"rate_noise": rate_noise, "attitude_noise": attitude_noise}
    with Instance("controller_planned") as it:
        feed(it, {**AS_MEASURED, **noise, "reference": "inertial", **values})
        it.initialize()
        for i in range(600):
            it.step(i * DT, DT)
        it.set("omega_B", [rate_noise, 0.0, 0.0])
        by_rate = [it.get("attitude_error"), it.get("rate_error_B")[0]]
        it.set("omega_B", np.zeros(3))
        it.set("R_NB", Rotation.from_rotvec([attitude_noise, 0.0, 0.0]).as_matrix())
        by_turn = [it.get("attitude_error"), it.get("rate_error_B")[0]]
    gains = np.array([np.array(by_turn) / attitude_noise, np.array(by_rate) / rate_noise]).T
    expected = kalman(rate_noise, attitude_noise)
    assert gains == pytest.approx(expected, rel=0.02, abs=2e-4)
