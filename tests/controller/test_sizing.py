"""The gain sizing: its bounds against random states and motions that SciPy integrates, its promises against the
loop."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from controller import law, morse
from controller.errors import errors
from controller.reference import inertial, lvlh
from controller.sizing import Wish as W
from controller.sizing import attitude_torque, fastest, largest_torque, size
from tests.controller.loop import J as FULL

VB = W(np.diag([2.13, 3.04, 3.09]) / 50.0, math.pi / 2.0, 0.0966, 193.0, orbital_rate=1.0847e-3)
WIDE = W(FULL, 1.2, 0.05, 400.0, spread=0.2)
HOLD = inertial(np.eye(3))


def torque(s, Q, omega):
    """The law's own torque for a slew to rest."""
    e = errors(Q, omega, HOLD)
    return law.torque(s.wish.J_B, s.K0, s.L0, 1.0, e, law.NO_MOMENT)


def unit(rng):
    x = rng.standard_normal(3)
    return x / np.linalg.norm(x)


def test_no_attitude_asks_for_more_than_the_bound_and_a_turn_about_e1_for_as_much():
    K = np.array([1.3, 2.1, 4.7])
    for Q in Rotation.random(1000, random_state=1).as_matrix():
        U = np.trace(np.diag(K) @ (np.eye(3) - Q))
        assert np.linalg.norm(morse.slope_direction(K, Q)) <= attitude_torque(K, U) * (1.0 + 1e-9)
    for angle in (1e-3, 1.0, 2.5):
        Q = Rotation.from_rotvec([angle, 0.0, 0.0]).as_matrix()
        U = np.trace(np.diag(K) @ (np.eye(3) - Q))
        assert np.linalg.norm(morse.slope_direction(K, Q)) == pytest.approx(attitude_torque(K, U), rel=1e-9)


@pytest.mark.parametrize("V0", [0.01, 1.0, 6.0, 40.0])
def test_the_largest_torque_is_the_one_that_scipy_finds(V0):
    K, L = np.array([1.3, 2.1, 4.7]), np.array([[2.2, 0.3, -0.2], [0.3, 1.7, 0.25], [-0.2, 0.25, 2.6]])
    largest_damping = math.sqrt(np.linalg.eigvalsh(L @ np.linalg.inv(FULL) @ L)[-1])
    found = minimize_scalar(
        lambda U: -(largest_damping * math.sqrt(2.0 * (V0 - U)) + attitude_torque(K, U)),
        bounds=(0.0, min(V0, 13.6)),
        method="bounded",
        options={"xatol": 1e-9},
    )
    assert largest_torque(FULL, K, L, V0) == pytest.approx(-found.fun, rel=1e-7)


@pytest.mark.parametrize("wish", [VB, WIDE, replace(VB, attitude_error=math.pi, rate_error=0.0)])
def test_no_start_of_the_set_has_more_torque_or_a_larger_v_than_the_sizing_says(wish):
    s, rng = size(wish), np.random.default_rng(2)
    for _ in range(400):
        angle, rate = wish.attitude_error * rng.random() ** 0.2, wish.rate_error * rng.random() ** 0.2
        Q, omega = Rotation.from_rotvec(angle * unit(rng)).as_matrix(), rate * unit(rng)
        V = 0.5 * omega @ wish.J_B @ omega + np.trace(np.diag(s.K0) @ (np.eye(3) - Q))
        assert V <= s.V0 * (1.0 + 1e-12)
        assert np.linalg.norm(torque(s, Q, omega)) + s.feedforward <= s.torque_start * (1.0 + 1e-12)
    assert s.torque_start <= s.torque_max


@pytest.mark.parametrize("wish", [replace(VB, orbital_rate=0.0), WIDE])
def test_motions_keep_the_bounds_settle_near_the_wished_time_and_come_near_the_largest_torque(wish):
    s, rng = size(wish), np.random.default_rng(3)
    assert s.converges
    inverse = np.linalg.inv(wish.J_B)

    def slope(_t, y):
        q, omega = y[:4], y[4:]
        moment = torque(s, Rotation.from_quat(q).as_matrix(), omega)
        dq = 0.5 * np.append(q[3] * omega + np.cross(q[:3], omega), -q[:3] @ omega)
        return np.concatenate((dq, inverse @ (moment - np.cross(omega, wish.J_B @ omega))))

    largest, t = [], np.linspace(0.0, 1.5 * wish.time, 101)
    for n in range(3):
        axis = np.array([1.0, 0.0, 0.0]) if n == 0 else unit(rng)
        turn = axis if n == 0 else unit(rng)  # the first turns away, both about the axis of the largest P
        start = [*Rotation.from_rotvec(wish.attitude_error * axis).as_quat(), *(wish.rate_error * turn)]
        y = solve_ivp(slope, (0.0, t[-1]), start, t_eval=t, rtol=1e-5, atol=1e-8).y.T
        Q, omega = Rotation.from_quat(y[:, :4]).as_matrix(), y[:, 4:]
        rate, angle = np.linalg.norm(omega, axis=1), Rotation.from_matrix(Q).magnitude()
        U = np.array([np.trace(np.diag(s.K0) @ (np.eye(3) - R)) for R in Q])
        V = 0.5 * np.einsum("ni,ij,nj->n", omega, wish.J_B, omega) + U
        assert np.diff(V).max() <= 1e-4 * s.V0
        assert rate.max() <= s.rate_max
        largest.append(max(np.linalg.norm(torque(s, R, w)) for R, w in zip(Q, omega, strict=True)))
        outside = (angle >= wish.attitude_tolerance) | (rate >= wish.rate_tolerance)
        settled = t[np.flatnonzero(outside)[-1]]
        assert 0.5 * wish.time < settled < 1.1 * wish.time
    assert 0.75 * s.torque_max < max(largest) <= s.torque_max


