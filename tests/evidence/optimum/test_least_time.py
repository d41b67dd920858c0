"""The least time by multiple shooting: the model against the plant FMU, the transcription against a closed form."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evidence.flight.bound import loop, starts
from evidence.flight.schemes import change
from evidence.motion import SECONDS
from evidence.optimum.check import check
from evidence.optimum.courses import Course
from evidence.optimum.make import group
from evidence.optimum.motion import Motion
from evidence.optimum.problem import HOLD, Grid
from evidence.optimum.transcription import Guess, Task, solve
from orchestration import run


@pytest.fixture(scope="module")
def tumble():
    """Start values and plant of run 3, at 4.9 deg/s."""
    data = starts(group(4))[3]
    return data, loop(data).plant


def test_a_minute_of_the_model_is_that_of_the_plant_fmu(tumble):
    data, p = tumble
    u = np.array([0.9, -0.7, 0.5, 0.3])
    commands = {"dipole_cmd": p.dipole_max * u[:3], "wheel_torque_cmd": 0.03 * p.wheel_torque_max * u[3]}
    data = change(
        {**data, "blocks": dict(data["blocks"])}, {f"plant.{name}": value for name, value in commands.items()}
    )
    scenario = {"name": "minute", "step": 0.1, "duration": 60.0, "blocks": data["blocks"], "shared": data["shared"]}
    result = run({**scenario, "record": {"interval": 60.0, "signals": ["plant.R_NB", "plant.omega_B", "plant.h_w"]}})
    motion = Motion(p, 300.0)
    assert motion.field_error < 1e-12
    step, h = motion.step(), 1.0
    q = Rotation.from_matrix(motion.lvlh(0.0).T @ p.R_NB0).as_quat()
    x = np.concatenate((q[[3, 0, 1, 2]], SECONDS * p.omega_B0, [SECONDS * p.h_w0]))
    u[3] *= 0.03
    for i in range(60):
        x = np.asarray(step(x, u, i * h / SECONDS, h / SECONDS)).ravel()
    Q = Rotation.from_matrix(motion.lvlh(60.0).T @ result["plant.R_NB"][-1])
    # Drag, of 1e-7 N m, is not in the model: it turns the satellite by 6e-5 rad in a minute.
    assert (Rotation.from_quat(x[[1, 2, 3, 0]]).inv() * Q).magnitude() < 1e-4
    np.testing.assert_allclose(x[4:7] / SECONDS, result["plant.omega_B"][-1], atol=5e-6)
    assert x[7] / SECONDS == pytest.approx(result["plant.h_w"][-1], rel=1e-9)


def test_from_rest_to_rest_the_double_integrator_takes_twice_the_root_of_the_distance():
    """|u| <= 1 over a distance of 2.25: half of T = 2 sqrt(2.25) there, half of it back."""
    x, u, t, h = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("t"), ca.SX.sym("h")
    step = ca.Function("step", [x, u, t, h], [ca.vertcat(x[0] + h * x[1] + 0.5 * h * h * u, x[1] + h * u)])
    within = ca.Function("within", [x], [ca.sumsqr(x) / 1e-3**2])
    task = Task(step, within, within, np.full(2, np.inf), 0.1, 20.0)
    N, M = 30, 2
    guess = Guess(5.0, np.linspace([-2.25, 0.0], [0.0, 0.0], N + M + 1).T, np.zeros((1, N + M)), M)
    found = solve(task, guess)
    assert found.feasible
    assert found.time == pytest.approx(3.0, rel=0.01)
    np.testing.assert_allclose(found.u[0, : N // 2 - 1], 1.0, atol=0.02)
    np.testing.assert_allclose(found.u[0, N // 2 + 1 : N], -1.0, atol=0.02)


def test_where_the_longest_time_is_too_short_nothing_is_feasible():
    x, u, t, h = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("t"), ca.SX.sym("h")
    step = ca.Function("step", [x, u, t, h], [ca.vertcat(x[0] + h * x[1] + 0.5 * h * h * u, x[1] + h * u)])
    within = ca.Function("within", [x], [ca.sumsqr(x) / 1e-3**2])
    task = Task(step, within, within, np.full(2, np.inf), 0.1, 2.9)
    assert not solve(task, Guess(2.0, np.linspace([-2.25, 0.0], [0.0, 0.0], 23).T, np.zeros((1, 22)), 2)).feasible


# ---------------------------------------------------------------- courses


def course():
    """100 s about one axis to LVLH, and HOLD there."""
    times = np.arange(0.0, 100.0 + HOLD + 1.0)
    angle = 2.0 * np.clip(1.0 - times / 100.0, 0.0, 1.0)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    rates = np.where(times < 100.0, -0.02, 0.0)[:, None] * axis
    return Course(
        times, Rotation.from_rotvec(angle[:, None] * axis), rates, np.zeros((len(times), 1)), np.zeros((len(times), 4))
    )


def test_one_turn_more_begins_and_ends_as_the_course_and_turns_by_360_degrees_more():
    plain, turned = course(), course().turned(np.eye(3)[0], np.zeros(3))
    for i in (0, 100, -1):
        assert (plain.attitudes[i].inv() * turned.attitudes[i]).magnitude() < 1e-9
    extra = np.unwrap((plain.attitudes.inv() * turned.attitudes).as_rotvec()[:101, 0])
    assert abs(extra[-1] - extra[0]) == pytest.approx(2.0 * math.pi)


@pytest.mark.parametrize(("turns", "angle"), [(0, 2.0), (1, 2.0 * math.pi - 2.0)])
def test_straight_takes_the_short_way_or_the_other_way_round(turns, angle):
    straight = course().straight(np.zeros(3), turns)
    steps = (straight.attitudes[:-1].inv() * straight.attitudes[1:]).as_rotvec()
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(angle, rel=1e-9)
    # The rates are those of the attitudes.
    np.testing.assert_allclose(straight.Omega[50], 0.5 * (steps[49] + steps[50]), atol=1e-12)


def test_a_course_in_less_time_is_the_same_path_at_a_higher_rate():
    slow, fast = course(), course().within(40.0)
    assert fast.end == pytest.approx(40.0)
    assert (slow.attitudes.inv() * fast.attitudes).magnitude().max() == 0.0
    np.testing.assert_allclose(fast.Omega[50], 2.5 * slow.Omega[50])
    np.testing.assert_allclose(fast.Omega[0], slow.Omega[0])  # the satellite's own
    assert course().within(1000.0).end == slow.end


def test_a_course_is_its_beginning_and_then_what_is_left_of_it():
    whole = course()
    again = whole.then(40.0, whole.late(40.0))
    np.testing.assert_allclose(again.times, whole.times)
    assert (again.attitudes.inv() * whole.attitudes).magnitude().max() < 1e-9
    guess = again.guess(Grid(10.0, 16))
    assert guess.u.shape == (4, 16 + 12)
    assert (guess.x[:4, 1:] * guess.x[:4, :-1]).sum(axis=0).min() > 0.9, "no jump of the quaternion's sign"


# ---------------------------------------------------------------- the check


def test_commands_that_do_not_end_in_the_tolerance_do_not_pass(tumble):
    _, p = tumble
    seen = check(p, course(), group(4).scenario)
    assert seen.rate > 0.05, "the tumble goes on"
    assert not seen.held_on
