"""Units: our table against Pint, and the ways of writing them."""

from __future__ import annotations

import math

import pytest

from orchestration import quantities
from orchestration.quantities import QuantityError, convert, parse, parse_unit, value_in

RAD = parse_unit("rad")


@pytest.mark.parametrize(
    ("text", "value", "same"),
    [
        ("15 A.m2", 15.0, "A*m^2"),
        ("15 A m2", 15.0, "A.m2"),
        ("1 mN.m.s", 1e-3, "N m s"),
        ("3.986e14 m3/s2", 3.986e14, "m^3/s^2"),
        ("2 kg*m**2", 2.0, "kg.m2"),
        ("7 s-1", 7.0, "1/s"),
        ("4 N.m/(rad/s)", 4.0, "N.m.s/rad"),
        ("-2.5e-3 uT", -2.5e-9, "T"),
        ("10 mNms", 1e-2, "N.m.s"),
    ],
)
def test_units_may_be_written_in_several_ways(text, value, same):
    number, unit = parse(text)
    assert unit is not None
    assert convert(number, unit, parse_unit(same)) == pytest.approx(value, rel=1e-15)


def test_angles_are_exact_to_the_last_bit_and_own_units_untouched():
    assert value_in("98 deg", RAD) == math.radians(98)
    assert value_in("0.1 s", quantities.SECOND) == 0.1
    assert value_in(0.1, RAD) == 0.1


@pytest.mark.parametrize(("text", "meant"), [("51,6 deg", r"51\.6"), ("-0,5", r"-0\.5"), (" 1,000 km", r"1\.000")])
def test_a_decimal_comma_is_named_and_not_taken_for_a_unit(text, meant):
    with pytest.raises(QuantityError, match=f"expected a decimal point, {meant}, found a decimal comma"):
        parse(text)


def test_units_that_only_pint_knows():
    assert value_in("1 inch", parse_unit("m")) == pytest.approx(0.0254)
    assert value_in("68 degF", parse_unit("degC")) == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("value", "unit", "same", "other"),
    [(20.0, "degC", 293.15, "K"), (293.15, "K", 20.0, "degC"), (math.pi, "rad", 180.0, "deg"), (1.0, "h", 3600.0, "s")],
)
def test_conversion_is_that_of_the_si_brochure(value, unit, same, other):
    assert convert(value, parse_unit(unit), parse_unit(other)) == pytest.approx(same, rel=1e-15)


def test_a_bare_number_has_no_unit():
    assert parse("98") == (98.0, None)


def test_a_value_is_written_with_four_figures_and_without_a_blank_after_it():
    assert quantities.with_unit(0.0123456, "rad") == "0.01235 rad"
    assert quantities.with_unit(2.0, "") == "2"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("5 m", "the unit 'm' does not fit 'rad'"),
        ("fast", "expected a number with a unit such as '98 deg', found 'fast'"),
        (10**400, "expected a number below 1.8e308, found a larger one"),
        (True, "expected a number or text with a unit, found true"),
        ([1.0], "expected a number or text with a unit, found a list"),
        (math.inf, "expected a finite number, found inf"),
    ],
)
def test_a_value_that_is_no_angle_is_told_with_what_was_expected(value, message):
    with pytest.raises(QuantityError) as error:
        value_in(value, RAD)
    assert str(error.value) == message


@pytest.mark.parametrize("text", ["abc", "", "1 xyz", "3 bit", "nan rad", "1e999 rad", "5 m"])
def test_what_is_no_angle_is_refused(text):
    with pytest.raises(QuantityError):
        value_in(text, RAD)
