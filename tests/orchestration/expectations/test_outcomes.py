"""Expectations held against samples, in one piece or in several."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration import load
from orchestration.expectations.checks import prepare
from orchestration.expectations.outcomes import ExpectationObserver, highlights, not_evaluated
from orchestration.quantities import parse_unit
from orchestration.scenario.expectations import Expectation

from ..mocks import model, real


def outcome(values, bound, time=None, **more):
    """The outcome of one expectation of `a.x` (and the boolean `a.on`) on given samples."""
    values = np.atleast_2d(np.asarray(values, float).T).T
    unit = more.pop("unit", None)
    x = real("x", "output", shape=() if values.shape[1] == 1 else values.shape[1:], unit=unit)
    models = {"a": model("a", x, real("on", "output", type="boolean"))}
    expectation = {
        "name": "it",
        "signal": more.pop("signal", "a.x"),
        **bound,
        **{k: v for k, v in more.items() if k != "on"},
    }
    scenario = load({"name": "s", "step": 1, "duration": 100, "blocks": {"a": {"fmu": "a"}}, "expect": [expectation]})
    ((check,), _) = prepare(scenario, models)
    time = np.arange(float(len(values))) if time is None else np.asarray(time, float)
    columns = {node: values[:, i] for i, node in enumerate(n for n in check.sight.nodes if n.element.variable == "x")}
    on = np.asarray(more.get("on", np.ones(len(values))), float)
    columns.update((node, on) for node in check.needed if node.element.variable == "on")
    found = []
    for piece in (len(values), 1):  # in one piece or in several, the outcome is the same
        observer = ExpectationObserver(check)
        for i in range(0, len(values), piece):
            observer.see(time[i : i + piece], {node: column[i : i + piece] for node, column in columns.items()})
        found.append(observer.outcome())
    assert found[0] == found[1]
    return found[0]


@pytest.mark.parametrize(
    ("values", "bound", "found", "text"),
    [
        ([1, 2, 3], {"always": {"equals": "off"}}, "wild", "wild at 2 s"),
        ([1, 1, 1], {"always": {"equals": "off"}}, "off", "off"),
        ([1, 2, 3], {"ever": {"equals": "on"}}, "on", "on at 1 s"),
        ([1, 2, 2], {"always": {"below": 1.5}}, "on", "on at 1 s"),
        ([1, 7, 1], {"always": {"equals": "off"}}, 7, "7 at 1 s"),
        ([1, 3, 1], {"zeros": 0}, 0, "0"),
    ],
)
def test_what_an_enumeration_is_found_at_is_said_by_its_name(values, bound, found, text):
    items = (("off", 1), ("on", 2), ("wild", 3))
    models = {"a": model("a", real("mode", "output", type="enumeration", items=items))}
    expectation = {"name": "it", "signal": "a.mode", **bound}
    scenario = load({"name": "s", "step": 1, "duration": 2, "blocks": {"a": {"fmu": "a"}}, "expect": [expectation]})
    ((check,), _) = prepare(scenario, models)
    observer = ExpectationObserver(check)
    observer.see(np.arange(3.0), {check.sight.nodes[0]: np.array(values, float)})
    assert (observer.outcome().found, observer.outcome().text) == (found, text)


@pytest.mark.parametrize(
    ("values", "bound", "passed", "found", "margin", "at"),
    [
        ([1, 3, 2], {"always": {"below": 3.5}}, True, 3, 0.5, 1),
        ([1, 3, 2], {"always": {"below": 3}}, False, 3, 0, 1),
        ([1, 3, 2], {"always": {"above": 0}}, True, 1, 1, 0),
        ([1, -3, 2], {"always": {"within": 3}}, True, -3, 0, 1),
        ([1, -3, 2], {"always": {"within": [-2, 5]}}, False, -3, -1, 1),
        ([1, 3, 2], {"ever": {"above": 2.5}}, True, 3, 0.5, 1),
        ([1, 3, 2], {"ever": {"below": 0.5}}, False, 1, -0.5, 0),
        ([2, 2, 2], {"always": {"equals": 2}}, True, 2, None, 0),
        ([2, 2, 4], {"always": {"equals": 2}}, False, 4, None, 2),
        ([2, 3, 4], {"ever": {"equals": 3}}, True, 3, None, 1),
    ],
)
def test_bounds(values, bound, passed, found, margin, at):
    result = outcome(values, bound)
    assert (result.passed, result.found, result.time) == (passed, found, at)
    assert result.margin == (None if margin is None else pytest.approx(margin))


def test_always_looks_at_every_element_and_ever_wants_all_of_them_at_once():
    vectors = [[0, 5], [5, 0], [3, 3]]
    assert outcome(vectors, {"always": {"below": 5.5}}).passed
    assert not outcome(vectors, {"always": {"below": 4}}).passed
    assert outcome(vectors, {"ever": {"above": 2}}).time == 2
    assert not outcome(vectors, {"ever": {"above": 4}}).passed


def test_the_norm_is_euclidean():
    result = outcome([[3, 4], [0, 1]], {"always": {"below": 6}}, measure="norm")
    assert (result.found, result.signal) == (5.0, "|a.x|")


def test_only_samples_within_the_window_count_with_its_ends():
    values = [9, 1, 2, 9]
    assert outcome(values, {"always": {"below": 3}}, after=1, before=2).samples == 2
    assert outcome(values, {"always": {"below": 3}}, after=1, before=2).passed
    assert outcome(values, {"always": {"below": 3}}, time=[0, 0.1, 0.2, 0.30000000000000004], after=0.3).samples == 1


def test_only_samples_count_at_which_the_condition_is_true_and_there_must_be_one():
    assert outcome([9, 1, 9], {"always": {"below": 3}}, when="a.on", on=[0, 1, 0]).passed
    never = outcome([1, 1, 1], {"always": {"below": 3}}, when="a.on", on=[0, 0, 0])
    assert (never.passed, never.note, never.found) == (False, "a.on is never true", None)


def test_a_window_without_a_sample_fails():
    result = outcome([1], {"always": {"below": 3}}, after=50)
    assert (result.passed, result.note) == (False, "no sample lies in this span of time")


@pytest.mark.parametrize(
    ("values", "zeros"),
    [
        ([1, 2, 3], 0),
        ([1, -1, 1], 2),
        ([1, 0, -1], 1),
        ([1, 0, 1], 0),
        ([0, 0, 1, -1], 1),
        ([-1, 0, 0, 1], 1),
    ],
)
def test_zeros_are_changes_of_sign(values, zeros):
    result = outcome(values, {"zeros": zeros})
    assert result.passed
    assert result.found == zeros
    assert not outcome(values, {"zeros": zeros + 1}).passed


def test_what_is_always_zero_has_no_sign_that_could_change():
    result = outcome([0, 0], {"zeros": 0})
    assert (result.passed, result.found, result.note) == (False, None, "always 0, so it has no sign")


def test_values_are_told_in_the_unit_of_the_bound():
    result = outcome([0.0, np.pi / 6], {"always": {"below": "45 deg"}}, unit=parse_unit("rad"))
    assert result.found == pytest.approx(30.0)
    assert result.margin == pytest.approx(15.0)
    assert (result.unit, result.expected) == ("deg", "always < 45 deg")
    mixed = outcome([0.0, 0.5], {"always": {"within": ["-1 deg", "1 rad"]}}, unit=parse_unit("rad"))
    assert mixed.found == pytest.approx(0.0)
    assert mixed.margin == pytest.approx(1.0)


def observers(*expectations, unit=None):
    """Observers of expectations of the outputs `x` and `v` (2) of a block `a`, which runs for 100 s."""
    entries = [{"name": f"it {i}", "signal": "a.x", **entry} for i, entry in enumerate(expectations)]
    scenario = load({"name": "s", "step": 1, "duration": 100, "blocks": {"a": {"fmu": "a"}}, "expect": entries})
    on = real("on", "output", type="boolean")
    block = model("a", real("x", "output", unit=unit), real("v", "output", shape=(2,)), on)
    return [ExpectationObserver(check) for check in prepare(scenario, {"a": block})[0]]


def show(observer, values, piece=100, on=None):
    """Samples at 0 s, 1 s ...; `values` has a row for each."""
    values = np.atleast_2d(np.asarray(values, float).T).T
    columns = {node: values[:, i] for i, node in enumerate(observer.check.sight.nodes)}
    if observer.check.sight.when is not None:
        columns[observer.check.sight.when] = np.asarray(on, float)
    time = np.arange(float(len(values)))
    for i in range(0, len(time), piece):
        observer.see(time[i : i + piece], {node: column[i : i + piece] for node, column in columns.items()})
    return observer


@pytest.mark.parametrize("piece", [1, 3, 100])
def test_a_temperature_is_judged_in_the_bounds_unit_with_its_zero(piece):
    (observer,) = observers({"always": {"below": "30 degC"}}, unit=parse_unit("K"))
    result = show(observer, [273.15, 293.15, 283.15], piece).outcome()
    assert (result.found, result.margin) == pytest.approx((20.0, 10.0), abs=1e-9)
    assert observer.highlight.final == pytest.approx(10.0, abs=1e-9)
    assert (result.unit, result.text, observer.highlight.text) == ("degC", "20 degC at 1 s", "20 degC at 1 s")


@pytest.mark.parametrize("piece", [1, 2, 100])
def test_the_first_change_of_sign_is_told_with_its_time(piece):
    (observer,) = observers({"zeros": 2}, unit=parse_unit("rad"))
    result = show(observer, [0, 1, 0, -1, -2, 3, 4], piece).outcome()
    assert (result.passed, result.found, result.time, result.samples) == (True, 2.0, 3.0, 7)
    assert (result.unit, result.note, result.text) == ("", "", "2 at 3 s")


@pytest.mark.parametrize("piece", [1, 2, 100])
def test_the_peak_is_the_first_of_largest_magnitude_and_the_end_that_of_the_largest_element(piece):
    one, vector = observers({"zeros": 0}, {"always": {"below": 9}, "signal": "a.v"})
    show(one, [1, -50, 50, 2], piece)
    show(vector, [[1, -2], [0, -4], [3, -1]], piece)
    assert [(h.signal, h.final, h.peak, h.time) for h in highlights([one, vector])] == [
        ("a.x", 2.0, -50.0, 1.0),
        ("a.v", 3.0, -4.0, 1.0),
    ]
    assert one.highlight.text == "-50 at 1 s"


@pytest.mark.parametrize("piece", [1, 2, 100])
def test_a_condition_and_a_span_of_time_hold_both(piece):
    (observer,) = observers({"always": {"below": 3}, "when": "a.on", "after": 1, "before": 3})
    result = show(observer, [9, 1, 9, 2, 9], piece, on=[1, 1, 0, 1, 1]).outcome()
    assert (result.passed, result.found, result.time, result.samples) == (True, 2.0, 3.0, 2)
    (observer,) = observers({"always": {"below": 3}, "when": "a.on", "after": 1, "before": 3})
    assert show(observer, [0] * 5, piece, on=[1, 0, 0, 0, 1]).outcome().note == "a.on is never true"


@pytest.mark.parametrize("piece", [1, 100])
def test_of_equal_samples_the_first_is_told(piece):
    always, ever = observers({"always": {"below": 3}}, {"ever": {"above": 1}})
    first = show(always, [1, 2, 2], piece).outcome()
    assert (first.time, first.unit) == (1.0, "")
    assert show(ever, [1, 2, 2], piece).outcome().time == 1.0


@pytest.mark.parametrize(("values", "status"), [([1, -1, 1], "failed"), ([1, -1], "not reached"), ([1], "not reached")])
def test_a_run_that_ends_early_has_decided_only_that_there_are_too_many_changes_of_sign(values, status):
    (observer,) = observers({"zeros": 1})
    assert show(observer, values).outcome(early=True).status == status


def test_a_span_that_is_over_is_decided_whenever_the_run_ends():
    (observer,) = observers({"ever": {"above": 3}, "before": 2})
    assert show(observer, [1, 2]).outcome(early=True).status == "not reached"
    (observer,) = observers({"ever": {"above": 3}, "before": 2})
    assert show(observer, [1, 2, 2]).outcome(early=True).status == "failed"


def test_without_a_sample_nothing_is_reached():
    (observer,) = observers({"always": {"below": 3}, "before": 2})
    for early in (True, False):
        result = observer.outcome(early)
        assert (result.status, result.samples, result.found, result.passed) == ("not reached", 0, None, False)
    assert observer.highlight is None
    (zero,) = observers({"zeros": 0})
    assert (show(zero, [0, 0]).outcome().samples, zero.outcome().status) == (2, "failed")


@pytest.mark.parametrize(
    ("bound", "expected"),
    [
        ({"always": {"below": "2 deg"}}, "always below 2 deg"),
        ({"ever": {"above": 3}}, "ever above 3"),
        ({"always": {"within": ["-1 N.m", "2 N.m"]}}, "always within [-1 N.m, 2 N.m]"),
        ({"always": {"equals": False}}, "always equals false"),
        ({"ever": {"equals": "Slew"}}, "ever equals Slew"),
        ({"zeros": 0}, "no change of sign"),
        ({"zeros": 2}, "2 changes of sign"),
    ],
)
def test_an_expectation_that_cannot_be_evaluated_says_what_it_expected_and_why_it_is_not(bound, expected):
    entry = Expectation.model_validate({"name": "it", "signal": "a.x", "measure": "norm", **bound})
    result = not_evaluated(entry, "a.x is not there")
    assert (result.name, result.signal, result.expected) == ("it", "|a.x|", expected)
    assert (result.status, result.passed, result.text) == ("not evaluated", False, "a.x is not there")
    assert (result.found, result.margin, result.time, result.samples, result.unit) == (None, None, None, 0, "")
