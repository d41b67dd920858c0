"""Rods that give another dipole than commanded, and rods that take turns with the magnetometer."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import plant
from evidence.verification.rk4 import angle_between, environment, pack, truth
from plant.geomagnetic import FieldAlongOrbit
from tests.native.driver import Instance
from tests.plant import manoeuvre
from tests.plant.motion import FULL_INERTIA, checked, command, fly, measured_order

FIELD_N = np.array([1.3e-5, -2.1e-5, 3.4e-5])
HEAVY = {"J_B": 1e12 * np.eye(3), "gravity_gradient": False, "omega_B0": [0.0, 0.0, 0.0], "dipole_max": 500.0}
"""A body that rods do not turn: then the moment is constant in a constant field."""


@pytest.fixture
def constant_field(monkeypatch):
    monkeypatch.setattr(FieldAlongOrbit, "at", lambda field, t: FIELD_N)


def same(a, b) -> bool:
    return all(np.array_equal(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))


def test_a_rod_gives_its_gain_times_the_command_within_its_limit():
    p = checked(rod_gain=[0.9, 1.1, 0.0])
    u = command([10.0, -90.0, 25.0])
    y = plant.outputs(plant.start(p, u), u, p)
    assert y.dipole == pytest.approx([9.0, -27.5, 0.0], rel=1e-15)
    by_rods = sum(m * np.cross(axis, y.b_B) for m, axis in zip([9.0, -27.5, 0.0], p.rod_axes, strict=True))
    assert y.tau_mag_B == pytest.approx(by_rods, rel=1e-12)
    assert y.dipole_saturated


def test_saturation_is_told_of_the_command_whatever_the_gain():
    assert not plant.outputs(*_at(checked(rod_gain=[2.0, 2.0, 2.0]), [20.0, 0.0, 0.0])).dipole_saturated


def _at(p, dipole, t=0.0):
    u = command(dipole)
    return dataclasses.replace(plant.start(p, u), t=t), u, p


def test_a_gain_acts_on_the_motion_as_that_much_more_command():
    told = fly(checked(rod_gain=[0.5, 2.0, 0.25]), command([8.0, 3.0, -12.0]), 0.5, 4)[-1]
    done = fly(checked(), command([4.0, 6.0, -3.0]), 0.5, 4)[-1]
    assert same(told, done)


@pytest.mark.parametrize(
    ("t", "on"),
    [(0.0, True), (0.69, True), (0.7, False), (0.99, False), (1.0, True), (41.6999, True), (41.7, False), (42.0, True)],
)
def test_the_dipole_is_that_of_the_instant(t, on):
    y = plant.outputs(
        *_at(checked(rod_period=1.0, rod_duty=0.7, residual_dipole_B=[0.1, 0.2, -0.3]), [9.0, -5.0, 2.0], t)
    )
    assert y.dipole.tolist() == ([9.0, -5.0, 2.0] if on else [0.0, 0.0, 0.0])
    if not on:
        assert y.tau_mag_B == pytest.approx(np.cross([0.1, 0.2, -0.3], y.b_B), rel=1e-15)


@pytest.mark.parametrize(("h", "n"), [(0.1, 120), (0.13, 100), (12.0, 1), (1.7, 10), (0.999, 20)])
@pytest.mark.parametrize(("period", "duty"), [(1.0, 0.7), (0.37, 0.123), (3.0, 0.5), (5.0, 0.999)])
def test_the_impulse_is_the_moment_times_the_time_that_the_rods_were_on(constant_field, h, n, period, duty):
    p = checked(**HEAVY, rod_period=period, rod_duty=duty)
    dipole = [400.0, -300.0, 250.0]
    x = fly(p, command(dipole), h, n)[-1]
    periods = math.floor(n * h / period + 1e-9)
    on = periods * duty * period + min(n * h - periods * period, duty * period)
    moment_N = np.cross(p.R_NB0 @ p.rods_to_body @ dipole, FIELD_N)
    impulse = x.R @ x.Pi
    assert (
        np.linalg.norm(impulse - on * moment_N)
        < 1e-12 * np.linalg.norm(on * moment_N) + 1e-9 * np.linalg.norm(moment_N) * period
    )
    assert np.linalg.norm(moment_N) > 5e-3


def test_over_whole_periods_the_mean_moment_is_the_duty_times_the_moment(constant_field):
    dipole = command([400.0, -300.0, 250.0])
    always = fly(checked(**HEAVY), dipole, 0.1, 200)[-1]
    turns = fly(checked(**HEAVY, rod_period=1.0, rod_duty=0.7), dipole, 0.1, 200)[-1]
    assert turns.Pi == pytest.approx(0.7 * always.Pi, rel=1e-10)


def test_no_turns_and_whole_turns_are_the_rods_always_on_to_the_bit():
    changes = {"J_B": FULL_INERTIA, "omega_B0": [0.05, 0.02, -0.03]}
    u = command([5.0, -30.0, 8.0], 1e-3)
    plain = fly(checked(**changes), u, 0.17, 30)[-1]
    for turns in ({"rod_duty": 0.3}, {"rod_period": 0.1, "rod_duty": 1.0}):
        assert same(fly(checked(**changes, **turns), u, 0.17, 30)[-1], plain)
    never = fly(checked(**changes, rod_period=0.1, rod_duty=0.0), u, 0.17, 30)[-1]
    assert same(never, fly(checked(**changes, dipole_max=0.0), u, 0.17, 30)[-1])


def test_the_communication_step_may_be_any():
    changes = {
        "J_B": FULL_INERTIA,
        "omega_B0": [0.05, 0.02, -0.03],
        "rod_period": 0.9,
        "rod_duty": 0.61,
        "step_max": 0.05,
    }
    u = command([20.0, -24.0, 8.0], 1e-3)
    ends = [fly(checked(**changes), u, h, n)[-1] for h, n in ((0.1, 70), (7.0, 1), (0.35, 20))]
    for x in ends[1:]:
        assert pytest.approx(ends[0].R, abs=1e-9) == x.R
        assert x.Pi == pytest.approx(ends[0].Pi, abs=1e-9)


TURNS = {"rod_period": 7.3, "rod_duty": 0.37}


def true_end(p) -> np.ndarray:
    """The manoeuvre's end by DOP853, restarted at each switching instant."""
    y = pack(p.R_NB0, p.omega_B0, p.h_w0)
    end = manoeuvre.PERIOD * len(manoeuvre.COMMANDS)
    cycles = np.arange(math.ceil(end / p.rod_period))[:, None] * p.rod_period + [0.0, p.rod_duty * p.rod_period]
    breaks = sorted({*cycles.ravel().tolist(), *(manoeuvre.PERIOD * i for i in range(len(manoeuvre.COMMANDS)))})
    for t0, t1 in zip(breaks, [*breaks[1:], end], strict=True):
        if t0 >= end:
            break
        dipole, torque = manoeuvre.COMMANDS[int(t0 / manoeuvre.PERIOD + 1e-9)]
        on = (0.5 * (t0 + min(t1, end)) / p.rod_period) % 1.0 < p.rod_duty
        moment = environment(p, p.rods_to_body @ np.array(dipole) * on + p.residual_dipole_B)
        y = truth(y, t0, min(t1, end), p.J_B, moment, lambda l_w, torque=torque: torque)
    return y


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_integrators_order_holds_across_the_switching_instants(order):
    """Which lie in the midst of its steps: a step across one would leave order 1."""
    y = true_end(manoeuvre.parameters(order, 1.0, **TURNS))
    errors = {}
    for step in manoeuvre.STEPS[order]:
        p = manoeuvre.parameters(order, step, **TURNS)
        errors[step] = manoeuvre.error(manoeuvre.flown(p), p, y)
    assert min(errors.values()) < {2: 2e-4, 4: 5e-8, 6: 3e-10}[order]
    assert measured_order(errors) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("turns", [TURNS, {"rod_period": 1.0, "rod_duty": 0.0}], ids=["in turns", "always off"])
