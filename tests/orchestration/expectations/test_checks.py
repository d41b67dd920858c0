"""What an expectation becomes once it is held against its blocks, and what is refused with its place."""

from __future__ import annotations

import math

import pytest

from orchestration import InputError, load
from orchestration.expectations.checks import prepare
from orchestration.expectations.span import numeric
from orchestration.quantities import parse_unit
from orchestration.scenario.expectations import Bound

from ..mocks import model, real

BLOCK = model(
    "a",
    real("x", "output", unit=parse_unit("rad")),
    real("n", "output"),
    real("T", "output", unit=parse_unit("K")),
    real("w", "output", shape=(2,)),
    real("on", "output", type="boolean"),
    real("flags", "output", type="boolean", shape=(2,)),
    real("mode", "output", type="enumeration", items=(("coast", 1), ("brake", 4))),
)


def checks(*expectations, duration=None):
    entries = [{"name": f"it {i}", "signal": "a.x", **entry} for i, entry in enumerate(expectations, 1)]
    data = {"name": "s", "step": 1, "duration": 100, "blocks": {"a": {"fmu": "a"}}, "expect": entries}
    return prepare(load(data, {"duration": duration} if duration else None), {"a": BLOCK})


def one(signal="a.x", **entry):
    ((check,), notes) = checks({"signal": signal, **entry})
    assert notes == []
    return check


@pytest.mark.parametrize(
    ("entry", "low", "high", "strict", "expected"),
    [
        ({"always": {"below": 2}}, -math.inf, 2, True, "always < 2 rad"),
        ({"ever": {"above": "90 deg"}}, 90, math.inf, True, "ever > 90 deg"),
        ({"always": {"within": 2}}, -2, 2, False, "always within 2 rad"),
        ({"always": {"within": [-1, 3]}}, -1, 3, False, "always within -1 .. 3 rad"),
        ({"always": {"within": [0, "180 deg"]}}, 0, 180, False, "always within 0 .. 180 deg"),
        ({"always": {"within": ["90 deg", "2 rad"]}}, 90, 360 / math.pi, False, "always within 90 .. 114.592 deg"),
        ({"ever": {"equals": 3}, "signal": "a.n"}, 3, 3, False, "ever = 3"),
        ({"always": {"below": "26.85 degC"}, "signal": "a.T"}, -math.inf, 26.85, True, "always < 26.85 degC"),
        ({"always": {"equals": True}, "signal": "a.on"}, 1, 1, False, "always true"),
        ({"ever": {"equals": False}, "signal": "a.on"}, 0, 0, False, "ever false"),
        ({"ever": {"equals": "brake"}, "signal": "a.mode"}, 4, 4, False, "ever brake"),
        ({"zeros": 0}, 0, 0, False, "no change of sign"),
        ({"zeros": 1}, 0, 0, False, "1 change of sign"),
        ({"zeros": 2}, 0, 0, False, "2 changes of sign"),
    ],
)
def test_the_bound_is_in_its_own_unit(entry, low, high, strict, expected):
    check = one(**entry)
    assert (check.limits.low, check.limits.high) == pytest.approx((low, high), rel=1e-14)
    assert (check.limits.strict, check.expected) == (strict, expected)


@pytest.mark.parametrize(
    ("signal", "bound", "value", "same"),
    [("a.x", "2 rad", math.pi, math.pi), ("a.x", "90 deg", math.pi, 180.0), ("a.T", "20 degC", 273.15, 0.0)],
)
def test_the_signal_is_converted_to_the_bounds_unit(signal, bound, value, same):
    check = one(signal, always={"below": bound})
    assert check.limits.factor * value + check.limits.offset == pytest.approx(same, abs=1e-12)
    assert str(check.limits.unit) == bound.split()[1]


