"""Runs paced by wall time, on a clock of the test's own, so that every number is exact and nothing waits."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import chain, repeat
from time import perf_counter
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from orchestration import load
from orchestration.master.pacing import Monotonic, Pacer
from orchestration.results import lateness
from orchestration.results.report import page
from orchestration.results.result import Result
from orchestration.session.manifest import manifest
from orchestration.session.plan import plan

from ..mocks import Mock, model, ramp, real, run

SCENARIO = {"step": "10 ms", "duration": "0.1 s"}


class Clock:
    """A clock that stands still but for what is done on it.

    A sleep ends so much too late as `late` says for its end.
    """

    def __init__(self, **late: float) -> None:
        self.time, self.waits = 1000.0, []
        self.late = {round(float(due), 9): by for due, by in late.items()}

    def now(self) -> float:
        return self.time

    def sleep_until(self, due: float) -> None:
        self.waits.append(due - 1000.0)
        self.time = due + self.late.get(round(due - 1000.0, 9), 0.0)


def block(name: str, clock: Clock, takes: Callable[[float], float]) -> Mock:
    """y = t; a step that ends at t takes `takes(t)` of the clock."""

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = round(time + step, 9)
        clock.time += takes(block.state)

    def evaluate(block: Mock) -> None:
        block["y"] = block.state

    return Mock(name, model(name, real("y", "output")), evaluate, advance)


def paced(
    clock: Clock, *blocks: Mock, scenario: dict[str, Any] = SCENARIO, every: Any = None, **options: Any
) -> Result:
    return run(blocks, scenario, pacer=Pacer(timepiece=clock, **options), every=every or {})


def slow_at(instant: float, takes: float, otherwise: float = 0.001) -> Callable[[float], float]:
    return lambda time: takes if time == instant else otherwise


def test_every_step_waits_for_its_deadline_from_the_runs_begin_on():
    clock = Clock()
    result = paced(clock, block("quick", clock, lambda t: 0.003))
    assert clock.waits == pytest.approx(np.arange(1, 11) / 100)
    assert np.array(result.pace.lateness) == pytest.approx(0.0, abs=1e-9)
    assert np.array(result.pace.took) == pytest.approx(0.003)
    assert result.pace.late_steps == result.pace.overruns == 0
    assert result.pace.listed == []


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_a_run_takes_its_duration_over_the_factor(factor: float):
    clock = Clock()
    paced(clock, block("quick", clock, lambda t: 0.001), factor=factor)
    assert clock.time - 1000.0 == pytest.approx(0.1 / factor)


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_an_overrun_of_50_ms_is_reported_at_its_time_with_the_block_that_caused_it(exchange: str):
    clock = Clock()
    blocks = block("quick", clock, lambda t: 0.001), block("slow", clock, slow_at(0.03, 0.059))
    result = paced(clock, *blocks, scenario={**SCENARIO, "exchange": exchange})
    (late,) = result.pace.listed
    assert (late.time, late.block, late.overrun) == (0.03, "slow", True)
    assert (late.took, late.block_took, late.lateness) == pytest.approx((0.060, 0.059, 0.050))
    assert result.pace.overruns == 1
    assert result.pace.slowest["slow"] == (pytest.approx(0.059), 0.03)
    assert result.failure is None
    assert result.reached == 0.1
    assert "50 ms late at 0.03 s: overrun of 60 ms, of which slow took 59 ms" in page(result)


def test_steps_after_an_overrun_are_made_without_a_wait_until_the_run_is_in_time_again():
    """60 ms at 30 ms, then 2 ms a step: 50, 42, 34, 26, 18, 10, 2 ms late, and 0."""
    clock = Clock()
    result = paced(clock, block("slow", clock, slow_at(0.03, 0.06, 0.002)), tolerance=0.0025)
    assert 1e3 * np.array(result.pace.lateness) == pytest.approx([0, 0, 50, 42, 34, 26, 18, 10, 2, 0], abs=1e-6)
    assert result.pace.late_steps == 6
    assert [late.time for late in result.pace.listed] == [0.03]


def test_a_block_of_a_slower_rate_is_named_in_the_step_in_which_it_runs():
    clock = Clock()
    blocks = block("quick", clock, lambda t: 0.002), block("rare", clock, lambda t: 0.015)
    result = paced(clock, *blocks, every={"rare": 5})
    assert [(late.time, late.block) for late in result.pace.listed] == [(0.05, "rare"), (0.1, "rare")]


def test_a_late_step_ends_the_run_where_it_shall_and_names_the_block_that_took_longest():
    clock = Clock()
    blocks = block("quick", clock, lambda t: 0.001), block("slow", clock, slow_at(0.03, 0.059))
    result = paced(clock, *blocks, stop=True)
    assert result.failure is not None
    assert (result.failure.block, result.failure.time) == ("slow", 0.03)
    assert str(result.failure).startswith(
        "slow: step at 0.03 s: took 59 ms of a base step that took 60 ms and has 10 ms; "
        "the step ended 50 ms after it was due, tolerated are 2 ms; remedy: "
    )
    assert result.time.tolist() == [0.0, 0.01, 0.02, 0.03]
    assert result["slow.y"][-1] == 0.03


def test_a_lateness_within_the_tolerance_ends_no_run():
    clock = Clock()
    result = paced(clock, block("slow", clock, slow_at(0.03, 0.0119)), stop=True)
    assert result.failure is None
    assert result.pace.overruns == 1
    assert result.pace.late_steps == 0


@pytest.mark.parametrize("stop", [False, True])
def test_a_wait_that_ends_late_is_the_computers_and_no_blocks(stop: bool):
    clock = Clock(**{"0.04": 0.007})
    result = paced(clock, block("quick", clock, lambda t: 0.001), stop=stop)
    (late,) = result.pace.listed
    assert (late.time, late.block, late.overrun) == (0.04, None, False)
    assert late.lateness == pytest.approx(0.007)
    if stop:
        assert str(result.failure).startswith("master: wait at 0.04 s: the computer woke the run 7 ms after it was due")
    else:
        assert result.failure is None
        assert result.pace.overruns == 0


def test_jitter_is_the_difference_of_neighbouring_instants_from_a_step():
    clock = Clock(**{"0.04": 0.001, "0.07": 0.0015})
    pace = paced(clock, block("quick", clock, lambda t: 0.002)).pace
    assert 1e3 * pace.jitter == pytest.approx([0, 0, 0, 1, 1, 0, 1.5, 1.5, 0, 0], abs=1e-6)
    assert pace.figures["jitter"]["largest"] == pytest.approx(0.0015)
    assert pace.figures["lateness"]["p50"] == pytest.approx(0.0, abs=1e-9)


def test_long_waits_look_at_interrupts_and_an_interrupted_run_keeps_its_samples():
    clock = Clock()
    looks = []

    def keys() -> str:
        looks.append(clock.time)
        if len(looks) == 30:
            signal.raise_signal(signal.SIGINT)
        return ""

    result = paced(clock, block("quick", clock, lambda t: 0.0), keys=keys, scenario={"step": "1 s", "duration": "10 s"})
    assert result.interrupted == signal.SIGINT
    assert result.time.tolist() == [0.0, 1.0, 2.0]  # the wait for 2 s did not come to its end
    assert clock.time - 1000.0 == pytest.approx(1.5, abs=0.1)
    assert len(result.pace.lateness) == 1


def pressing(*keys: str) -> Callable[[], str]:
    """These keys, at one look at the keyboard after the other."""
    return chain(keys, repeat("")).__next__


def test_each_pause_moves_the_deadlines_that_follow_and_counts_nothing_as_late():
    clock = Clock()
    keys = pressing("", " ", "", "", " ", "", " ", "", " ")  # after the second step; three looks of 50 ms, later two
    result = paced(clock, block("quick", clock, lambda t: 0.001), keys=keys)
    assert clock.time - 1000.0 == pytest.approx(0.1 + 0.25)
    assert result.pace.paused == pytest.approx(0.25)
    assert result.pace.late_steps == 0
    assert result.pace.figures["jitter"]["largest"] == pytest.approx(0.0, abs=1e-9)


def test_a_single_step_makes_one_base_step_and_stands_again():
    clock = Clock()
    steps = []
    ends = block("quick", clock, lambda t: steps.append((t, round(clock.time - 1000.0, 6))) or 0.0)
    # Paused after the first step by s; one look later one step; another one; then on.
    result = paced(clock, ends, keys=pressing("s", "s", "", "s", "", "p"))
    assert steps[:4] == [(0.01, 0.0), (0.02, 0.06), (0.03, 0.12), (0.04, 0.18)]
    assert result.pace.single_steps == 2
    assert result.reached == 0.1


def test_a_pause_ends_with_the_run_when_it_is_interrupted():
    clock = Clock()

    def keys() -> str:
        if clock.time > 1000.2:
            signal.raise_signal(signal.SIGINT)
        return " " if clock.time < 1000.015 else ""

    result = paced(clock, block("quick", clock, lambda t: 0.0), keys=keys)
    assert result.interrupted == signal.SIGINT
    assert result.time.tolist() == [0.0, 0.01]


def test_the_results_are_those_of_the_run_that_is_not_paced():
    clock = Clock()
    given = paced(clock, ramp("a"), scenario={**SCENARIO, "connections": ["a.y -> a.u"]}, stop=True)
    free = run([ramp("a")], {**SCENARIO, "connections": ["a.y -> a.u"]})
    assert given.samples.tobytes() == free.samples.tobytes()
    assert free.pace is None


def test_the_machines_clock_sleeps_until_a_fraction_of_a_millisecond_before():
    time, slept = [5.0], []

    def now() -> float:
        time[0] += 1e-5
        return time[0]

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        time[0] += seconds + 6e-5  # as Linux does

    Monotonic(now, sleep).sleep_until(6.0)
    assert slept == [pytest.approx(1.0 - 0.2e-3, abs=2e-5)]
    assert 6.0 <= time[0] < 6.0 + 3e-5


def test_a_short_run_on_the_machines_clock_takes_its_time():
    begun = perf_counter()
    result = run([ramp("a")], {"step": "10 ms", "duration": "0.3 s", "connections": ["a.y -> a.u"]}, pacer=Pacer())
    assert perf_counter() - begun >= 0.3
    assert len(result.pace.lateness) == 30
    assert min(result.pace.lateness) >= 0.0


def test_the_manifest_has_the_counts_in_seconds():
    clock = Clock()
    result = paced(clock, block("slow", clock, slow_at(0.03, 0.06)), factor=2.0, stop=False)
    data = json.loads(json.dumps(result.pace.data()))
    assert (data["factor"], data["late"], data["tolerance"], data["period"]) == (2.0, "continue", 0.002, 0.005)
    assert data["steps"] == 10
    assert data["overruns"] == 1
    assert data["listed"][0]["block"] == "slow"
    assert data["listed"][0]["time"] == 0.03
    assert set(data["lateness"]) == {"p50", "p99", "p99.9", "largest"}
    loaded = load({"name": "test", "blocks": {"slow": {"fmu": "mock"}}, **SCENARIO})
    ready = plan(loaded, {"slow": block("slow", clock, lambda t: 0.0).model})
    known = dict.fromkeys("scenario_file options scenario parameters names order faults fmus versions platform".split())
    assert manifest(known, ready.notes, datetime.now(UTC), result)["realtime"] == result.pace.data()
    result.pace = None
    assert "realtime" not in manifest(known, ready.notes, datetime.now(UTC), result)


def test_the_histogram_counts_every_step_between_edges_of_1_2_and_5():
    values = np.array([0.0, 1.5e-6, 1.9e-6, 3e-6, 0.05])
    edges = lateness.edges(values)
    assert edges[:5] == pytest.approx([0.0, 1e-6, 2e-6, 5e-6, 1e-5])
    assert edges[-1] == pytest.approx(0.1)
    shown: list[Any] = []
    arrays = SimpleNamespace(add=lambda values: shown.append(values) or 0)
    pace = paced(
        clock := Clock(), block("quick", clock, lambda t: 0.0), scenario={**SCENARIO, "duration": "50 ms"}
    ).pace
    pace.lateness[:] = type(pace.lateness)("d", values.tolist())
    drawn = lateness.histogram(pace, arrays)
    assert len(drawn["items"]) == len(edges)
    assert drawn["range"] == [0, len(edges) - 1]
    counts = shown[-1]
    assert counts.sum() == 5
    assert counts[:4].tolist() == [1, 2, 1, 0]
    assert counts[-2:].tolist() == [1, 0]
