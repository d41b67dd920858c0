"""The law for many cases at once against the controller's own functions, and what it does with exact torque."""

from dataclasses import replace

import numpy as np
import pytest

import controller
from design import exact
from design.loop import read
from evidence.paper import SCENARIOS
from evidence.reproduction import convergence
from evidence.reproduction.convergence import ORBITAL_RATE

LAW = read(SCENARIOS["V.B"]).loop.controller
FULL = np.array([[2.9, 0.21, -0.34], [0.21, 3.6, 0.17], [-0.34, 0.17, 4.1]])


@pytest.mark.parametrize("schedule", ["error", "constant"])
def test_the_law_for_many_cases_is_the_controllers_own(schedule):
    p = replace(LAW, J_B=FULL, L0=0.3 * FULL, gain_schedule=schedule)
    rng = np.random.default_rng(6)
    orbit = read(SCENARIOS["V.B"]).loop.plant.orbit
    r, v = orbit.position_velocity(0.0)
    R_d = controller.reference.lvlh(r, v).R_d
    law = exact.Law(p, ORBITAL_RATE)
    states = [convergence.start(rng, 20) for _ in range(2)]
    demands = [law(*state) for state in states]
    for i in range(20):
        inputs = [controller.Inputs(R_d @ Q[i], Omega[i], r, v) for Q, Omega in states]
        x = controller.start(p, inputs[0])  # the second state's gains are latched at the first
        for d, u in zip(demands, inputs, strict=True):
            y = controller.outputs(x, u, p)
            np.testing.assert_allclose(d.tau[i], y.tau_cmd_B, rtol=1e-9, atol=1e-12)
            assert (d.V[i], d.zeta[i]) == pytest.approx((y.lyapunov, y.attitude_error), rel=1e-9)
            assert d.rate[i] == pytest.approx(np.linalg.norm(y.rate_error_B), rel=1e-9)


def test_a_bend_that_the_law_for_many_cases_does_not_have_is_refused():
    with pytest.raises(ValueError, match="phi: expected 'linear', found 'logarithm'"):
        exact.Law(replace(LAW, phi="logarithm"), ORBITAL_RATE)


def test_with_constant_gains_v_never_rises_and_falls_as_the_paper_says():
    flown = convergence.random_cases(LAW, "constant", n=40, duration=20.0)
    assert not flown.steps_up.any()
    assert flown.rate_error < 1e-7


def test_a_start_near_the_goal_settles_and_one_on_an_unstable_equilibrium_stays_there():
    half_turn = np.diag([1.0, -1.0, -1.0])
    near = controller.so3.exp(np.array([0.2, -0.1, 0.3]))
    Q = np.array([near, half_turn])
    flown = exact.fly(LAW, LAW.J_B, Q, -ORBITAL_RATE * Q[:, 1], 200.0, 0.5, ORBITAL_RATE)
    assert 20.0 < flown.converged[0] < 200.0
    assert np.isnan(flown.converged[1])
    assert flown.largest_torque[1] < 1e-9 * flown.largest_torque[0]
