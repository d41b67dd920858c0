"""Sensors that fail behind a tumbling or held satellite, against the truth; both flavours fly each failure.

Shows ES-4.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import estimator
from estimator import onboard
from estimator.filter import propagated
from estimator.health import BLANK, FROZEN, GOOD, INCONSISTENT, JUMPED, SUN, noticed
from estimator.health import RATE as GYRO
from estimator.isolation import restarted
from estimator.measurements import started
from estimator.state import Measured, blank
from plant.orbit import from_position_velocity
from tests.blocks import inputs, parameters
from tests.native.agreement import assert_same
from tests.native.driver import Instance

MU = 3.986004418e14
R_N, V_N = np.array((6971000.0, 0.0, 0.0)), np.array((0.0, -1052.3891, 7488.1109))
LIT = "2009-02-10T00:00:00Z"
"""At this date the Sun is seen from R_N, and for ten minutes more."""
STEP, AT, END = 0.5, 100, 400
"""s; the step at which a sensor fails, and that of the end."""
RATE = np.array((2e-3, -1e-3, 1.5e-3))
"""rad/s, of the body, constant."""
BIAS = np.array((1e-5, -2e-5, 1e-5))
SIGMA = {"rate": 6e-5, "field": 1e-7, "sun": 0.01, "tracker": 5e-5}


def sensors() -> Any:
    return parameters(
        "estimator",
        epoch=LIT,
        angle_random_walk=4.4e-5,
        rate_random_walk=1e-8,
        rate_bias_sigma=1e-4,
        field_noise=3e-7,
        field_bias_sigma=1e-7,
        sun_noise=0.02,
    )


@cache
def measured(tracker: bool) -> list[Any]:
    """What sound sensors measure over the flight, of a body that turns at RATE."""
    p, rng, flown = sensors(), np.random.default_rng(5), []
    orbit = from_position_velocity(R_N, V_N, MU)
    R0 = Rotation.random(random_state=3)
    for k in range(END):
        t = k * STEP
        r, v = orbit.position_velocity(t)
        R = (R0 * Rotation.from_rotvec(RATE * t)).as_matrix()
        noise = {name: sigma * rng.normal(size=3) for name, sigma in SIGMA.items()}
        seen = R @ Rotation.from_rotvec(noise["tracker"]).as_matrix()
        u = inputs(
            "estimator",
            omega_B_measured=RATE + BIAS + noise["rate"],
            b_B_measured=R.T @ p.field.at(t, r) + noise["field"],
            sun_B_measured=R.T @ onboard.sun_direction(p.days + t / 86400.0) + noise["sun"],
            r_N_measured=r + rng.normal(size=3),
            v_N_measured=v + 0.01 * rng.normal(size=3),
        )
        flown.append((R, r, replace(u, R_NB_measured=seen) if tracker else u))
    return flown


def failed(u: Any, name: str, first: Any, change: Any) -> Any:
    return replace(u, **{name: getattr(first, name) if change is None else getattr(u, name) + change})


FAILURES = {
    "gyro frozen": (0, "omega_B_measured", None, FROZEN, 2.0),
    "an axis of the gyro dead": (0, "omega_B_measured", "axis", FROZEN, 2.0),
    "gyro with a bias of 0.3 deg/s": (0, "omega_B_measured", np.full(3, 5e-3), INCONSISTENT, 8.0),
    "magnetometer frozen": (1, "b_B_measured", None, FROZEN, 2.0),
    "magnetometer with a bias of 20 uT": (1, "b_B_measured", np.full(3, 2e-5), JUMPED, 1.0),
    "GNSS frozen, its number counting": (2, "r_N_measured", None, FROZEN, 1.0),
    "GNSS 50 km off": (2, "r_N_measured", np.array((5e4, 0.0, 0.0)), GOOD, 1.5),
    "star tracker frozen": (3, "R_NB_measured", None, FROZEN, 0.1),
    "Sun sensors frozen": (4, "sun_B_measured", None, FROZEN, 1.0),
    "Sun sensors 10 deg off": (4, "sun_B_measured", np.array((0.1, -0.15, 0.1)), INCONSISTENT, 2.0),
}


def flight(case: str, until: int = END) -> list[Any]:
    _, name, change, _, _ = FAILURES[case]
    flown, out = measured(name == "R_NB_measured"), []
    for k, (_, _, u) in enumerate(flown):
        if AT <= k < until:
            first = flown[AT][2]
            if isinstance(change, str):
                axis = np.array((1.0, 0.0, 1.0))
                u = replace(u, omega_B_measured=axis * u.omega_B_measured)
            else:
                u = failed(u, name, first, change)
        out.append(u)
    return out


@cache
def estimated(case: str, until: int = END) -> list[Any]:
    return estimates(flight(case, until))


def estimates(us: list[Any]) -> list[Any]:
    p = sensors()
    x = estimator.start(p, us[0])
    ys = []
    for u in us[1:]:
        x, y = estimator.step(x, u, p, STEP)
        ys.append(y)
    return ys


def assert_both_alike(us: list[Any], ys: list[Any]) -> None:
    """That the native flavour estimates as the Python one."""
    with Instance("estimator") as native:
        native.set_all(sensors())
        native.set_all(us[0])
        native.initialize()
        for k, (u, y) in enumerate(zip(us[1:], ys, strict=True)):
            native.set_all(u)
            native.step(k * STEP, STEP)
            if k % 20 == 0 or k > len(ys) - 3:
                assert_same(native.outputs(), y, "estimator")


def angle(y: Any, R: np.ndarray) -> float:
    return float(np.degrees(Rotation.from_matrix(y.R_NB.T @ R).magnitude()))


@pytest.mark.parametrize("case", FAILURES)
def test_a_sensor_that_fails_is_named_and_left_out_and_the_attitude_stays(case: str) -> None:
    sensor, name, _, health, most = FAILURES[case]
    ys, truth = estimated(case), measured(name == "R_NB_measured")
    assert ys[AT - 2].health[sensor] == GOOD
    assert ys[-1].health[sensor] == health
    others = [i for i in range(5) if i != sensor and (i != 3 or name == "R_NB_measured")]
    assert all(ys[-1].health[i] == GOOD for i in others)
    assert max(angle(y, R) for y, (R, _, _) in zip(ys[AT:], truth[AT + 1 :], strict=True)) < most
    if sensor == 2:
        assert np.linalg.norm(ys[-1].r_N - truth[-1][1]) < 6e4


@pytest.mark.parametrize("case", ["gyro frozen", "magnetometer frozen", "GNSS frozen, its number counting"])
def test_a_sensor_that_works_again_is_used_again_at_its_twentieth_measurement(case: str) -> None:
    sensor, name, _, _, _ = FAILURES[case]
    ys = estimated(case, 300)
    assert ys[298].health[sensor] == FROZEN
    assert ys[299 + 21].health[sensor] == GOOD
    assert angle(ys[-1], measured(name == "R_NB_measured")[-1][0]) < 0.5


@pytest.mark.parametrize("tracker", [False, True])
def test_sound_sensors_are_good_to_the_end(tracker: bool) -> None:
    ys = estimates([u for _, _, u in measured(tracker)])
    assert all(y.health.tolist() == [1, 1, 1, int(tracker), 1] for y in ys)


@pytest.mark.parametrize(
    "case", ["gyro frozen", "gyro with a bias of 0.3 deg/s", "GNSS 50 km off", "star tracker frozen"]
)
def test_both_flavours_fly_a_failure_alike(case: str) -> None:
    assert_both_alike(flight(case), estimated(case))


@pytest.mark.parametrize(("frozen", "suspect"), [(False, True), (True, False)])
def test_a_sensor_that_was_held_against_a_wrong_gyro_is_used_for_the_next_attitude(frozen: bool, suspect: bool) -> None:
    """Field and Sun make the first attitude where the star tracker is blind; without the Sun there is none for good."""
    x = blank(np.zeros(3), sensors())
    x = x.watched(SUN, replace(x.watch[SUN], suspect=True)).watched(GYRO, replace(x.watch[GYRO], frozen=frozen))
    assert restarted(x).watch[SUN].suspect == suspect


def test_a_gyro_that_fails_before_the_first_attitude_leaves_the_rate_to_momentum() -> None:
    """The wheel takes up 0.2 mN m for 60 s about a principal axis; damped by what the gyro last said, a satellite was
    spun up without end. Neither field nor Sun is measured."""
    p, rng, torque = sensors(), np.random.default_rng(7), 2e-4
    us = []
    for k in range(240):
        gyro = us[99].omega_B_measured if k >= 100 else np.array((0.01, 0.0, 0.0)) + 6e-5 * rng.normal(size=3)
        dark = {"b_B_measured": np.zeros(3), "r_N_measured": R_N, "v_N_measured": V_N}
        us.append(inputs("estimator", omega_B_measured=gyro, h_w=torque * STEP * max(k - 120, 0), **dark))
    ys = estimates(us)
    assert not np.any(ys[-1].R_NB)
    expected = us[99].omega_B_measured[0] - torque * 59.5 / p.J_B[0][0]
    assert ys[-1].omega_B[0] == pytest.approx(expected, abs=1e-6)
    assert_both_alike(us, ys)


@pytest.mark.parametrize("by_gyro", [True, False])
def test_an_earlier_field_makes_an_attitude_only_while_a_gyro_turns_it_on(by_gyro: bool) -> None:
    x, y = np.eye(3)[:2]
    earlier = replace(blank(np.zeros(3), sensors()), anchored=True, anchor_B=x, anchor_N=x, by_gyro=by_gyro)
    new = Measured(None, None, None, None, None, None)
    assert started(earlier, new, None, y, x, y, 0.01, sensors()).tracking == by_gyro


def test_a_coarse_quantum_is_no_failure() -> None:
    """Noise of half a quantum: an axis repeats in a third of all measurements."""
    rng, w = np.random.default_rng(1), BLANK
    for _ in range(20000):
        w = noticed(w, np.round(0.5 * rng.normal(size=3)), every=False)
        assert not w.frozen
    for _ in range(20 * (int(w.longest.max()) + 1) + 1):
        w = noticed(w, np.zeros(3), every=False)
    assert w.frozen


def test_without_the_gyro_a_torque_that_is_not_known_makes_the_error_of_a_body_pushed_by_it() -> None:
    """A constant torque of deviation s turns a body at rest by s t^2/2J: the covariance's closed form."""
    J, s, h, steps = np.diag((2.0, 3.0, 4.0)), 1e-5, 0.5, 400
    P, none, t = np.diag(np.repeat((0.0, 0.0, s * s), 3)), np.zeros((3, 3)), h * steps
    for _ in range(steps):
        P = propagated(P, np.zeros(3), h, 1.0, none, none, 0.0, 0.0, np.linalg.inv(J), 1.0)[0]
    assert np.sqrt(np.diag(P)[3:6]) == pytest.approx(s * t / np.diag(J), rel=1e-9)
    assert np.sqrt(np.diag(P)[:3]) == pytest.approx(s * t * t / (2.0 * np.diag(J)), rel=1.5 / steps)


def test_a_torque_is_forgotten_over_its_time_and_keeps_its_deviation() -> None:
    """A Gauss-Markov process: driven by white noise of 2 s^2/T it has the deviation s, after however long."""
    s, h, T, none = 1e-5, 0.5, 6000.0, np.zeros((3, 3))
    P = np.zeros((9, 9))
    for _ in range(100_000 // 50):
        P = propagated(P, np.zeros(3), 50 * h, 1.0, none, none, 0.0, s * np.sqrt(2 / T), none, np.exp(-50 * h / T))[0]
    assert np.sqrt(P[6, 6]) == pytest.approx(s, rel=5e-3)
