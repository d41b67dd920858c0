"""Units: our table against the SI brochure and Pint, and which units fit each other."""

from __future__ import annotations

import math

import pytest

from fmus import units
from fmus.unit_table import UNITS
from fmus.units import BASES, QuantityError, Unit, display_factor, parse_unit

BASE_UNITS = {
    "1": ({}, 1.0),
    "N.m": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "N.m.s": ({"kg": 1, "m": 2, "s": -1}, 1.0),
    "J": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "T": ({"kg": 1, "s": -2, "A": -1}, 1.0),
    "uT": ({"kg": 1, "s": -2, "A": -1}, 1e-6),
    "A.m2": ({"A": 1, "m": 2}, 1.0),
    "kg.m2": ({"kg": 1, "m": 2}, 1.0),
    "m3/s2": ({"m": 3, "s": -2}, 1.0),
    "kg/m3": ({"kg": 1, "m": -3}, 1.0),
    "m/s": ({"m": 1, "s": -1}, 1.0),
    "km": ({"m": 1}, 1000.0),
    "rad": ({"rad": 1}, 1.0),
    "rad/s": ({"rad": 1, "s": -1}, 1.0),
    "deg": ({"rad": 1}, math.pi / 180.0),
    "rpm": ({"rad": 1, "s": -1}, math.pi / 30.0),
    "mN.m": ({"kg": 1, "m": 2, "s": -2}, 1e-3),
    "Nm": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "mNm": ({"kg": 1, "m": 2, "s": -2}, 1e-3),
    "N-m": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "N\N{DOT OPERATOR}m": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "Nms": ({"kg": 1, "m": 2, "s": -1}, 1.0),
    "mNms": ({"kg": 1, "m": 2, "s": -1}, 1e-3),
    "Nm/(rad/s)": ({"kg": 1, "m": 2, "s": -1, "rad": -1}, 1.0),
    "1/Nm": ({"kg": -1, "m": -2, "s": 2}, 1.0),
    "Am2": ({"A": 1, "m": 2}, 1.0),
    "Am\N{SUPERSCRIPT TWO}": ({"A": 1, "m": 2}, 1.0),
    "A*m^2": ({"A": 1, "m": 2}, 1.0),
    "mAm2": ({"A": 1, "m": 2}, 1e-3),
    "kg m^2": ({"kg": 1, "m": 2}, 1.0),
    "kg*m2": ({"kg": 1, "m": 2}, 1.0),
    "kgm2": ({"kg": 1, "m": 2}, 1.0),
    "m^(-2)": ({"m": -2}, 1.0),
    "lbf.ft": ({"kg": 1, "m": 2, "s": -2}, 4.4482216152605 * 0.3048),
    "N.": ({"kg": 1, "m": 1, "s": -2}, 1.0),
    "s\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT ONE}": ({"s": -1}, 1.0),
    "G": ({"kg": 1, "s": -2, "A": -1}, 1e-4),
    "mG": ({"kg": 1, "s": -2, "A": -1}, 1e-7),
    "gauss": ({"kg": 1, "s": -2, "A": -1}, 1e-4),
    "nT": ({"kg": 1, "s": -2, "A": -1}, 1e-9),
    "deg/h": ({"rad": 1, "s": -1}, math.pi / 648000.0),
    "arcsec": ({"rad": 1}, math.pi / 648000.0),
    "g0": ({"m": 1, "s": -2}, 9.80665),
}
"""Exponents and factors by hand, from the SI brochure."""


@pytest.mark.parametrize("name", BASE_UNITS)
def test_a_unit_has_the_base_units_of_the_si_brochure(name: str) -> None:
    exponents, factor = BASE_UNITS[name]
    unit = parse_unit(name)
    assert {base: power for base, power in zip(BASES, unit.exponents, strict=True) if power} == exponents
    assert unit.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "name", "to", "expected"),
    [
        (20.0, "degC", "K", 293.15),
        (293.15, "K", "degC", 20.0),
        (212.0, "degF", "degC", 100.0),
        (2.5, "km", "m", 2500.0),
        (18.0, "km/h", "m/s", 5.0),
        (1.0, "rpm", "deg/s", 6.0),
    ],
)
def test_a_value_is_converted_by_factor_and_offset(name: str, to: str, value: float, expected: float) -> None:
    factor, offset = parse_unit(name).conversion(parse_unit(to))
    assert factor * value + offset == pytest.approx(expected, rel=1e-12)


def test_between_equal_units_nothing_is_converted_and_between_units_of_equal_factor_the_offset_is() -> None:
    assert parse_unit("N.m").conversion(parse_unit("J")) == (1.0, 0.0)
    assert parse_unit("K").conversion(parse_unit("degC")) == (1.0, -273.15)


@pytest.mark.parametrize("name", sorted(UNITS))
def test_a_unit_is_read_back_from_its_attributes_in_xml(name: str) -> None:
    unit = parse_unit(name)
    assert Unit.from_base_unit(name, unit.base_unit) == unit


def test_a_unit_without_a_name_is_written_1_and_one_from_pint_keeps_its_name() -> None:
    assert str(Unit("")) == "1"
    assert str(parse_unit("ft")) == "ft"


