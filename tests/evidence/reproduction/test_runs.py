"""Runs of the manoeuvres through the native FMUs: their figures against the blocks' own functions, sample by sample."""

import math
from dataclasses import fields

import numpy as np
import pytest

from allocator.allocation import Singular, allocate
from design.loop import read
from evidence.crew import crew
from evidence.paper import SCENARIOS, constants, node
from evidence.reproduction import metrics
from evidence.reproduction.runs import run, sweep
from evidence.reproduction.seen import Seen, seen
from tests.evidence.reproduction import flown

DURATION = 12.0
"""s: V.C's hold begins and ends in it."""


def fly(changes, folder):
    with crew(0) as hands:
        return sweep(hands, "few", "V.C", changes, duration=DURATION, results=folder)


@pytest.fixture(scope="module")
def alone():
    loop = read(SCENARIOS["V.C"]).loop.change({"plant.integrator_order": 2})
    return loop, flown.fly(loop, 0.1, DURATION)


def test_the_figures_of_a_swept_run_are_those_of_the_blocks_own_signals(alone, tmp_path):
    loop, samples = alone
    swept = fly([{}], tmp_path)
    found = {f.name: float(getattr(swept, f.name)[0]) for f in fields(Seen)}
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


def test_a_sweep_flies_each_change_alone(tmp_path):
    changes = [node(158.0) | constants(k=0.65), node(200.0) | constants(k=0.6)]
    both = fly(changes, tmp_path)
    for i, change in enumerate(changes):
        one = fly([change], tmp_path)
        for f in fields(Seen):
            np.testing.assert_array_equal(getattr(both, f.name)[i], getattr(one, f.name)[0], err_msg=f.name)
    assert both.latched.tolist() == [0.0, 1.0]  # 200 deg E latches, as docs/evidence/reproduction.md shows


def test_a_sweep_goes_through_texts_as_through_numbers(tmp_path):
    years = [{"plant.epoch": f"{year}-08-10T00:00:00Z"} for year in (2005, 2015)]
    both = fly(years, tmp_path)
    for i, year in enumerate(years):
        assert both.torque[i] == fly([year], tmp_path).torque[0]
    assert both.dipole[0] != both.dipole[1]


def test_a_run_reports_the_hold_in_words_and_shows_the_same_in_numbers():
    hold = run("V.C", duration=DURATION)
    assert hold.hold == "running values held from 0.1 s to 0.6 s, then released"
    assert (hold.seen.held[0], hold.seen.hold_ends[0]) == pytest.approx((0.1, 0.6))


def of(name, time, **signals):
    """A metric of made-up signals."""
    blocks = {"unheld_dipole_cmd": "unheld.dipole_cmd"}
    return getattr(metrics, name)(
        time, {blocks.get(k, f"allocator.{k}"): np.asarray(v, float) for k, v in signals.items()}
    )


def test_holds_are_counted_and_the_last_may_last_to_the_end():
    time = 0.1 * np.arange(8)
    command = np.array([[1.0, 0, 0], [3, 0, 0], [2, 0, 0], [9, 0, 0], [4, 0, 0], [4, 0, 0], [4, 0, 0], [4, 0, 0]])
    holding = [0, 1, 1, 0, 0, 1, 1, 1]
    assert of("held", time, holding=holding) == pytest.approx(0.1)
    assert of("holds", time, holding=holding) == 2.0
    assert of("held_command", time, holding=holding, dipole_cmd=command) == 2.0
    assert of("held_demand", time, holding=holding, unheld_dipole_cmd=-10 * command) == 40.0
    assert of("hold_ends", time, holding=holding) == math.inf
    zero = [1, 1, 0, 0, 0, 0, 0, 0]
    quiet = {"dipole_cmd": np.zeros((8, 3)), "wheel_torque_cmd": np.zeros(8)}
    assert of("held_at_zero", time, holding=zero, **quiet) == 1.0
    assert of("held_at_zero", time, holding=holding, **quiet | {"dipole_cmd": command}) == 0.0
    assert of("held_at_zero", time, holding=zero, **quiet | {"wheel_torque_cmd": np.ones(8)}) == 0.0
    assert of("held", time, holding=zero) == 0.0
    assert of("hold_ends", time, holding=zero) == pytest.approx(0.2)


def test_without_a_hold_none_begins_ends_or_demands():
    time, never = 0.1 * np.arange(8), np.zeros(8)
    assert [of(name, time, holding=never) for name in ("held", "hold_ends", "holds")] == [math.inf, math.inf, 0.0]
    assert of("held_command", time, holding=never, dipole_cmd=np.ones((8, 3))) == math.inf
    assert of("held_demand", time, holding=never, unheld_dipole_cmd=np.ones((8, 3))) == 0.0


def test_a_crossing_of_zero_is_seen_through_a_sample_of_zero():
    time, b = 0.1 * np.arange(6), [0.2, 0.0, -0.1, -0.2, 0.1, 0.0]
    assert of("crossings", time, b_wheel=b) == 2
    assert of("crossed", time, b_wheel=b) == pytest.approx(0.2)
    assert of("b_wheel", time, b_wheel=b) == 0.0
    assert of("crossed", time, b_wheel=np.ones(6)) == math.inf


def test_times_of_what_never_happened_are_nan_and_both_errors_have_to_settle():
    found = {
        name: np.array([1.0, math.inf]) for name in ("angle", "crossed", "held", "hold_ends", "wheel_at_limit_since")
    }
    seen_ = seen(lambda name: found.get(name, np.array([2.0, 3.0])), 20.0)
    assert seen_.settled == pytest.approx([2.0, math.nan], nan_ok=True)
    for name in ("crossed", "held", "hold_ends", "wheel_at_limit_since"):
        assert getattr(seen_, name) == pytest.approx([1.0, math.nan], nan_ok=True)
    assert seen_.hold_by_rod.tolist() == [0.1, 0.15]
