"""A run that ends early: only what it has decided is met or failed, and its last step is in the record."""

from __future__ import annotations

import json
import signal

import numpy as np
import pytest

from ..mocks import ramp
from ..mocks import run as run_mocks

EXPECT = [
    {"name": "to the end", "signal": "a.y", "always": {"below": 100}},
    {"name": "already over", "signal": "a.y", "always": {"below": 100}, "before": 0.5},
    {"name": "violated", "signal": "a.y", "always": {"below": 0.4}},
    {"name": "happened", "signal": "a.y", "ever": {"above": 0.4}},
    {"name": "may still happen", "signal": "a.y", "ever": {"above": 3}},
    {"name": "too late for it", "signal": "a.y", "ever": {"above": 3}, "before": 0.5},
    {"name": "not begun", "signal": "a.y", "always": {"below": 100}, "after": 2},
    {"name": "no change of sign", "signal": "a.y", "zeros": 0},
]
DECIDED = ["not reached", "met", "failed", "met", "not reached", "failed", "not reached", "not reached"]


def run(end, interval=0.4, **more):
    """dy/dt = 1 for 4 s in steps of 0.1 s; in the step from 0.7 s on comes `end`."""
    block = ramp("a")
    advance = block.advance

    def ending(block, time, step):
        if end and abs(time - 0.7) < 1e-9:
            if end == "failure":
                raise block.fail("fmi2DoStep")
            signal.raise_signal(signal.SIGINT)
        advance(block, time, step)

    block.advance = ending
    return run_mocks(
        [block],
        {"step": 0.1, "duration": 4, "record": {"interval": interval}, "expect": EXPECT, **more},
        start={"a": {"u": 0}},
    )


@pytest.mark.parametrize("interval", [0.1, 0.4, 0.3])
@pytest.mark.parametrize("end", ["failure", "interrupt"])
def test_what_the_run_has_not_decided_is_not_reached(end, interval, tmp_path):
    result = run(end, interval)
    assert [outcome.status for outcome in result.outcomes] == DECIDED
    assert not result.passed
    assert [outcome.passed for outcome in result.outcomes] == [status == "met" for status in DECIDED]
    written = json.loads((result.save(tmp_path) / "expectations.json").read_text())
    assert [entry["status"] for entry in written["expectations"]] == DECIDED
    assert not written["passed"]


def test_a_whole_run_decides_all_of_them():
    statuses = [outcome.status for outcome in run(None).outcomes]
    assert statuses == ["met", "met", "failed", "met", "met", "failed", "met", "met"]


@pytest.mark.parametrize(("end", "last"), [(None, 4.0), ("interrupt", 0.8)])
def test_the_last_sample_is_the_state_in_which_the_run_ended(end, last, capsys):
    from orchestration.cli.summary import summary

    result = run(end, 0.3)
    assert result.time[-1] == result["a.y"][-1] == last
    assert result.reached == last
    np.testing.assert_array_equal(result.time[:3], [0.0, 0.3, 0.6])
    assert len(set(result.time)) == len(result.time)
    summary(result)
    assert f"{'ran' if end is None else 'interrupted after'} {last:g} s" in capsys.readouterr().out


def test_the_time_that_is_shown_is_that_of_the_steps_done_where_a_block_fails():
    from orchestration.results import report

    result = run("failure", 0.4)
    assert (result.reached, result.time[-1]) == (0.7, 0.4)
    assert "failed after 0.7 s" in report.page(result)


@pytest.mark.parametrize("compiled", [True, False])
def test_both_loops_record_the_same_end(loop, compiled):
    from orchestration import run as run_fmus

    whole = run_fmus(loop, {"duration": "1.1 s"})
    loop.write_text(loop.read_text().replace("interval: 0.1 s", "interval: 0.4 s"))
    coarse = run_fmus(loop, {"duration": "1.1 s"}, compiled=compiled)
    np.testing.assert_array_equal(coarse.time, [0.0, 0.4, 0.8, 1.1])
    for name in coarse:
        np.testing.assert_array_equal(coarse[name], whole[name][[0, 4, 8, 11]])