def test_a_display_unit_is_reached_by_multiplying_with_its_factor() -> None:
    assert display_factor(parse_unit("rad"), parse_unit("deg")) == 180.0 / math.pi
    assert display_factor(parse_unit("T"), parse_unit("nT")) == 1e9
    assert display_factor(parse_unit("rad/s"), parse_unit("rpm")) == pytest.approx(30.0 / math.pi, rel=1e-15)


def test_a_unit_that_is_unknown_or_does_not_fit_is_refused_by_name() -> None:
    with pytest.raises(QuantityError, match=r"'Nn\.m'"):
        parse_unit("Nn.m")
    with pytest.raises(QuantityError, match="'rad' cannot be shown in 'km'"):
        display_factor(parse_unit("rad"), parse_unit("km"))


GAUSS = {name for name, (exponents, _, _) in UNITS.items() if name.endswith(("G", "gauss"))}
NOT_PINTS = {"1", "%", "rev", "mcd"} | GAUSS
"""What Pint does not know, or reads as something else: mcd is no millicandela to it, and a gauss is of the CGS
system."""


@pytest.mark.parametrize("name", sorted(set(UNITS) - NOT_PINTS))
def test_the_table_agrees_with_pint(name: str) -> None:
    ours, theirs = parse_unit(name), units._from_pint(name, name, None)
    assert ours.exponents == theirs.exponents
    assert ours.factor == pytest.approx(theirs.factor, rel=1e-14)
    assert ours.offset == pytest.approx(theirs.offset, abs=1e-12)


def test_common_units_do_not_import_pint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("Pint was asked"))
    parse_unit.cache_clear()
    for text in (
        "s",
        "min",
        "deg",
        "deg/s",
        "km",
        "A.m2",
        "mN.m.s",
        "uT",
        "rpm",
        "kg.m2",
        "m3/s2",
        "%",
        "rad/s",
        "N m",
    ):
        parse_unit(text)


def test_a_unit_that_an_fmu_does_not_define_fits_its_namesake_only() -> None:
    bogus = Unit("clicks", None)
    assert bogus.fits(Unit("clicks", None))
    assert Unit("rad", None).fits(parse_unit("rad"))
    assert parse_unit("rad").fits(Unit("rad", None))
    assert not Unit("rad", None).fits(parse_unit("deg"))
    assert not bogus.fits(parse_unit("rad"))


def test_hertz_are_not_taken_for_radians_per_second() -> None:
    assert not parse_unit("Hz").fits(parse_unit("rad/s"))


@pytest.mark.parametrize("name", ["dB", "dBm", "dBW", "Np", "octave"])
def test_a_logarithmic_unit_is_refused_since_its_values_do_not_scale(name: str) -> None:
    with pytest.raises(QuantityError, match=f"'{name}' is logarithmic"):
        parse_unit(name)


@pytest.mark.parametrize("name", ["m0", "(N.m", "N.m)", "N.m)/s", "gm", "Pas", "^2"])
def test_what_is_no_unit_in_the_usual_way_of_writing_is_not_read_as_one(name: str) -> None:
    with pytest.raises(QuantityError):
        parse_unit(name)


@pytest.mark.parametrize("name", ["m^2^3", "m**2 **3", "9**9**9**9"])
def test_a_power_of_a_power_is_not_computed(name: str) -> None:
    with pytest.raises(QuantityError, match="expected names such as N.m/s2, digits only as exponents"):
        parse_unit(name)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("KM", "unknown unit 'KM'; did you mean 'km'?"),
        ("DEG/S", "unknown unit 'DEG/S'; did you mean 'deg/s'?"),
        ("Deg/s2", "unknown unit 'Deg/s2'; did you mean 'deg/s2'?"),
        ("n.m", "unknown unit 'n.m'; did you mean 'N.m'?"),
        ("dge/s", "unknown unit 'dge/s'; did you mean 'deg/s'?"),
        ("N.m/rda", "unknown unit 'N.m/rda'; did you mean 'N.m/rad'?"),
        ("NT", "unknown unit 'NT'; did you mean 'N.T' or 'nT'?"),
        ("gm", "unknown unit 'gm'; did you mean 'g.m' or 'Gm'?"),
        ("Pas", "the unit 'Pas' would be read as 'pascal'; did you mean 'Pa.s'?"),
        ("Newton", "unknown unit 'Newton'"),
        ("bit/s", "the unit 'bit/s' is not made of FMI's base units kg, m, s, A, K, mol, cd, rad"),
    ],
)
def test_what_is_no_unit_is_answered_with_the_units_that_may_be_meant(name: str, told: str) -> None:
    with pytest.raises(QuantityError) as error:
        parse_unit(name)
    assert str(error.value) == told


def test_a_cache_of_pint_that_another_process_is_writing_is_done_without(tmp_path, monkeypatch) -> None:
    """Pint's files are not renamed into place, so a reader may find one that is cut off."""
    for name in ("XDG_CACHE_HOME", "HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    units._registry.cache_clear()
    assert units._registry().Unit("inch")
    cached = list(tmp_path.rglob("*.pickle"))
    for path in cached:
        path.write_bytes(path.read_bytes()[:100])
    units._registry.cache_clear()
    assert units._registry().Unit("inch")
    assert cached, "Pint keeps a cache there"
