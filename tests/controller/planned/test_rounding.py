"""Rounding of the master's time: a sample acts at the same step however times and steps are rounded, and what it
moves."""

import math
from itertools import accumulate, pairwise

import numpy as np
import pytest

import orchestration
from tests.native.driver import Instance

from .block import feed, near_target, same
from .core import ROOT
from .rounding import apart, flight


def by_multiplication(h, n):
    return [i * h for i in range(n + 1)], [h] * n


def by_sums(h, n):
    times = list(accumulate([h] * n, initial=0.0))
    return times, [h] * n


def by_differences(h, n):
    """A master that counts in multiplications, and steps from one to the next."""
    times = [i * h for i in range(n + 1)]
    return times, [b - a for a, b in pairwise(times)]


MASTERS = {
    "multiplication": by_multiplication,
    "sums": by_sums,
    "differences": by_differences,
    "a step 1e-15 longer": lambda h, n: by_multiplication(h * (1.0 + 1e-15), n),
    "a step 1e-15 shorter": lambda h, n: by_multiplication(h * (1.0 - 1e-15), n),
    "sums of a step 1e-15 longer": lambda h, n: by_sums(h * (1.0 + 1e-15), n),
}


def acting(it, inputs, times, steps):
    """Numbers of the steps at which an output changes; the inputs change at every step."""
    found, before = [], it.outputs()
    for i, h in enumerate(steps):
        feed(it, inputs(i + 1))
        it.step(times[i], h)
        now = it.outputs()
        if not same(now, before):
            found.append(i + 1)
        before = now
    return found


@pytest.mark.parametrize("master", MASTERS)
@pytest.mark.parametrize(("h", "period"), [(0.1, 0.5), (0.1, 0.3), (0.05, 0.5), (1.0 / 30.0, 0.1), (0.7, 0.7)])
@pytest.mark.thorough
def test_each_sample_acts_at_the_same_step_whatever_the_rounding_of_the_master_s_time(master, h, period):
    """The time of sums drifts by many times the rounding that a comparison without tolerance bears."""
    every, n = round(period / h), 90
    with Instance("controller_planned") as it:
        feed(it, {"control_period": period, "plan_period": 1000.0, **near_target(0.0)})
        it.initialize()
        assert acting(it, lambda i: near_target(i * h), *MASTERS[master](h, n)) == list(range(every, n + 1, every))


@pytest.mark.parametrize("master", MASTERS)
@pytest.mark.parametrize(("h", "period"), [(0.1, 0.5), (0.1, 0.3), (1.0 / 30.0, 0.1), (0.7, 0.7)])
def test_each_measurement_is_taken_at_the_same_step_whatever_the_rounding_of_the_master_s_time(master, h, period):
    every, n = round(period / h), 210
    with Instance("plant_sensors") as it:
        it.set("sensor_period", period)
        it.initialize()
        inputs = ({"h_w": 1e-3 * math.sin(i)} for i in range(1, n + 1))
        assert acting(it, lambda _: next(inputs), *MASTERS[master](h, n)) == list(range(every, n + 1, every))


def test_of_a_step_1e_15_longer_the_manoeuvre_s_plans_keep_their_times_and_their_cost_to_1e_6():
    """The times of new plans are the same, so what is left is the rounding that the optimiser amplifies."""
    scenario = orchestration.load(ROOT / "scenarios" / "flight_vb.yaml").source.data
    a, b = (flight(scenario, 0.1 * factor, 6000) for factor in (1.0, 1.0 + 1e-15))
    assert np.array_equal(np.diff(a["controller.plan_cost"]) != 0.0, np.diff(b["controller.plan_cost"]) != 0.0)
    assert np.array_equal(a["controller.phase"], b["controller.phase"])
    moved = apart(a, b)
    assert 0.0 < moved.cost < 1e-6
    assert moved.attitude < 1e-10
