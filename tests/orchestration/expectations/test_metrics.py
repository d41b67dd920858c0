"""Metrics of a run against closed forms, however the run is cut into pieces."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.expectations.metrics import MetricError, prepare
from orchestration.scenario.metrics import Metric
from orchestration.scenario.source import Source

from ..mocks import model, real

TIME = np.arange(5000) * 0.01
WHOLE: Any = SimpleNamespace(duration=TIME[-1], timeline=[], phases=None)
"""What a metric takes of the scenario."""


def measured(values, function=None, on=None, **entry):
    """A metric of samples of `a.x`, (n,) or (n, 2); in one piece or in several it is the same, bit for bit."""
    rows = np.atleast_2d(np.asarray(values, float).T).T
    x = real("x", "output", shape=() if rows.shape[1] == 1 else rows.shape[1:], unit=entry.pop("port", None))
    models = {"a": model("a", x, real("on", "output", type="boolean"))}
    given = {"signals": ["a.x"]} if function else {"signal": "a.x"}
    metric = Metric.model_validate({"name": "m", **given, **entry})
    measure = prepare(Source({}), ("metrics", 0), metric, models, WHOLE)
    columns = {node: rows[:, i] for i, node in enumerate(n for n in measure.needed if n.element.variable == "x")}
    columns.update((n, np.asarray(on, float)) for n in measure.needed if n.element.variable == "on")
    found = []
    for piece in (len(rows), 7, 1000):
        observer = measure.observer(function)
        for i in range(0, len(rows), piece):
            observer.see(TIME[: len(rows)][i : i + piece], {n: c[i : i + piece] for n, c in columns.items()})
        found.append(observer.value())
    assert found[0] == found[1] == found[2] or all(map(math.isnan, found))
    return found[0]


DECAY = 8.0 * np.exp(-TIME / 5.0)


def test_a_decay_settles_at_the_logarithm_of_its_ratio():
    assert measured(DECAY, settles={"below": 1.0}) == pytest.approx(5.0 * math.log(8.0), abs=0.01)
    assert measured(DECAY, reaches={"below": 4.0}) == pytest.approx(5.0 * math.log(2.0), abs=0.01)
    assert measured(DECAY, settles={"below": 1.0}, unit="min") == pytest.approx(5.0 * math.log(8.0) / 60.0, abs=2e-4)


def test_what_leaves_the_bound_again_settles_after_the_last_time():
    wave = np.where(TIME < 30.0, 0.0, DECAY) + np.where((TIME > 40.0) & (TIME < 40.055), 9.0, 0.0)
    assert measured(wave, settles={"within": 1.0}) == pytest.approx(40.06)
    assert measured(wave, reaches={"above": 8.5}) == pytest.approx(40.01)
    assert measured(wave + 9.0 * (TIME > 49.98), settles={"within": 1.0}) == math.inf
    assert measured(wave, reaches={"above": 100.0}) == math.inf
    assert measured(0.0 * wave, settles={"within": 1.0}) == 0.0


@pytest.mark.parametrize(
    ("statistic", "expected"),
    [("rms", 3.0 / math.sqrt(2.0)), ("mean", 0.0), ("peak", 3.0), ("maximum", 3.0), ("minimum", -3.0)],
)
def test_a_sine_has_its_statistics(statistic, expected):
    assert measured(3.0 * np.sin(2.0 * math.pi * TIME), statistic=statistic) == pytest.approx(expected, abs=1e-12)


def test_a_window_and_a_condition_leave_out_samples():
    on = TIME >= 25.0
    assert measured(TIME, statistic="mean", after=10, before=20) == pytest.approx(15.0)
    assert measured(TIME, statistic="minimum", when="a.on", on=on) == 25.0
    assert measured(TIME, statistic="final", before="0.5 min") == 30.0
    assert measured(TIME, share={"below": 12.5}) == 0.25
    assert measured(TIME, share={"below": 37.5}, when="a.on", on=on) == 0.5
    assert math.isnan(measured(TIME, statistic="rms", when="a.on", on=0.0 * TIME))


def test_a_norm_is_measured_as_one_number():
    circle = np.column_stack([5.0 * np.cos(TIME), 5.0 * np.sin(TIME)])
    assert measured(circle, statistic="rms", measure="norm") == pytest.approx(5.0, rel=1e-12)
    assert measured(circle, statistic="peak") == pytest.approx(5.0, rel=1e-4)
    with pytest.raises(InputError, match="measure: norm"):
        measured(circle, statistic="rms")


def test_a_metric_comes_in_the_unit_that_is_asked_for():
    turn = np.full(10, math.pi)
    angle = "rad"
    from orchestration.quantities import parse_unit

    assert measured(turn, statistic="final", unit="deg", port=parse_unit(angle)) == pytest.approx(180.0)
    assert measured(turn, settles={"below": "181 deg"}, port=parse_unit(angle)) == 0.0
    with pytest.raises(InputError, match="does not fit"):
        measured(turn, statistic="final", unit="m", port=parse_unit(angle))


def test_a_function_is_given_the_whole_run():
    def length(time, signals):
        assert time.shape == signals["a.x"].shape == TIME.shape
        return float(np.abs(np.diff(signals["a.x"])).sum())

    assert measured(np.minimum(TIME, 3.0), length, python="path:length") == pytest.approx(3.0)


class Own(BaseException):
    def __str__(self) -> str:
        sys.exit(0)


def raising(time, signals):
    raise Own


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (raising, "Own: an error without text"),
        (lambda t, s: 1 / 0, "ZeroDivisionError"),
        (lambda t, s: math.nan, "nan"),
        (lambda t, s: sys.exit(5), "SystemExit: 5"),
    ],
)
def test_a_function_that_fails_says_which(function, message):
    with pytest.raises(MetricError, match=f"m: path:length .*{message}"):
        measured(TIME, function, python="path:length")


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({}, "expected exactly one of statistic"),
        ({"statistic": "peak", "share": {"below": 1}}, "exactly one"),
        ({"statistic": "peak", "signals": ["a.x"]}, "expected 'signal'"),
        ({"statistic": "peak", "signal": None}, "'signal' is missing"),
        ({"python": "m:f", "signals": ["a.x"]}, "goes without signal"),
        ({"python": "m:f", "signal": None}, "needs 'signals'"),
    ],
)
def test_a_metric_that_is_none_is_refused(entry, message):
    with pytest.raises(ValueError, match=message):
        Metric.model_validate({"name": "m", "signal": "a.x", **entry})
