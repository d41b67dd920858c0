"""Expectations and holds look at every base step, however seldom it is recorded; and counts of steps have limits."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration import InputError, run
from orchestration.master import recording
from orchestration.system.clock import Clock

from ..mocks import Mock, model, ramp, real
from ..mocks import run as run_mocks

EXPECT = [
    {"name": "no spike", "signal": "a.x", "always": {"below": 0.5}},
    {"name": "a spike while on", "signal": "a.x", "when": "a.on", "ever": {"above": 0.5}},
    {"name": "crossings", "signal": "a.x", "zeros": 2},
]
HOLDS = [{"name": "commands", "signal": "a.on", "keeps": ["a.x"], "limits": {"the limit": "a.on"}}]


def spiky():
    """-1, but for 1 at the seventh step, at which `on` is true."""

    def evaluate(block):
        block["x"], block["on"] = (1.0, True) if block.state == 7 else (-1.0, False)

    def advance(block, time, step):
        block.state += 1

    return Mock("a", model("a", real("x", "output"), real("on", "output", type="boolean")), evaluate, advance, 0)


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
@pytest.mark.parametrize("rows", [1, 2, 3, 4096])
def test_a_longer_recording_interval_hides_nothing_from_expectations_and_holds(rows, exchange, monkeypatch):
    monkeypatch.setattr(recording, "ROWS", rows)
    scenario = {"step": 0.1, "duration": 2, "exchange": exchange, "expect": EXPECT, "holds": HOLDS}
    fine = run_mocks([spiky()], scenario)
    coarse = run_mocks([spiky()], {**scenario, "record": {"interval": 0.5, "signals": ["a.x"]}})
    assert (len(coarse.time), coarse["a.x"].max()) == (5, -1.0), "the spike is not recorded"
    assert coarse.outcomes == fine.outcomes
    assert coarse.holds == fine.holds
    assert coarse.highlights == fine.highlights
    assert coarse.flags == fine.flags == {"a.on": 0.7}
    assert coarse.raised == fine.raised == ["a.on from 0.7 s to 0.8 s"]
    assert [(o.passed, o.samples, o.time) for o in coarse.outcomes] == [
        (False, 21, 0.7),
        (True, 1, 0.7),
        (True, 21, 0.7),
    ]
    assert coarse.holds[0].spans == [(0.7, 0.8)]


def test_a_flag_needs_no_expectation_to_be_seen_at_every_step():
    result = run_mocks([spiky()], {"step": 0.1, "duration": 2, "record": {"interval": 0.5}})
    assert not result["a.on"].any()
    assert result.flags == {"a.on": 0.7}


@pytest.mark.parametrize(("last", "raised"), [(0.7, "a.on from 0.7 s to the end"), (0.8, "a.on from 0.7 s to 0.8 s")])
def test_a_flag_stands_to_the_end_where_the_last_step_has_it(last, raised):
    result = run_mocks([spiky()], {"step": 0.1, "duration": last, "record": {"interval": 0.1}})
    assert result.raised == [raised]
    coarse = run_mocks([spiky()], {"step": 0.1, "duration": last, "record": {"interval": 0.5}})
    assert coarse.raised == [raised]


def test_it_is_told_how_often_a_flag_was_raised():
    def evaluate(b):
        b["x"], b["on"] = 0.0, b.state % 3 == 1

    for interval in (0.1, 0.5):
        block = spiky()
        block.evaluate = evaluate
        result = run_mocks([block], {"step": 0.1, "duration": 2, "record": {"interval": interval}})
        assert result.raised == ["a.on 7 times from 0.1 s to 2 s"]  # at 0.1, 0.4, ... 1.9 s


def test_what_was_seen_up_to_a_failure_counts():
    block = spiky()
    advance = block.advance

    def failing(b, time, step):
        if time > 1.05:
            raise b.fail("fmi2DoStep")
        advance(b, time, step)

    block.advance = failing
    result = run_mocks([block], {"step": 0.1, "duration": 2, "expect": EXPECT, "record": {"interval": 0.5}})
    assert [o.samples for o in result.outcomes] == [12, 1, 12]


@pytest.mark.parametrize("fault", [0, 1])
def test_both_loops_judge_alike_where_little_is_recorded(loop, fault, monkeypatch):
    monkeypatch.setattr(recording, "ROWS", 7)
    text = loop.read_text().replace("interval: 0.1 s", "interval: 0.5 s")
    loop.write_text(text + "holds: [{name: heat, signal: motor.hot, keeps: [motor.speed]}]\n")
    overrides = {"motor.fault": fault, "motor.fault_time": 1.2}
    told = []
    for compiled in (True, False):
        try:
            result = run(loop, overrides, compiled=compiled)
        except RuntimeError as error:
            result = error.result  # type: ignore[attr-defined]
        told.append((result.outcomes, result.holds, result.highlights, result.flags, result.samples.tobytes()))
    assert told[0] == told[1]
    assert told[0][0][0].samples == (13 if fault else 21)
    fine = loop.with_name("fine.yaml")
    fine.write_text(text.replace("interval: 0.5 s", "interval: 0.1 s"))
    if not fault:
        assert run(fine, overrides).outcomes == told[0][0]


# ---------------------------------------------------------------- counts of steps


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ({"duration": "1e9 year"}, "duration: 3.15576e+16 s are more than 9e+15 steps of 0.1 s"),
        ({"duration": "1e6 year"}, "duration: the recording of 3.156e+14 samples would take"),
        ({"step": 1e-320}, "duration: 2 s are more than 9e+15 steps of 9.99989e-321 s"),
        (
            {"step": 1e-8 / 3, "duration": 1},
            "duration: a step of so many digits, 3.3333333333333334e-09 s, allows no more",
        ),
    ],
)
def test_runs_that_no_machine_could_hold_are_refused_at_once(times, message):
    with pytest.raises(InputError) as error:
        run_mocks([ramp("a")], {"step": 0.1, "duration": 2, **times}, start={"a": {"u": 0}})
    assert message in str(error.value)


@pytest.mark.parametrize(("numerator", "denominator"), [(1, 10), (3, 7), (3333333333333333, 10**16), (1, 10**320)])
def test_every_instant_is_a_multiple_of_the_step_rounded_once(numerator, denominator):
    from fractions import Fraction

    clock = Clock(numerator, denominator, 1000, 3)
    exact = [float(Fraction(n * numerator, denominator)) for n in range(0, 1001, 3)]
    np.testing.assert_array_equal(clock.sample_times(), exact)
    np.testing.assert_array_equal(clock.times(3, 333, 3), exact[1:])


# ---------------------------------------------------------------- expectations that could not fail


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"always": {"below": float("inf")}}, "expect[1].always.below: expected a finite number, found inf"),
        ({"always": {"within": "1e999 m"}}, "expect[1].always.within: expected a finite number, found 1e999 m"),
        ({"always": {"within": [float("-inf"), 1]}}, "expect[1].always.within: expected a finite number, found -inf"),
        ({"after": -1}, "expect[1].after: expected zero or more, found -1 s"),
        ({"before": -1}, "expect[1].before: expected zero or more, found -1 s"),
        ({"name": "  "}, "expect[1].name: must not be blank"),
        ({"name": "other"}, "expect[2].name: is that of expect[1], too; expected another"),
    ],
)
def test_expectations_that_could_not_fail_are_refused(changed, message):
    first = {"name": "it", "signal": "a.x", "always": {"below": 1}, **changed}
    other = {"name": "other", "signal": "a.x", "zeros": 0}
    with pytest.raises(InputError) as error:
        run_mocks([spiky()], {"step": 0.1, "duration": 2, "expect": [first, other]})
    assert message in str(error.value)
