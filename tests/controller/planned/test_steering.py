"""Steering of the total momentum: the costate, the time that it needs, and the rods' commands."""

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from design.momentum import MomentumBalance, Tolerance, farthest
from tests.blocks import parameters
from tests.plant.motion import checked

from . import core, flat, steering
from .states import R0, V0

RHO = 28.0


def ahead(latitude=0.0, node=0.0):
    turn = Rotation.from_rotvec([0, 0, node]).as_matrix()
    r, v = core.orbit_at(R0, V0, latitude * 5792.0 / (2 * math.pi))
    return core.Ahead(turn @ r, turn @ v)


CASES = 12


@pytest.fixture(scope="module")
def cases():
    """Places in the orbit and momenta to be given, N m s."""
    rng = np.random.default_rng(28)
    return [
        (ahead(*rng.uniform(0, 2 * math.pi, 2)), rng.normal(size=3) * rng.uniform(0.05, 0.25)) for _ in range(CASES)
    ]


@pytest.fixture(scope="module")
def solved(cases):
    """The cases in which costate and time are those of the convex problem, to 5 deg and 1 %: (place, momentum, costate,
    time)."""
    right = []
    for a, D in cases:
        p, T = steering.least_time(D, lambda t, a=a: core.around(a, t)[0].B_N, RHO, 3100.0)
        lam, time = core.steer(a, 0.0, D, RHO, calls=20)
        assert np.linalg.norm(lam) == pytest.approx(1.0)
        if abs(time / T - 1.0) < 0.01 and lam @ p > math.cos(math.radians(5.0)):
            right.append((a, D, lam, time))
    return right


def test_the_costate_and_its_time_are_mostly_those_of_the_convex_problem(solved):
    """The fixed-point iteration has no proof: of 120 problems of five seeds, 115 came out right.

    The others ended at 0.54 to 1.22 times the least time; the plan that follows corrects what is left.
    With that rate three or more of 12 go wrong in one of a hundred seeds.
    """
    assert len(solved) >= CASES - 2


def test_flown_for_its_time_the_costate_gives_the_momentum(solved):
    judged = 0
    for a, D, lam, time in solved:
        given, h, least = np.zeros(3), time / 1000.0, 1.0
        for t in (np.arange(1000) + 0.5) * h:
            B = core.around(a, t)[0].B_N
            across = np.cross(B, lam)
            least = min(least, np.linalg.norm(across) / np.linalg.norm(B))
            given += h * np.cross(RHO * across / np.linalg.norm(across), B)
        if least > 0.03:  # where the field comes to point along lambda, across it is no direction
            judged += 1
            assert np.linalg.norm(given - D) < 0.003 * np.linalg.norm(D)
    assert judged >= CASES / 2


@pytest.mark.parametrize("rate", [[0.05, 0.05, 0.03], [-0.06, 0.02, 0.04], [0.0, -0.08, 0.02]])
def test_the_time_is_not_below_the_bound_that_momentum_sets(rate):
    """The bound: design/momentum.py on the plant's own field, without wheel, tolerance and disturbances."""
    p = checked(
        node_longitude=math.radians(158.0), omega_B0=rate, gravity_gradient=False, drag=False, wheel_momentum_max=1e-9,
        epoch="2009-08-10T00:00:00Z",
    )  # fmt: skip
    law = parameters("controller")
    bound = MomentumBalance(
        p, law, dipole_max=RHO / farthest(p.rod_axes), tolerance=Tolerance(0.0, 0.0), horizon=3000.0
    )
    T = bound.least_time().least
    r, v = p.orbit.position_velocity(0.0)
    a = core.Ahead(r, v)
    # The target's momentum turns with the orbit: what is to be given by the end, as the controller comes to see it.
    D, _ = bound.needed(T)
    _, time = core.steer(a, 0.0, D, RHO, calls=20)
    assert 0.98 * T < time < 1.06 * T


def test_one_call_comes_close_and_the_next_ones_closer(solved):
    for a, D, lam, _ in solved:
        apart = [math.acos(min(core.steer(a, 0.0, D, RHO, calls=n)[0] @ lam, 1.0)) for n in (1, 4)]
        assert apart[0] < math.radians(25.0)
        assert apart[1] <= apart[0] + 1e-6


def test_no_momentum_to_give_leaves_all_at_rest(cases):
    lam, time = core.steer(cases[0][0], 0.0, np.zeros(3), RHO)
    assert not lam.any()
    assert time == 0.0
    assert not core.steering_rods(lam, 100.0, np.eye(3), np.array([2e-5, 1e-5, 3e-5]), 25.0 * flat.RODS).any()


def tasks(n=300):
    rng = np.random.default_rng(29)
    for _ in range(n):
        lam, B = rng.normal(size=3), rng.normal(size=3) * 3e-5
        yield lam / np.linalg.norm(lam), Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix(), B