def test_what_is_looked_at_are_the_signals_elements_and_the_condition():
    check = one("a.w", always={"below": 1}, when="a.on")
    assert [str(node) for node in check.needed] == [*map(str, check.sight.nodes), str(check.sight.when)]
    assert len(check.sight.nodes) == 2
    assert one("a.w", always={"below": 1}).needed == check.sight.nodes
    assert one("a.w", always={"below": 1}).limits.number
    assert not one("a.on", always={"equals": True}).limits.number
    assert not one("a.mode", always={"equals": "coast"}).limits.number


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"name": "  "}, "expect[1].name: must not be blank"),
        ({"when": "a.n"}, "expect[1].when: expected one boolean, but a.n is a real"),
        ({"when": "a.flags"}, "expect[1].when: expected one boolean, but a.flags is a boolean [2]"),
        ({"when": "a.off"}, "expect[1].when: a has no variable 'off'; there are x"),
        ({"before": -0.5, "after": None}, "expect[1].before: expected zero or more, found -0.5 s"),
        ({"after": 101}, "expect[1].after: 101 s lies after the end of the run, 100 s"),
        ({"after": -1}, "expect[1].after: expected zero or more, found -1 s"),
        ({"before": -2}, "expect[1].before: expected zero or more, found -2 s"),
        ({"after": 3, "before": 2}, "expect[1].before: 2 s lies before 3 s, where the span begins"),
        ({"signal": "a.on", "measure": "norm"}, "expect[1].measure: a.on is boolean and has no norm"),
        ({"signal": "a.on"}, "expect[1].always.below: a.on is boolean; expected 'equals: true' or 'equals: false'"),
        (
            {"signal": "a.on", "always": {"equals": 1}},
            "expect[1].always.equals: a.on is boolean; expected 'equals: true' or 'equals: false'",
        ),
        (
            {"signal": "a.mode", "always": {"equals": "brak"}},
            "expect[1].always.equals: expected one of coast, brake, found 'brak'; did you mean 'brake'?",
        ),
        ({"always": {"equals": True}}, "expect[1].always.equals: a.x is real; expected a number, found true"),
        ({"ever": {"within": [3, 1]}, "always": None}, "expect[1].ever.within: expected [low, high], found [3, 1]"),
        (
            {"signal": "a.n", "always": {"below": "1 m"}},
            "expect[1].always.below: n has no unit, so expected a bare number, found '1 m'",
        ),
        ({"always": {"below": "1 m"}}, "expect[1].always.below: the unit 'm' does not fit that of x, rad"),
        ({"always": {"below": math.inf}}, "expect[1].always.below: expected a finite number, found inf"),
        ({"always": None, "zeros": 1, "signal": "a.w"}, "expect[1].zeros: zeros are counted of one number; a.w is"),
        ({"always": None, "zeros": 1, "signal": "a.on"}, "expect[1].zeros: zeros are counted of one number; a.on is"),
        ({"always": None, "zeros": 1, "measure": "norm"}, "expect[1].zeros: zeros are counted of one number; a.x is"),
        ({"signal": "a.y"}, "expect[1].signal: a has no variable 'y'; there are x, n"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(entry, message):
    entry = {"always": {"below": 1}, **entry}
    with pytest.raises(InputError) as error:
        checks({k: v for k, v in entry.items() if v is not None})
    assert message in str(error.value)


def test_changes_of_sign_keep_the_signals_unit():
    assert str(one(zeros=1).limits.unit) == "rad"
    assert str(one("a.n", zeros=1).limits.unit) == "1"


def test_the_ends_of_the_run_and_an_instant_are_spans():
    assert one(always={"below": 1}, after=100).expectation.after == 100
    assert one(always={"below": 1}, after=0, before=0).expectation.before == 0


def test_all_errors_are_told_and_a_name_stands_once():
    with pytest.raises(InputError) as error:
        checks({"zeros": 1, "name": "one"}, {"zeros": 2, "name": " one"}, {"zeros": 1, "after": 200})
    first, second = error.value.messages
    assert "expect[2].name: is that of expect[1], too; expected another" in first
    assert "expect[3].after" in second


def test_what_begins_after_a_run_that_an_option_shortens_is_left_out_with_a_remark():
    (check,), notes = checks({"zeros": 1, "after": 60, "name": "late"}, {"zeros": 1, "after": 50}, duration=50)
    assert check.expectation.name == "it 2"
    assert notes == ["not looked at, since the run ends before 60 s: late"]


def test_two_names_that_differ_in_their_spaces_only_are_one():
    with pytest.raises(InputError, match=r"expect\[2\].name: is that of expect\[1\], too"):
        checks({"zeros": 1, "name": "all  is well"}, {"zeros": 2, "name": "all is well"})


@pytest.mark.parametrize(
    ("own", "bound", "unit", "low", "high", "at_300"),
    [
        ("K", {"below": "20 degC"}, "degC", -math.inf, 20.0, 26.85),
        ("K", {"within": ["10 degC", "350 K"]}, "degC", 10.0, 76.85, 26.85),
        ("K", {"within": [280, 350]}, "K", 280.0, 350.0, 300.0),
        ("km", {"above": "500 m"}, "m", 500.0, math.inf, 3e5),
        ("km", {"within": [-1, "500 m"]}, "m", -1000.0, 500.0, 3e5),
    ],
)
def test_a_bound_has_one_unit_and_the_signal_is_taken_into_it(own, bound, unit, low, high, at_300):
    """Offsets and factors by hand; of a signal whose value is 300 in its own unit."""
    held = numeric("x", parse_unit(own), Bound.model_validate(bound))
    assert (str(held.unit), held.low, held.high) == (unit, pytest.approx(low), pytest.approx(high))
    assert held.factor * 300.0 + held.offset == pytest.approx(at_300)
