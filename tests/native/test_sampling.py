"""`sample_period`: a block acts at its own instants, whatever the host's step, and holds in between.

The witness is the same block without a period, stepped by the host at these instants only, as `every` does.
"""

from __future__ import annotations

import math
from ctypes import byref
from itertools import accumulate

import numpy as np
import pytest

from .driver import Instance, Refused, running, same, saved

PERIOD, STEP, EVERY = 0.5, 0.1, 5
NOISE = {"rate_noise": 1e-5, "field_noise": 50e-9, "seed": 1}


def _rate(t: float) -> list[float]:
    return [math.sin(t), math.cos(3 * t), 0.1 * t]


def test_the_samples_are_those_of_a_block_that_the_host_steps_at_these_instants_only() -> None:
    with running("plant_sensors", **NOISE) as slow, running("plant_sensors", **NOISE, sample_period=PERIOD) as own:
        for k in range(1, 101):
            own.set("omega_B", _rate(k * STEP))
            own.step((k - 1) * STEP, STEP)
            if k % EVERY == 0:
                slow.set("omega_B", _rate(k * STEP))
                slow.step((k - EVERY) * STEP, PERIOD)
            assert same(own.outputs(), slow.outputs())


def test_hosts_that_multiply_and_hosts_that_add_up_see_the_same_samples() -> None:
    """0.1 added up ten thousand times ends 1.6e-10 s beside 1000 s, and meets no instant exactly."""
    n = 10_000
    with (
        running("plant_sensors", **NOISE, sample_period=PERIOD) as product,
        running("plant_sensors", **NOISE, sample_period=PERIOD) as total,
    ):
        for k, begin in enumerate([0.0, *accumulate([STEP] * (n - 1))], 1):
            for it in (product, total):
                it.set("omega_B", _rate(k * STEP))
            product.step((k - 1) * STEP, k * STEP - (k - 1) * STEP)
            total.step(begin, STEP)
            assert total.get("omega_B_measured").tolist() == product.get("omega_B_measured").tolist()
        assert begin != (n - 1) * STEP


def test_where_the_steps_miss_an_instant_the_block_acts_at_the_first_communication_point_after_it() -> None:
    step, acted, before = 0.3, [], None
    with running("controller", sample_period=PERIOD) as it:
        for k in range(1, 51):
            it.set("omega_B", [1e-3 * k, 0.0, 0.0])
            it.step((k - 1) * step, step)
            now = it.get("tau_cmd_B").tolist()
            acted += [k] if now != before else []
            before = now
    assert acted[1:] == sorted({math.ceil(i * PERIOD / step - 1e-9) for i in range(1, 31)})
    assert acted[0] == 1  # the first look


def test_between_its_instants_a_get_after_a_set_gives_what_is_held_and_at_them_the_law_of_the_new_inputs() -> None:
    with running("controller", sample_period=PERIOD) as it, running("controller") as law:
        for k in range(1, EVERY + 1):
            it.step((k - 1) * STEP, STEP)
            held = it.get("tau_cmd_B").tolist()
            it.set("omega_B", [1e-3 * k, 0.0, 0.0])
            assert (it.get("tau_cmd_B").tolist() == held) is (k < EVERY)
        law.set("omega_B", [1e-3 * (EVERY - 1), 0.0, 0.0])
        law.step(0.0, PERIOD)
        law.set("omega_B", [1e-3 * EVERY, 0.0, 0.0])
        assert same(it.outputs(), law.outputs())
        it.step(PERIOD, STEP)
        assert same(it.outputs(), law.outputs())  # what was seen last is held


def test_a_saved_state_has_the_count_of_instants_and_reset_clears_it() -> None:
    with running("plant_sensors", **NOISE, sample_period=PERIOD) as it:

        def fly(first: int, last: int) -> list[list[float]]:
            seen = []
            for k in range(first, last):
                it.step(k * STEP, STEP)
                seen.append(it.get("omega_B_measured").tolist())
            return seen

        start = fly(0, 7)
        state = saved(it)
        after = fly(7, 20)
        it.call("SetFMUstate", state)
        assert fly(7, 20) == after
        it.call("FreeFMUstate", byref(state))
        it.call("Reset")
        assert it.get("sample_period") == 0.0
        for name, value in {**NOISE, "sample_period": PERIOD}.items():
            it.set(name, value)
        it.initialize(start=100.0)  # from which the instants count
        assert [it.step(100.0 + k * STEP, STEP) or it.get("omega_B_measured").tolist() for k in range(7)] == start


def test_a_step_that_is_longer_than_the_period_is_refused() -> None:
    with running("controller", sample_period=PERIOD) as it:
        with pytest.raises(Refused, match=r"communicationStepSize.*at most sample_period"):
            it.step(0.0, 0.6)
        it.step(0.0, PERIOD)


def test_the_plant_has_no_instants_of_its_own() -> None:
    assert "sample_period" not in Instance("plant").interface.variables


def test_a_period_is_fixed_and_not_negative() -> None:
    with Instance("controller") as it:
        with pytest.raises(Refused, match="sample_period"):
            it.set("sample_period", -0.1)
        it.initialize()
        with pytest.raises(Refused, match="sample_period is a fixed parameter"):
            it.set("sample_period", 1.0)
        assert np.isfinite(it.get("tau_cmd_B")).all()
