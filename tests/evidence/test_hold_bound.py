"""The proof that no controller holds a satellite, against closed forms and against motions that are there."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp
from scipy.spatial.transform import Rotation

import controller.reference
from controller.so3 import hat
from evidence import hold_course
from evidence.flight.bound import loop, starts
from evidence.hold_bound import missing, programme
from evidence.hold_course import Course
from evidence.satellites.classes import tumbles
from orchestration import InputError

ANGLE, RATE = math.radians(5.0), 1e-3
BEGIN, TIME = 9000.0, 1000.0


def plant_of(satellite, chosen):
    """The first of its tumbles under all errors whose inclination, deg, is so."""
    data = starts(tumbles(satellite, 20, errors=True))
    return loop(next(one for one in data if chosen(math.degrees(one["blocks"]["plant"]["start"]["inclination"])))).plant


def like(p, field=None, J=None, torque=None, axis=None, l_max=None):
    """The plant with other properties, without drag."""
    return SimpleNamespace(
        orbit=p.orbit,
        field=p.field if field is None else SimpleNamespace(at=field),
        body=SimpleNamespace(J=p.body.J if J is None else J),
        wheel_axes=p.wheel_axes if axis is None else [axis],
        disturbance_torque_B=p.disturbance_torque_B if torque is None else torque,
        wheel_momentum_max=p.wheel_momentum_max if l_max is None else l_max,
        drag=False,
    )


def moment_of_drag(p, t, R):
    """By the plant's own law, N m in body axes; R from body to N."""
    v_N, density = p.air.flow(t)
    return p.surface.moment(R.T @ v_N, density)


def like_disturbance(p):
    """The plant with drag as large as its disturbance."""
    at_target = controller.reference.lvlh(*p.orbit.position_velocity(BEGIN)).R_d
    moment = moment_of_drag(replace(p, drag_factor=1.0), BEGIN, np.array(at_target))
    return replace(p, drag_factor=float(np.linalg.norm(p.disturbance_torque_B) / np.linalg.norm(moment)))


@pytest.fixture(scope="module")
def low():
    return plant_of("50 kg", lambda tilt: tilt < 15.0)


@pytest.mark.parametrize("l_max", [1e-9, 1e-3], ids=["no wheel", "a wheel along pitch"])
def test_along_a_steady_field_the_torque_that_is_missing_is_that_of_the_closed_form(low, l_max):
    """A sphere of 1 kg m2 with the field along pitch. Under a steady torque tau it stays within an angle for T at most
    along a parabola, whose height tau T^2/(8 J) is twice the angle; a wheel along pitch takes up 2 l_max of
    momentum."""
    r, v = low.orbit.position_velocity(0.0)
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    p = like(low, lambda t: 3e-5 * normal, np.eye(3), np.array([0.0, 1e-5, 0.0]), np.array([0.0, 1.0, 0.0]), l_max)
    closed = 1e-5 - 16.0 * ANGLE / TIME**2 - 2.0 * l_max / TIME
    found = missing(p, BEGIN, BEGIN + TIME, ANGLE, RATE)
    assert 0.8 * closed < found < closed
    of_rate = 1e-5 - 2.0 * RATE / 300.0 - 2.0 * l_max / 300.0  # in 300 s the limit of the rate is the closer one
    assert max(0.8 * of_rate, 0.0) <= missing(p, BEGIN, BEGIN + 300.0, ANGLE, RATE) <= max(of_rate, 0.0)
    assert missing(p, BEGIN, BEGIN + 300.0, ANGLE, 10.0 * RATE) == 0.0


def test_nothing_is_missing_where_the_field_turns_and_the_hold_is_known():
    """A motion within 0.1 deg is known."""
    p = plant_of("50 kg", lambda tilt: tilt > 60.0)
    assert missing(p, BEGIN, BEGIN + 3000.0, math.radians(0.1), RATE) == 0.0


