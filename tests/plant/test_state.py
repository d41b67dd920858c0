"""The state is all the memory there is."""

from __future__ import annotations

import dataclasses
import math
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plant
from tests.plant.motion import FULL_INERTIA, checked, command, fly

TUMBLE = {"J_B": FULL_INERTIA, "omega_B0": [0.08, -0.1, 0.07], "h_w0": 0.028, "wheel_coulomb_friction": 1e-4}
U = command([5.0, -30.0, 8.0], 2.5e-3)


def same(a, b) -> bool:
    return all(np.array_equal(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))


@pytest.mark.parametrize("order", [2, 4, 6])
def test_a_run_restored_at_half_time_ends_in_the_same_bits(order):
    changes = {**TUMBLE, "integrator_order": order, "drag": True}
    whole = fly(checked(**changes), U, 0.1, 200)
    kept = pickle.loads(pickle.dumps(whole[100]))
    assert same(fly(checked(**changes), U, 0.1, 100, kept)[-1], whole[-1])


def test_the_result_does_not_depend_on_what_was_asked_before():
    """The field's nodes are kept between calls; they are a function of the parameters alone."""
    fresh, used = checked(**TUMBLE, drag=True), checked(**TUMBLE, drag=True)
    start = plant.start(used, U)
    for t in (5000.0, 0.0, 73.0, -40.0, 123456.0, 19.95, 20.05):
        plant.step(dataclasses.replace(start, t=t), command([1.0, 2.0, 3.0]), used, 7.0)
    assert same(fly(used, U, 0.1, 300)[-1], fly(fresh, U, 0.1, 300)[-1])


def test_outputs_commit_nothing():
    p = checked(**TUMBLE)
    x = fly(p, U, 0.1, 5)[-1]
    before = pickle.dumps(x)
    first = plant.outputs(x, U, p)
    plant.outputs(x, command([9.0, 9.0, 9.0], -1e-3), p)
    assert pickle.dumps(x) == before
    assert same(plant.outputs(x, U, p), first)


def test_a_steps_outputs_are_those_of_its_state():
    p = checked(**TUMBLE)
    x, y = plant.step(plant.start(p, U), U, p, 0.3)
    assert same(plant.outputs(x, U, p), y)
    assert x.t == 0.3
    assert y.q_NB == pytest.approx(np.roll(Rotation.from_matrix(x.R).as_quat(canonical=True), 1), abs=1e-14)
    assert y.omega_B == pytest.approx(np.linalg.solve(FULL_INERTIA, x.Pi - [x.l_w[0], 0.0, 0.0]), abs=1e-16)
    assert y.h_w == x.l_w[0]
    assert y.wheel_speed == pytest.approx(x.l_w[0] / 1.47e-5)


def test_the_start_has_the_given_rate_momentum_and_attitude():
    q = np.array([0.5, -0.5, 0.1, math.sqrt(1.0 - 0.51)])
    p = checked(**TUMBLE, initial_attitude="q_NB0", q_NB0=q)
    y = plant.outputs(plant.start(p, U), U, p)
    assert y.omega_B == pytest.approx([0.08, -0.1, 0.07], abs=1e-16)
    assert y.h_w == 0.028
    assert pytest.approx(Rotation.from_quat(np.roll(q, -1)).as_matrix(), abs=1e-15) == y.R_NB


def test_thirty_milli_newton_metre_seconds_are_2041_radians_a_second():
    p = checked(h_w0=0.03)
    assert plant.outputs(plant.start(p, U), U, p).wheel_speed == pytest.approx(2041.0, abs=0.5)


def test_many_short_steps_and_few_long_ones_divide_time_alike():
    p = checked(**TUMBLE, step_max=0.1)
    many, few = fly(p, U, 0.1, 100)[-1], fly(p, U, 5.0, 2)[-1]
    assert pytest.approx(few.R, abs=1e-12) == many.R
    assert many.l_w[0] == pytest.approx(few.l_w[0], abs=1e-16)
