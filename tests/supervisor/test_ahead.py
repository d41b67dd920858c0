"""The reference to come: what the supervisor gives later, on an orbit that SciPy integrates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import supervisor
from supervisor.ahead import PERIOD, two_body
from supervisor.ports import AHEAD, NADIR, SAFE, SLEW, SUN, TARGET
from tests.supervisor.test_modes import Flight

MU = 3.986004418e14
R, V = np.array([6971e3, 0.0, 0.0]), np.array([0.0, -1052.3891, 7488.1109])


def integrated(r: Any, v: Any, dt: float) -> Any:
    """Position and velocity after dt."""

    def motion(_: float, y: Any) -> Any:
        return np.concatenate((y[3:], -MU / np.linalg.norm(y[:3]) ** 3 * y[:3]))

    return solve_ivp(motion, (0.0, dt), np.concatenate((r, v)), rtol=1e-12, atol=1e-6, method="DOP853").y[:, -1]


@pytest.mark.parametrize("v", [V, 1.2 * V, [900.0, 2000.0, 6500.0], np.sqrt(MU / 6971e3) * np.array([0.0, 0.6, 0.8])])
@pytest.mark.parametrize("dt", [30.0, 1500.0, 5000.0])
def test_the_orbit_is_that_of_an_integrator(v: Any, dt: float) -> None:
    expected = integrated(R, np.asarray(v), dt)
    r, velocity = two_body(R, np.asarray(v, float), MU, dt)
    np.testing.assert_allclose(r, expected[:3], atol=0.1)
    np.testing.assert_allclose(velocity, expected[3:], atol=1e-4)


@pytest.mark.parametrize("command", [NADIR, TARGET, SUN])
def test_what_it_says_of_the_reference_to_come_is_the_reference_that_comes(command: int) -> None:
    """During a slew and behind it."""
    quick = {"slew_torque_max": 1e-3, "slew_rate_max": 0.05}
    flight = Flight(**quick, ahead_horizon=1500.0).pointing(0 if command != NADIR else SUN)
    moved = replace(flight.u, command=command)
    x, y = supervisor.step(flight.x, moved, flight.p, 1.0)
    assert x.mode == SLEW
    assert flight.p.ahead_horizon > x.slew_duration
    times = y.t_ahead
    assert times[-1] == pytest.approx(flight.p.ahead_horizon)
    assert (np.diff(times, prepend=0.0) > 0.0).all()
    for k in (0, 7, AHEAD - 1):
        s = float(times[k])
        state = integrated(R, V, s)
        there = replace(x, t=x.t + s, mode=SLEW if s < x.slew_duration else x.destination)
        expected = supervisor.modes.reference_now(there, replace(moved, r_N=state[:3], v_N=state[3:]), flight.p)
        away = Rotation.from_matrix(expected.R_ref.T @ Rotation.from_rotvec(y.turn_ahead[k]).as_matrix()).magnitude()
        assert away < 1e-6
        np.testing.assert_allclose(y.Omega_ahead[k], expected.Omega_ref, atol=1e-9)


def test_it_is_given_anew_after_a_period_and_with_each_mode_and_not_in_safe_mode() -> None:
    flight = Flight(ahead_horizon=1500.0)
    assert flight.y.mode == SAFE
    assert not flight.y.t_ahead.any()
    flight.pointing()
    first = flight.x.t_ahead
    gone = 0
    while flight.x.t_ahead is first or np.array_equal(flight.x.t_ahead, first):
        before = flight.y.t_ahead
        flight.fly()
        gone += 1
        if np.array_equal(flight.x.t_ahead, first):
            np.testing.assert_allclose(flight.y.t_ahead, before - 1.0, atol=1e-9)
    assert gone <= PERIOD
    flight.fly(command=TARGET)
    assert flight.y.mode == SLEW
    assert flight.y.t_ahead[-1] == pytest.approx(flight.p.ahead_horizon)


def test_on_no_ellipse_and_without_a_horizon_it_is_not_given() -> None:
    fast = Flight(ahead_horizon=1500.0).pointing()
    fast.fly(v_N=np.array([0.0, 0.0, 12e3]), command=TARGET)
    assert not fast.y.t_ahead.any()
    assert not Flight().pointing().y.t_ahead.any()
