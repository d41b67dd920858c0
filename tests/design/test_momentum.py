"""The momentum bound against closed forms, a linear program and dipole histories that it must never exclude."""

import math

import numpy as np
import pytest
from scipy.optimize import linprog

from design.impulse import SAMPLE
from design.loop import read
from design.momentum import MomentumBalance, Tolerance, farthest
from evidence.paper import constants
from plant.solar_pressure import at_distance
from plant.sun import AU

EXACT = Tolerance(0.0, 0.0)
RODS = np.array([[1, 1, -1], [1, -1, 1], [0, 0, math.sqrt(3)]]) / math.sqrt(3)
QUIET = {"plant.gravity_gradient": False, "plant.drag": False}


def loop(which="no_singularity", **changes):
    return read(f"scenarios/paper_{which}.yaml").loop.change(constants(mass=1.0) | changes)


def balance(which="no_singularity", dipole_max=None, tolerance=EXACT, horizon=1000.0, **changes):
    parts = loop(which, **(QUIET | changes))
    return MomentumBalance(parts.plant, parts.controller, dipole_max, tolerance, horizon)


class Steady:
    """A field of one direction and strength."""

    def __init__(self, B):
        self.B = np.array(B)

    def at(self, t):
        return self.B


def in_field(B, monkeypatch, **changes):
    """The balance of an inertial hold, which ends with the wheel's momentum alone, in a steady field."""
    monkeypatch.setattr("plant.parameters.Parameters.field", property(lambda self: Steady(B)))
    return balance(**{"controller.reference": "inertial"}, **changes)


def test_the_radius_is_that_of_the_farthest_vertex_and_no_dipole_lies_beyond_it():
    assert farthest(RODS) == pytest.approx(2.4446, abs=5e-5)
    assert farthest(np.eye(3)) == pytest.approx(math.sqrt(3.0))
    mu = np.random.default_rng(0).uniform(-1.0, 1.0, (10000, 3))
    assert np.linalg.norm(mu @ RODS, axis=1).max() <= farthest(RODS)


def test_across_a_steady_field_the_least_time_is_momentum_over_torque(monkeypatch):
    rest = {"plant.wheel_momentum_max": 0.0}
    probe = in_field([0.0, 0.0, 3e-5], monkeypatch, **rest)
    normal = np.cross(probe.H0, [1.0, 0.0, 0.0])
    B = 3e-5 * normal / np.linalg.norm(normal)
    steady = in_field(B, monkeypatch, **rest)
    expected = np.linalg.norm(steady.H0) / (steady.rho * 3e-5)
    found = steady.least_time()
    assert found.least == pytest.approx(expected, abs=0.05)
    assert found.simple == pytest.approx(expected, abs=0.05)
    assert found.least <= expected + 1e-9


def test_momentum_along_a_steady_field_cannot_be_taken_out_at_all(monkeypatch):
    probe = in_field([0.0, 0.0, 3e-5], monkeypatch)
    steady = in_field(3e-5 * probe.H0 / np.linalg.norm(probe.H0), monkeypatch)
    assert steady.least_time().least is None
    wheel = abs(steady.needed(0.0)[1][0] @ steady.H0) / np.linalg.norm(steady.H0) * steady.l_max[0]
    assert steady.at(500.0).gap >= np.linalg.norm(steady.H0) - wheel - 1e-9


def test_what_a_wheel_can_keep_need_not_be_taken_out(monkeypatch):
    probe = in_field([0.0, 0.0, 3e-5], monkeypatch)
    wheel_axis = probe.needed(0.0)[1][0]
    size = np.linalg.norm(probe.H0)
    along = float(probe.H0 @ wheel_axis)
    kept = in_field([0.0, 0.0, 3e-5], monkeypatch, **{"plant.wheel_momentum_max": 1.0})
    # With any l at hand what is left is the part across the axis.
    rest = probe.H0 - along * wheel_axis
    p = kept.at(1.0)
    assert p.gap <= np.linalg.norm(rest)
    assert np.linalg.norm(rest) < size


@pytest.mark.parametrize("T", [50.0, 193.0, 400.0])
def test_no_history_of_admissible_dipoles_gives_more_than_the_bound_along_its_direction(T):
    b = balance()
    verdict = b.at(T)
    rng = np.random.default_rng(1)
    times = np.arange(0.05, T, 0.1)
    B = np.array([b.plant.field.at(t) for t in times])
    p = verdict.direction
    best = np.cross(B, p)
    best *= b.rho / np.linalg.norm(best, axis=1)[:, None]
    given = [0.1 * float(np.cross(best, B).sum(axis=0) @ p)]
    for _ in range(50):
        m = rng.standard_normal((len(times), 3))
        m *= b.rho / np.linalg.norm(m, axis=1)[:, None]
        given.append(0.1 * float(np.cross(m, B).sum(axis=0) @ p))
    assert max(given) <= verdict.impulse * (1.0 + 1e-9)
    assert given[0] == pytest.approx(
        verdict.impulse, rel=2e-3
    )  # and the bound is reached, so it is no looser than that


@pytest.mark.parametrize("which", ["no_singularity", "singularity"])
def test_a_linear_program_does_it_shortly_after_the_least_time_and_cannot_before(which):
    """Dipoles within a polyhedron inside the ball reach the end; within one that holds the ball they cannot earlier."""
    b = balance(which, 25.0)
    least = b.least_time().least
    rng = np.random.default_rng(2)
    faces = rng.standard_normal((400, 3))
    faces /= np.linalg.norm(faces, axis=1)[:, None]
    inside = 0.93  # 400 faces at this distance leave no point beyond the ball: checked below
    corners = rng.standard_normal((20000, 3))
    corners /= np.linalg.norm(corners, axis=1)[:, None]
    assert (corners @ faces.T).max(axis=1).min() >= inside
    assert reached(b, 1.15 * least, faces, inside * b.rho)
    assert not reached(b, 0.97 * least, faces, b.rho)