def test_the_satellites_own_dipole_turns_it_while_the_rods_are_off_too(turns):
    """Both flavours against DOP853; without the dipole's torque in the time that the rods are off the end is
    elsewhere."""
    p = manoeuvre.parameters(6, 0.25, **turns, residual_dipole_B=[120.0, -160.0, 200.0])
    y = true_end(p)
    assert manoeuvre.error(manoeuvre.flown(p), p, y) < 1e-9
    with Instance("plant") as it:
        it.set_all(p)
        it.initialize()
        for i, (dipole, torque) in enumerate(manoeuvre.COMMANDS):
            it.set("dipole_cmd", dipole)
            it.set("wheel_torque_cmd", torque)
            it.step(i * manoeuvre.PERIOD, manoeuvre.PERIOD)
        assert angle_between(it.get("R_NB"), y[:9].reshape(3, 3)) < 1e-9
        assert it.get("omega_B") == pytest.approx(y[9:12], abs=1e-9)


def test_steps_that_fit_the_turns_are_not_cut_by_rounding():
    turns = checked(rod_period=1.0, rod_duty=0.7).rod_turns
    t, on = 0.0, 0
    for _ in range(10000):
        ((duration, is_on),) = turns.parts(t, 0.1)
        assert duration == 0.1
        on += is_on
        t += 0.1
    assert on == 7000


def test_more_than_a_million_periods_in_a_step_are_refused():
    p = checked(rod_period=1e-3, rod_duty=0.5, step_max=1e4)
    with pytest.raises(ValueError, match=r"rod_period: expected at least a millionth .* 1001.0 s, found 0.001 s"):
        plant.step(plant.start(p, command()), command(), p, 1001.0)


def test_many_steps_added_up_end_on_the_instants_at_which_rods_switch():
    with Instance("plant") as it:
        for name, value in {"rod_period": 0.5, "rod_duty": 0.8, "dipole_cmd": [1.0, 2.0, 3.0]}.items():
            it.set(name, value)
        it.initialize()
        time, step = 0.0, 0.1
        told = []
        for count in range(1, 60001):
            it.step(time, step)
            time += step
            told.append(it.get("dipole")[0] > 0.0 if count % 5 in (0, 4) else None)
    assert all(on for on in told[4::5])
    assert not any(on for on in told[3::5])