@pytest.mark.fly
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_by_the_exact_equations_is_never_excluded(low, seed):
    """Attitudes are drawn as sines of time, and the wheel's momentum is integrated so that the momentum along the
    field balances; with the largest angle, rate and momentum of this very motion as limits nothing may be missing."""
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


@pytest.mark.parametrize("drag", [False, True], ids=["no drag", "drag"])
@pytest.mark.parametrize("seed", range(4))
def test_the_rows_hold_for_any_motion_once_the_torque_along_the_field_that_it_needs_is_taken_off(seed, drag):
    """Attitudes at the full angle, any wheel momentum, and drag as large as the disturbance; the torque is that of
    the exact law d(h)/dt + Omega x h, without b or c."""
    p = plant_of("50 kg, wheel along (1, 2, 2)/3", lambda tilt: 15.0 * seed < tilt < 15.0 * seed + 40.0)
    p = replace(like_disturbance(p), drag=drag)
    rng, fine = np.random.default_rng(seed), 80
    course = Course.of(p, BEGIN, BEGIN + 400.0)
    n, dt = len(course.b) // 2, course.interval
    t = np.linspace(0.0, n * dt, n * fine + 1)
    size, speed, phase = rng.normal(size=3), rng.uniform(1e-3, 2e-2, 3), rng.uniform(0.0, 6.0, 3)
    size *= 0.999 * ANGLE / np.linalg.norm(size)

    def turned(at):
        return Rotation.from_rotvec(size * np.sin(speed * at[:, None] + phase))

    theta, Q = turned(t).as_rotvec(), turned(t).as_matrix()
    nu = (turned(t + 1e-3) * turned(t - 1e-3).inv()).as_rotvec() / 2e-3
    momentum = p.wheel_momentum_max * np.sin(rng.uniform(1e-3, 2e-2) * t + rng.uniform(0.0, 6.0))
    frames = [controller.reference.lvlh(*p.orbit.position_velocity(BEGIN + s)) for s in t]
    Omega, down = np.array(frames[0].Omega_d), np.array([0.0, 0.0, 1.0])
    b = np.array([np.array(f.R_d).T @ p.field.at(BEGIN + s) for f, s in zip(frames, t, strict=True)])
    b /= np.linalg.norm(b, axis=1)[:, None]
    K = Q @ np.asarray(p.body.J) @ Q.transpose(0, 2, 1)
    h = np.einsum("tij,tj->ti", K, Omega + nu) + momentum[:, None] * (Q @ p.wheel_axes[0])
    given = Q @ p.disturbance_torque_B + 3.0 * (Omega @ Omega) * np.cross(down, K @ down)
    if drag:
        attitudes = zip(Q, frames, t, strict=True)
        given += np.array([q @ moment_of_drag(p, BEGIN + s, np.array(f.R_d) @ q) for q, f, s in attitudes])
    needed = np.einsum("ti,ti->t", b, np.gradient(h, t, axis=0, edge_order=2) + np.cross(Omega, h) - given)

    def means(values):
        parts = [values[fine * k : fine * (k + 1) + 1] for k in range(n)]
        return np.array([simpson(part, dx=dt / fine, axis=0) for part in parts]) / dt

    ends = np.column_stack((np.einsum("ti,ti->t", b, h), theta))[::fine]
    within = np.hstack([means(x) for x in (theta, nu, momentum[:, None], momentum[:, None] * theta)])
    x = np.concatenate((np.hstack((ends[:-1], within)).ravel(), ends[-1], [0.0]))
    rate = 1.05 * float(np.linalg.norm(nu, axis=1).max())
    found = programme(p, course, ANGLE, rate)
    excess = found.excess(x).reshape(-1, n)
    assert (np.abs(x[:-1]) <= found.limits[:-1]).all()
    assert (excess[0] - dt * means(needed) <= 0.0).all()
    assert (excess[1] + dt * means(needed) <= 0.0).all()
    assert (excess[2:4] <= 0.25 * dt * np.abs(needed).max()).all()
    assert (excess[4:] <= 1e-12).all()
    # With the disturbance turned round the same motion breaks the balance; with drag, whose bound is wide, with a
    # torque thrice as large.
    turned_round = [{"disturbance_torque_B": -(3.0 if drag else 1.0) * p.disturbance_torque_B}]
    for changed in turned_round + [{"drag_factor": -3.0 * p.drag_factor}] * drag:
        other = programme(replace(p, **changed), course, ANGLE, rate).excess(x).reshape(-1, n)
        assert max((other[0] - dt * means(needed)).max(), (other[1] + dt * means(needed)).max()) > 0.0