def reached(b, T, faces, distance, parts=25):
    edges = np.linspace(0.0, T, parts + 1)
    D, a = b.needed(T)
    columns, h = [], T / parts
    for t in edges[:-1] + 0.5 * h:
        B = b.plant.field.at(t)
        columns.append(h * np.array([[0, B[2], -B[1]], [-B[2], 0, B[0]], [B[1], -B[0], 0]]))
    A_eq = np.column_stack([*columns, *-a])  # sum of m x B h = D + l a
    n = 3 * parts
    A_ub = np.zeros((parts * len(faces), n + 1))
    for i in range(parts):
        A_ub[i * len(faces) : (i + 1) * len(faces), 3 * i : 3 * i + 3] = faces
    found = linprog(
        np.zeros(n + 1),
        A_ub=A_ub,
        b_ub=np.full(len(A_ub), distance),
        A_eq=A_eq * 1e3,
        b_eq=D * 1e3,
        bounds=[(None, None)] * n + [(-b.l_max[0], b.l_max[0])],
        method="highs",
    )
    return found.status == 0


def test_the_convex_bound_is_never_below_the_simple_one():
    for node in (0.0, 2.0, 4.0):
        found = balance(dipole_max=25.0, **{"plant.node_longitude": node}).least_time()
        assert found.least >= found.simple


def test_every_time_before_the_least_is_excluded_not_only_those_looked_at():
    b = balance(dipole_max=25.0)
    least = b.least_time().least
    for T in np.random.default_rng(3).uniform(0.1, least, 30):
        assert not b.at(float(T)).possible


@pytest.mark.parametrize("node", [0.0, 90.0, 158.0, 180.0, 270.0])
def test_the_papers_first_manoeuvre_breaks_the_balance_in_si_units(node):
    parts = loop(**{"plant.node_longitude": math.radians(node)})
    verdict = MomentumBalance(parts.plant, parts.controller, 15.0).at(193.0)
    assert verdict.gap > 0.06
    assert MomentumBalance(parts.plant, parts.controller, 15.0).H0_size == pytest.approx(0.283, abs=5e-4)


def test_a_tolerance_and_disturbances_only_loosen_the_bound():
    parts = loop()
    tight = balance(dipole_max=25.0).least_time().least
    loose = MomentumBalance(parts.plant, parts.controller, 25.0, horizon=1000.0).least_time().least
    assert tight - 30.0 < loose < tight


def test_the_integral_is_bounded_from_above_even_with_coarse_chords(monkeypatch):
    fine = balance()
    p = np.array([0.36, 0.48, 0.8])
    truth = fine.field.impulse(p, 193.4)
    monkeypatch.setattr("design.impulse.SAMPLE", 40.0 * SAMPLE)
    assert truth < balance().field.impulse(p, 193.4) < 1.1 * truth


def test_no_attitude_has_a_larger_disturbance_than_the_bound_counts_on_and_some_have_nearly_as_large_a_one():
    parts = loop(**{"plant.drag": False, "plant.gravity_gradient": True})
    found = MomentumBalance(parts.plant, parts.controller, 25.0, EXACT, 100.0)
    r, _ = parts.plant.orbit.position_velocity(0.0)
    directions = np.random.default_rng(7).standard_normal((100000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    rate = 3.0 * parts.plant.gravitational_parameter / np.linalg.norm(r) ** 3
    largest = rate * np.linalg.norm(np.cross(directions, directions @ parts.plant.body.J), axis=1).max()
    bound = (found.slack(100.0) - found.slack(0.0)) / 100.0
    assert 0.99 * bound < largest <= bound


def test_sunlight_at_any_attitude_stays_below_what_the_bound_counts_on():
    lit = {"plant.solar_pressure": True, "plant.solar_specular": 0.4, "plant.solar_diffuse": 0.5}
    bound, dark = balance(**lit), balance()
    counted = bound.slack(1.0) - dark.slack(1.0)
    light, rng = bound.plant.light, np.random.default_rng(2)
    suns = rng.normal(size=(500, 3))
    suns /= np.linalg.norm(suns, axis=1)[:, None]
    largest = max(np.linalg.norm(light.moment(s, at_distance(AU))) for s in suns)
    assert 0.01 * counted < largest < counted  # the plates are counted as if all were lit


def test_a_steady_torque_counts_with_its_size_over_the_whole_time():
    torque = {"plant.disturbance_torque_B": [1e-6, -2e-6, 2e-6]}
    with_it, without = (balance(**changes) for changes in (torque, {}))
    assert with_it.slack(500.0) - without.slack(500.0) == pytest.approx(500.0 * 3e-6, rel=1e-12)


def test_what_a_wheel_keeps_is_along_its_own_axis(monkeypatch):
    """Momentum along a steady field stays: with a wheel along it that can carry it all nothing is short, with one
    across it all is."""
    probe = in_field([0.0, 0.0, 3e-5], monkeypatch)
    R_d = probe.law.desired_attitude_0
    direction = probe.H0 / np.linalg.norm(probe.H0)
    along, across = R_d.T @ direction, R_d.T @ np.linalg.svd(direction[None])[2][1]
    size = float(np.linalg.norm(probe.H0))
    for axis, short in ((along, 0.0), (across, size)):
        changes = {"plant.wheel_axis": axis, "plant.wheel_momentum_max": 1.01 * size}
        steady = in_field(3e-5 * direction, monkeypatch, **changes)
        assert steady.at(900.0).gap == pytest.approx(short, abs=0.02 * size)
