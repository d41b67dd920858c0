"""Runs of the manoeuvres through the native FMUs: their figures against the blocks' own functions, sample by sample."""

import math
from dataclasses import fields

import numpy as np
import pytest

from allocator.allocation import Singular, allocate
from studies.paper import SCENARIOS, node
from studies.reproduction.runs import run, sweep
from studies.reproduction.seen import Seen, of_run, together
from studies.setup import read
from tests.studies.reproduction import flown

DURATION = 12.0
"""s: V.C's hold begins and ends in it."""


@pytest.fixture(scope="module")
def alone():
    loop = read(SCENARIOS["V.C"]).loop.change({"plant.integrator_order": 2})
    return loop, flown.fly(loop, 0.1, DURATION)


def test_the_figures_of_a_swept_run_are_those_of_the_blocks_own_signals(alone):
    loop, samples = alone
    found = {f.name: float(getattr(sweep("V.C", [{}], duration=DURATION), f.name)[0]) for f in fields(Seen)}
    held = [i for i, (_, _, a) in enumerate(samples) if a.holding]
    demands = []
    for i in held:
        p, c, _ = samples[i]
        try:
            demands.append(np.abs(allocate(c.tau_cmd_B, p.b_B, p.omega_B, p.h_w, loop.allocator.U)[0]).max())
        except Singular:
            continue
    b = np.array([a.b_wheel for _, _, a in samples])
    expected = {
        "held": 0.1 * held[0],
        "hold_ends": 0.1 * (held[-1] + 1),
        "hold_longest": 0.1 * len(held),
        "holds": 1.0,
        "held_at_zero": 0.0,
        "held_command": float(np.linalg.norm(samples[held[0]][2].dipole_cmd)),
        "hold_by_rod": max(demands) / loop.allocator.dipole_max,
        "dipole": max(np.abs(p.dipole).max() for p, _, _ in samples),
        "wheel_momentum": max(abs(p.h_w) for p, _, _ in samples),
        "torque": max(float(np.linalg.norm(c.tau_cmd_B)) for _, c, _ in samples),
        "attitude_error": samples[-1][1].attitude_error,
        "b_wheel": np.abs(b).min(),
        "crossings": float((np.sign(b[1:]) != np.sign(b[:-1])).sum()),
        "crossed": 0.1 * (int(np.flatnonzero(np.sign(b) != np.sign(b[0]))[0])),
        "latched": 0.0,
        "saturated": 0.0,
        "settled": math.nan,  # 12 s are too short
        "wheel_at_limit_since": math.nan,
    }
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-7, nan_ok=True), name


def test_a_sweep_flies_each_change_alone():
    changes = [node(158.0), node(200.0)]
    both = sweep("V.C", changes, duration=DURATION)
    for i, change in enumerate(changes):
        one = sweep("V.C", [change], duration=DURATION)
        for f in fields(Seen):
            np.testing.assert_array_equal(getattr(both, f.name)[i], getattr(one, f.name)[0], err_msg=f.name)
    assert both.latched.tolist() == [0.0, 1.0]  # 200 deg E latches, as docs/reproduction.md shows


def test_a_run_reports_the_hold_in_words_and_shows_the_same_in_numbers():
    hold = run("V.C", duration=DURATION)
    assert hold.hold == "running values held from 0.1 s to 0.6 s, then released"
    assert (hold.seen.held[0], hold.seen.hold_ends[0]) == pytest.approx((0.1, 0.6))


def signals(n, **changed):
    """Signals of n quiet samples."""
    zero, vector = np.zeros(n), np.zeros((n, 3))
    quiet = {
        "attitude_error": zero,
        "rate_error_B": vector,
        "tau_cmd_B": vector,
        "dipole": vector,
        "dipole_cmd": vector,
        "unheld_dipole_cmd": vector,
        "wheel_torque_cmd": zero,
        "holding": zero,
        "h_w": zero,
        "b_wheel": zero + 0.5,
        "dipole_saturated": vector,
        "wheel_momentum_saturated": zero,
    }
    return quiet | {name: np.asarray(value, float) for name, value in changed.items()}


def test_holds_are_counted_and_the_last_may_last_to_the_end():
    time = 0.1 * np.arange(8)
    command = np.array([[1.0, 0, 0], [3, 0, 0], [2, 0, 0], [9, 0, 0], [4, 0, 0], [4, 0, 0], [4, 0, 0], [4, 0, 0]])
    of = of_run(
        time, signals(8, holding=[0, 1, 1, 0, 0, 1, 1, 1], dipole_cmd=command, unheld_dipole_cmd=10 * command), 20.0
    )
    assert (of["held"], of["holds"], of["latched"]) == pytest.approx((0.1, 2.0, 1.0))
    assert (of["held_command"], of["hold_by_rod"]) == (2.0, 2.0)
    assert of["hold_longest"] == pytest.approx(0.2)
    assert math.isnan(of["hold_ends"])
    zero = of_run(time, signals(8, holding=[1, 1, 0, 0, 0, 0, 0, 0]), 20.0)
    assert (zero["held"], zero["held_at_zero"], zero["latched"]) == (0.0, 1.0, 0.0)
    assert zero["hold_ends"] == pytest.approx(0.2)
    assert together([of, zero]).holds.tolist() == [2.0, 1.0]


@pytest.mark.parametrize(
    ("holding", "longest"),
    [
        ([0, 1, 0, 1, 1, 1, 0, 1, 1, 0], 0.3),  # neither the first nor the last nor their sum
        ([1, 1, 1, 1, 0, 1, 0, 1, 1, 0], 0.4),
        ([0, 1, 0, 1, 1, 0, 1, 1, 1, 1], 0.3),  # latched: from 0.6 s to the last sample, at 0.9 s
        ([0] * 10, 0.0),
    ],
)
def test_the_longest_hold_is_counted_by_hand(holding, longest):
    of = of_run(0.1 * np.arange(10), signals(10, holding=holding), 20.0)
    assert of["hold_longest"] == pytest.approx(longest)


def test_a_crossing_of_zero_is_seen_through_a_sample_of_zero():
    time = 0.1 * np.arange(6)
    of = of_run(time, signals(6, b_wheel=[0.2, 0.0, -0.1, -0.2, 0.1, 0.0]), 20.0)
    assert of["crossings"] == 2
    assert of["crossed"] == pytest.approx(0.2)
    assert of["b_wheel"] == 0.0


def test_the_wheel_is_at_its_limit_since_the_last_time_that_it_got_there():
    of = of_run(0.1 * np.arange(5), signals(5, wheel_momentum_saturated=[0, 1, 0, 1, 1]), 20.0)
    assert of["wheel_at_limit_since"] == pytest.approx(0.3)