@pytest.mark.parametrize("satellite", ["50 kg", "50 kg, elongated", "1U, no wheel"])
def test_the_moment_of_drag_is_what_the_rows_take_it_for_to_the_bound_of_the_rest(satellite):
    p = like_disturbance(plant_of(satellite, lambda tilt: tilt > 20.0))
    course, rng = Course.of(p, BEGIN, BEGIN + 200.0), np.random.default_rng(0)
    moment, change, rest = hold_course.drag(p, course, ANGLE)
    of_place = [np.array(controller.reference.lvlh(*p.orbit.position_velocity(t)).R_d) for t in course.times]
    left, without = [], []
    for k, L in enumerate(of_place):
        for theta in rng.normal(size=(100, 3)):
            theta *= ANGLE / np.linalg.norm(theta)
            Q = Rotation.from_rotvec(theta).as_matrix()
            exact = Q @ moment_of_drag(p, course.times[k], L @ Q)
            left.append(np.linalg.norm(exact - moment[k] - change[k] @ theta))
            without.append(np.linalg.norm(exact - moment[k]))
    assert max(left) <= rest
    assert 0.1 * rest < max(left) < 0.7 * max(without)


def test_what_is_left_of_the_flow_on_a_plate_is_within_its_bound_and_reaches_both_ends():
    """max(x + y, 0) of a plate that stands at x to the flow, |y| <= a, less its linear part: from 0 to (a^2 -
    x^2)/2a."""
    a = ANGLE
    for x in np.linspace(-1.5 * a, 1.5 * a, 13):
        y = np.linspace(-a, a, 2001)
        (share, opposite), (bound, _) = hold_course.facing(np.array([x, -x]), a)
        left = np.maximum(x + y, 0.0) - share * (x + y)
        assert left.min() == pytest.approx(0.0, abs=1e-4 * a)
        assert left.max() == pytest.approx(bound, abs=1e-4 * a)
        np.testing.assert_allclose(np.maximum(-x - y, 0.0) - opposite * (-x - y), left, atol=1e-15)


def test_the_rest_of_a_turned_matrix_is_within_its_bound():
    rng = np.random.default_rng(0)
    for _ in range(200):
        S, theta = rng.normal(size=(3, 3)), rng.normal(size=3)
        theta *= ANGLE / np.linalg.norm(theta)
        Q = Rotation.from_rotvec(theta).as_matrix()
        linear = S + hat(theta) @ S - S @ hat(theta)
        rest = np.linalg.norm(Q @ S @ Q.T - linear, 2)
        assert rest <= hold_course.second(ANGLE) * hold_course.uneven(S)


def test_drag_alone_can_be_what_no_controller_holds():
    p = like_disturbance(plant_of("1U, no wheel", lambda tilt: tilt < 15.0))
    p = replace(p, drag_factor=10.0 * p.drag_factor, disturbance_torque_B=0.01 * p.disturbance_torque_B)
    assert missing(p, BEGIN, BEGIN + 3000.0, ANGLE, 3e-3) > 0.0
    assert missing(replace(p, drag=False), BEGIN, BEGIN + 3000.0, ANGLE, 3e-3) == 0.0


def test_an_eccentric_orbit_is_refused(low):
    with pytest.raises(InputError, match="circular"):
        missing(SimpleNamespace(orbit=SimpleNamespace(eccentricity=0.01)), BEGIN, BEGIN + TIME, ANGLE, RATE)
