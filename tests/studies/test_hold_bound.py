"""The proof that no controller holds a satellite, against closed forms and against motions that are there."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import controller.reference
from studies.flight.bound import loop, starts
from studies.hold_bound import hat, missing
from studies.satellites.classes import tumbles

ANGLE, RATE = math.radians(5.0), 1e-3
BEGIN, TIME = 9000.0, 1000.0


def plant_of(satellite, chosen):
    """The first of its tumbles under all errors whose inclination, deg, is so."""
    data = starts(tumbles(satellite, 20, errors=True))
    return loop(next(one for one in data if chosen(math.degrees(one["blocks"]["plant"]["start"]["inclination"])))).plant


def like(p, field=None, J=None, torque=None, axis=None, l_max=None):
    """The plant with other properties."""
    return SimpleNamespace(
        orbit=p.orbit,
        field=p.field if field is None else SimpleNamespace(at=field),
        body=SimpleNamespace(J=p.body.J if J is None else J, wheel_axis=p.body.wheel_axis if axis is None else axis),
        disturbance_torque_B=p.disturbance_torque_B if torque is None else torque,
        wheel_momentum_max=p.wheel_momentum_max if l_max is None else l_max,
    )


@pytest.fixture(scope="module")
def low():
    return plant_of("50 kg", lambda tilt: tilt < 15.0)


def test_hat_is_the_cross_product():
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    np.testing.assert_allclose(hat(a) @ b, np.cross(a, b))


@pytest.mark.parametrize("l_max", [1e-9, 1e-3], ids=["no wheel", "a wheel along pitch"])
def test_along_a_steady_field_the_torque_that_is_missing_is_that_of_the_closed_form(low, l_max):
    """A sphere of 1 kg m2 with the field along pitch. Under a steady torque tau it stays within an angle for T at most along a
    parabola, whose height tau T^2/(8 J) is twice the angle; a wheel along pitch takes up 2 l_max of momentum."""
    r, v = low.orbit.position_velocity(0.0)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    p = like(low, lambda t: 3e-5 * normal, np.eye(3), np.array([0.0, 1e-5, 0.0]), np.array([0.0, 1.0, 0.0]), l_max)
    closed = 1e-5 - 16.0 * ANGLE / TIME**2 - 2.0 * l_max / TIME
    found = missing(p, BEGIN, BEGIN + TIME, ANGLE, RATE)
    assert 0.85 * closed < found < closed
    of_rate = 1e-5 - 2.0 * RATE / 300.0 - 2.0 * l_max / 300.0  # in 300 s the limit of the rate is the closer one
    assert max(0.85 * of_rate, 0.0) <= missing(p, BEGIN, BEGIN + 300.0, ANGLE, RATE) <= max(of_rate, 0.0)
    assert missing(p, BEGIN, BEGIN + 300.0, ANGLE, 10.0 * RATE) == 0.0


def test_nothing_is_missing_where_the_field_turns_and_the_hold_is_known():
    """tests/studies/test_hold.py has the motion, within 0.1 deg."""
    p = plant_of("50 kg", lambda tilt: tilt > 60.0)
    assert missing(p, BEGIN, BEGIN + 3000.0, math.radians(0.1), RATE) == 0.0


@pytest.mark.fly
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_by_the_exact_equations_is_never_excluded(low, seed):
    """Attitudes are drawn as sines of time, and the wheel's momentum is integrated so that the momentum along the field balances;
    with the largest angle, rate and momentum of this very motion as limits nothing may be missing."""
    rng = np.random.default_rng(seed)
    size, speed, phase = rng.uniform(0.01, 0.03, 3), rng.uniform(2e-3, 6e-3, 3), rng.uniform(0.0, 6.0, 3)
    J, tau, axis = np.asarray(low.body.J), np.asarray(low.disturbance_torque_B), np.array([0.2, 0.9, 0.38])
    axis = axis / np.linalg.norm(axis)

    def frame(t):
        at = controller.reference.lvlh(*low.orbit.position_velocity(t))
        return np.array(at.R_d), np.array(at.Omega_d)

    def attitude(t):
        return Rotation.from_rotvec(size * np.sin(speed * (t - BEGIN) + phase)).as_matrix()

    def along(t, step=0.05):
        """b.(Q J Omega) and b.(Q a), and the rate of the body relative to LVLH in its axes."""
        L, turn = frame(t)
        Q, b = attitude(t), low.field.at(t)
        after, before = attitude(t + step), attitude(t - step)
        rate = Rotation.from_matrix(before.T @ after).as_rotvec() / (2.0 * step)
        b = L.T @ b / np.linalg.norm(b)
        return np.array([b @ Q @ J @ (rate + Q.T @ turn), b @ Q @ axis]), rate

    def balance(t, momentum, step=1.0):
        L, turn = frame(t)
        Q, down = attitude(t), np.array([0.0, 0.0, 1.0])
        later, sooner = (low.field.at(t + s) / np.linalg.norm(low.field.at(t + s)) for s in (step, -step))
        c, b = L.T @ (later - sooner) / (2.0 * step), L.T @ (later + sooner) / np.linalg.norm(later + sooner)
        (_, rate), (ahead, _), (behind, _) = along(t), along(t + step), along(t - step)
        h = Q @ (J @ (rate + Q.T @ turn) + momentum[0] * axis)
        torque = Q @ tau + 3.0 * (turn @ turn) * np.cross(down, Q @ J @ Q.T @ down)
        of_body, of_axis = (ahead - behind) / (2.0 * step)
        return [(b @ torque + c @ h - of_body - momentum[0] * of_axis) / (b @ Q @ axis)]

    end = BEGIN + 1500.0
    flown = solve_ivp(balance, (BEGIN, end), [-0.01], max_step=5.0, rtol=1e-8, atol=1e-10)
    angle = float(np.linalg.norm(size))
    rate = float(np.linalg.norm(size * speed))
    p = like(low, axis=axis, l_max=float(np.abs(flown.y).max()) * 1.001)
    assert missing(p, BEGIN, end, angle, 1.05 * rate) == pytest.approx(0.0, abs=1e-9)
    tight = like(low, axis=axis, l_max=0.1 * float(np.ptp(flown.y)), torque=5.0 * tau)
    assert missing(tight, BEGIN, end, angle, 1.05 * rate) > 1e-6


@pytest.mark.parametrize("seed", range(8))
def test_an_attitude_that_is_kept_at_the_limit_by_the_wheel_alone_is_never_excluded(low, seed):
    """At rest in LVLH 4.9 deg from it, with next to no room for a rate: the terms that are linear in the angle must have their signs."""
    rng = np.random.default_rng(seed)
    turn, tau = (
        size * v / np.linalg.norm(v) for size, v in zip((0.98 * ANGLE, 1.1e-5), rng.normal(size=(2, 3)), strict=True)
    )
    Q, axis, down = Rotation.from_rotvec(turn).as_matrix(), np.array([1.0, 2.0, 2.0]) / 3.0, np.array([0.0, 0.0, 1.0])
    K, end = Q @ np.asarray(low.body.J) @ Q.T, BEGIN + 3000.0

    def balance(t, momentum):
        at = controller.reference.lvlh(*low.orbit.position_velocity(t))
        Omega, b = np.array(at.Omega_d), np.array(at.R_d).T @ low.field.at(t)
        torque = Q @ tau + 3.0 * (Omega @ Omega) * np.cross(down, K @ down)
        return [b @ (torque - np.cross(Omega, K @ Omega + momentum[0] * Q @ axis)) / (b @ Q @ axis)]

    first = solve_ivp(balance, (BEGIN, end), [0.0], max_step=50.0, rtol=1e-8, atol=1e-12).y
    begin = -0.5 * (first.max() + first.min())
    momentum = solve_ivp(balance, (BEGIN, end), [begin], max_step=50.0, rtol=1e-8, atol=1e-12).y
    p = like(low, torque=tau, axis=axis, l_max=1.0005 * float(np.abs(momentum).max()))
    assert missing(p, BEGIN, end, ANGLE, 1e-5) == pytest.approx(0.0, abs=1e-10)