def test_near_the_end_rods_act_at_full_strength_across_the_field_along_the_costates_torque():
    rods = 25.0 * flat.RODS
    for lam, R, B in tasks():
        u = core.steering_rods(lam, 50.0, R, B, rods)
        assert np.abs(u).max() == pytest.approx(1.0, rel=1e-12)
        torque = np.cross(u @ rods, B)
        wanted = np.cross(np.cross(B, R.T @ lam), B)
        assert torque @ wanted / np.linalg.norm(torque) / np.linalg.norm(wanted) == pytest.approx(1.0, abs=1e-12)
        assert abs(torque @ B) < 1e-14 * np.linalg.norm(B)


def test_the_part_along_the_field_makes_the_most_of_the_rods():
    """The torque's size is the largest that any commands within the limits give in its direction: a linear
    programme."""
    rods = 25.0 * flat.RODS
    for lam, R, B in tasks(60):
        torque = np.cross(core.steering_rods(lam, 50.0, R, B, rods) @ rods, B)
        unit = torque / np.linalg.norm(torque)
        A = np.cross(rods, B).T  # torque of each rod
        best = linprog(
            [0, 0, 0, -1.0],
            A_eq=np.column_stack((A * 1e4, -unit)),
            b_eq=np.zeros(3),
            bounds=[(-1, 1)] * 3 + [(0, None)],
        )
        assert np.linalg.norm(torque) * 1e4 == pytest.approx(-best.fun, rel=1e-6)


def test_far_from_the_end_the_rods_give_nearly_the_most_along_the_costate():
    """Of the momentum's rate along lambda: a linear programme in the rods' commands."""
    rods, shares = 25.0 * flat.RODS, []
    for lam, R, B in tasks(200):
        u = core.steering_rods(lam, 500.0, R, B, rods)
        assert np.abs(u).max() <= 1.0
        along = np.cross(rods, B) @ (R.T @ lam)  # of each rod
        best = linprog(-along * 1e4, bounds=[(-1, 1)] * 3)
        shares.append(along @ u * 1e4 / -best.fun)
        assert abs(np.cross(u @ rods, B) @ B) < 1e-17
    assert min(shares) > 0.8
    assert np.mean(shares) > 0.98


def test_three_rods_give_more_than_the_dipole_that_steering_counts_on_in_the_mean():
    """1.12 of a rod's; over attitudes, fields and costates of any direction the mean is 1.22. It is no bound."""
    rods = 25.0 * flat.RODS
    sizes = []
    for lam, R, B in tasks(1000):
        torque = np.cross(core.steering_rods(lam, 50.0, R, B, rods) @ rods, B)
        sizes.append(np.linalg.norm(torque) / np.linalg.norm(B) / 25.0)
    assert 1.12 < np.mean(sizes) < 1.3
    assert min(sizes) < 1.12


@pytest.mark.parametrize(("time", "share"), [(60.0, 1.0), (20.0, 1.0), (10.0, 0.5), (1.0, 0.05), (0.0, 0.0)])
def test_near_the_end_the_rods_are_lessened(time, share):
    lam, R, B = next(iter(tasks(1)))
    u = core.steering_rods(lam, time, R, B, 25.0 * flat.RODS)
    assert np.abs(u).max() == pytest.approx(share)


def test_the_commands_turn_with_the_satellite():
    """In another attitude the same field and costate give the same torque in N, with rods that are turned along."""
    lam, _, B = next(iter(tasks(1)))
    torques = []
    for axis in itertools.product((0.0, 1.0), repeat=3):
        R = Rotation.from_rotvec(axis).as_matrix()
        rods = 25.0 * flat.RODS @ R  # the same rods, seen in the turned body
        torques.append(np.cross(core.steering_rods(lam, 50.0, R, R.T @ B, rods) @ flat.RODS, B))
    assert np.ptp(torques, axis=0).max() < 1e-15


def test_where_two_rods_give_alike_along_the_field_the_direction_is_kept_and_no_command_exceeds_its_limit():
    """Rods on the body axes in a field with two equal components: their line of equal shares is parallel to the
    field."""
    lam, R = np.array([0.3, -0.5, 0.81]), np.eye(3)
    B = np.array([2e-5, 2e-5, 1e-5])
    u = core.steering_rods(lam, 50.0, R, B, 25.0 * np.eye(3))
    torque, across = np.cross(25.0 * u, B), np.cross(np.cross(B, lam), B)
    assert torque / np.linalg.norm(torque) == pytest.approx(across / np.linalg.norm(across), abs=1e-12)
    assert np.abs(u).max() == pytest.approx(1.0)


def test_without_a_field_there_is_no_direction_to_steer_in():
    """A field of degree 0 is zero everywhere: the costate stays what it was."""
    lam, time = core.steer(core.Ahead(R0, V0, degree=0), 0.0, np.array([0.0, 0.02, 0.01]), 25.0)
    assert not lam.any()
    assert time == 0.0