@pytest.mark.parametrize("wish", [VB, WIDE])
def test_the_largest_rate_has_all_of_v_about_the_axis_of_the_least_moment(wish):
    s = size(wish)
    omega = s.rate_max * np.linalg.eigh(wish.J_B)[1][:, 0]
    assert 0.5 * omega @ wish.J_B @ omega == pytest.approx(s.V0)


def test_lvlh_and_gravity_add_no_more_than_the_sizing_says_and_can_add_most_of_it():
    s, n = size(VB), VB.orbital_rate
    r, v = np.array([7e6, 0.0, 0.0]), np.array([0.0, 7e6 * n, 0.0])
    reference = lvlh(r, v)
    added = []
    for R in Rotation.random(400, random_state=5).as_matrix():
        e = errors(R, R.T @ reference.R_d @ reference.Omega_d, reference)
        M_g = law.gravity_gradient(n * n * 7e6**3, VB.J_B, R, r)
        tau = law.torque(VB.J_B, s.K0, s.L0, 1.0, e, M_g)
        added.append(np.linalg.norm(tau - torque(s, reference.R_d.T @ R, np.zeros(3))))
    assert 0.6 * s.feedforward < max(added) <= s.feedforward


@pytest.mark.parametrize("wish", [VB, WIDE])
def test_the_linearised_loop_has_the_wished_damping_about_each_axis(wish):
    s = size(wish, 0.7)
    P = np.trace(np.diag(s.K0)) * np.eye(3) - np.diag(s.K0)
    inverse = np.linalg.inv(wish.J_B)
    A = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ P, -inverse @ s.L0]])
    roots = np.linalg.eigvals(A)
    assert -roots.real / np.abs(roots) == pytest.approx(0.7)
    assert np.sort(np.abs(roots))[::2] == pytest.approx(s.frequencies)
    assert -roots.real.max() == pytest.approx(s.decay)
    assert s.time == pytest.approx(wish.time, rel=1e-6)
    moment = np.linalg.norm(P @ (1e-3 * np.array([0.0, 0.0, 1.0])))  # the softest axis
    assert 1e-3 / moment == pytest.approx(s.compliance)


def test_the_gains_of_vb_are_those_of_the_papers_reading():
    """K0 = 0.65 diag(0.9, 1, 1.1)/50 and L0 = 0.9 I/50 with [10] at the start of V.B."""
    s = size(VB)
    k = 0.098 * (3.5 + math.pi / 2.0) / (35.0 + math.pi / 2.0)
    l = 1.47 * (2.1 + 0.0966) / (21.0 + 0.0966)  # noqa: E741 the paper's letter
    assert pytest.approx(0.65 / 50.0 * k * np.array([0.9, 1.0, 1.1]), rel=0.05) == s.K0
    assert np.diag(s.L0) == pytest.approx(0.9 / 50.0 * l * np.ones(3), rel=0.25)


def test_the_schedule_starts_at_the_sized_gains_and_falls():
    s = size(VB)
    p = s.schedule()
    at = [p["kappa0"] * (p["a1"] + angle) / (p["a2"] + VB.attitude_error) for angle in (VB.attitude_error, 0.0)]
    assert at == pytest.approx([1.0, s.scale_at_rest])
    assert p["lambda0"] * (p["c1"] + VB.rate_error) / (p["c2"] + VB.rate_error) == pytest.approx(1.0)


def test_the_fastest_sizing_uses_the_torque_that_there_is():
    s = fastest(replace(VB, torque=2e-3))
    assert 0.9 * 2e-3 < s.torque_max <= 2e-3
    assert s.wish.time < VB.time
    rest = replace(VB, torque=2.0 * VB.orbital_rate**2 * 0.96 / 50.0)
    assert fastest(rest) is None  # the reference alone takes that much


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": 0.0}, "time: expected a finite number above 0, found 0.0"),
        ({"torque": math.nan}, "torque: expected a finite number above 0, found nan"),
        ({"attitude_error": 4.0}, "attitude_error: expected a number from 0 to 3.14159, found 4.0"),
        ({"spread": 1.0}, "spread: expected a number between 0 and 1, found 1.0"),
        ({"attitude_error": 0.01, "rate_error": 0.0}, "within the tolerances from the start"),
        ({"J_B": np.diag([1.0, 1.0, -1.0])}, "J_B: expected a positive definite matrix"),
        ({"J_B": np.arange(9.0).reshape(3, 3)}, "J_B: expected a symmetric 3 by 3 matrix"),
    ],
)
def test_a_wish_that_is_none_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        size(replace(VB, **change))


def test_a_damping_ratio_of_one_is_refused():
    with pytest.raises(ValueError, match="damping: expected a number between 0 and 1, found 1.0"):
        size(VB, 1.0)
