"""Units by their names, as FMI 2.0 declares them: integer exponents of the base units, a factor and an offset,

    value in base units = factor * value in this unit + offset

The radian counts as a base unit, as in FMI, so "rad/s" and "1/s" differ. SI units are understood here, in FMI's way of
writing (`N.m`, `m3/s2`, `kg.m2`) and in the usual other ones (`N m`, `m^2`); any other unit is looked up with Pint.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
Exponents = tuple[int, ...]
_ONE: Exponents = (0,) * len(BASES)


class QuantityError(ValueError):
    """A text is no unit or no quantity, or a unit does not fit."""


@dataclass(frozen=True)
class Unit:
    """A unit; `exponents` is None where only its name is known."""

    name: str
    exponents: Exponents | None = _ONE
    factor: float = 1.0
    offset: float = 0.0

    def fits(self, other: Unit) -> bool:
        """Whether values convert into the other unit. A unit of which only the name is known fits units of that name."""
        if self.exponents is None or other.exponents is None:
            return self.name == other.name
        return self.exponents == other.exponents

    def conversion(self, to: Unit) -> tuple[float, float]:
        """Factor and offset that take a value in this unit into `to`; exactly (1, 0) between equal units."""
        if self.factor == to.factor and self.offset == to.offset:
            return 1.0, 0.0
        return self.factor / to.factor, (self.offset - to.offset) / to.factor

    @property
    def base_unit(self) -> dict[str, str]:
        """The attributes of the element BaseUnit, in FMI's XML as in SSP's; what has its default is left out."""
        powers = {base: str(power) for base, power in zip(BASES, self.exponents or _ONE, strict=True) if power}
        numbers = (("factor", self.factor, 1.0), ("offset", self.offset, 0.0))
        return powers | {key: repr(number) for key, number, usual in numbers if number != usual}

    @classmethod
    def from_base_unit(cls, name: str, attributes: Mapping[str, str]) -> Unit:
        """The unit with these attributes of the element BaseUnit."""
        exponents = tuple(int(attributes.get(base, "0")) for base in BASES)
        return cls(name, exponents, float(attributes.get("factor", "1")), float(attributes.get("offset", "0")))

    def __str__(self) -> str:
        return self.name or "1"


ONE = Unit("")
SECOND = Unit("s", (0, 0, 1, 0, 0, 0, 0, 0))


def _unit(exponents: str, factor: float = 1.0, offset: float = 0.0) -> tuple[Exponents, float, float]:
    powers = dict.fromkeys(BASES, 0)
    for term in exponents.split():
        base, power = re.fullmatch(r"([a-zA-Z]+)(-?\d*)", term).groups()  # type: ignore[union-attr]
        powers[base] = int(power or 1)
    return tuple(powers.values()), factor, offset


_PREFIXABLE = {
    "m": _unit("m"),
    "g": _unit("kg", 1e-3),
    "s": _unit("s"),
    "A": _unit("A"),
    "K": _unit("K"),
    "mol": _unit("mol"),
    "cd": _unit("cd"),
    "rad": _unit("rad"),
    "Hz": _unit("s-1"),
    "N": _unit("kg m s-2"),
    "Pa": _unit("kg m-1 s-2"),
    "J": _unit("kg m2 s-2"),
    "W": _unit("kg m2 s-3"),
    "C": _unit("A s"),
    "V": _unit("kg m2 s-3 A-1"),
    "F": _unit("kg-1 m-2 s4 A2"),
    "ohm": _unit("kg m2 s-3 A-2"),
    "Wb": _unit("kg m2 s-2 A-1"),
    "T": _unit("kg s-2 A-1"),
    "H": _unit("kg m2 s-2 A-2"),
}
_PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6}
_PREFIXES |= {"G": 1e9, "T": 1e12, "\N{MICRO SIGN}": 1e-6, "\N{GREEK SMALL LETTER MU}": 1e-6}
_UNITS = {
    **{prefix + name: (e, p * f, o) for prefix, p in _PREFIXES.items() for name, (e, f, o) in _PREFIXABLE.items()},
    **_PREFIXABLE,
    "1": _unit(""),
    "%": _unit("", 1e-2),
    "min": _unit("s", 60.0),
    "h": _unit("s", 3600.0),
    "d": _unit("s", 86400.0),
    "deg": _unit("rad", math.pi / 180),
    "arcmin": _unit("rad", math.pi / 10800),
    "arcsec": _unit("rad", math.pi / 648000),
    "rev": _unit("rad", 2 * math.pi),
    "rpm": _unit("rad s-1", math.pi / 30),
    "degC": _unit("K", 1.0, 273.15),
}
_SI = _PREFIXABLE.keys() | {prefix + name for prefix in _PREFIXES for name in _PREFIXABLE}
_FACTOR = re.compile(r"([^\s\d./*^\N{MIDDLE DOT}()+-]+|1)(?:(?:\^|\*\*)?\(?([-+]?\d+)\)?)?")
_BETWEEN = re.compile(r"\s*(\*(?!\*)|\.|\N{MIDDLE DOT}|/|\s)\s*")


_TOKEN = re.compile(
    r"\s+|[./()\N{MIDDLE DOT}]|\*(?!\*)|(?<!.)1(?!\w)|(?<!\w)[^\W\d](?:[^\W\d]|\d{1,2}(?!\d))*|[%\N{DEGREE SIGN}]"
    r"|(?P<power>(?:(?:\^|\*\*)\s*\(?[-+]?|\(?[-+])\d{1,2}(?!\d)\)?)"
)


def _is_written_as_usual(text: str) -> bool:
    """Whether it holds names, products, quotients and exponents only. Pint would also compute 9**9**9**9, without end."""
    position, powers = 0, 0
    while match := _TOKEN.match(text, position):
        position = match.end()
        if not match[0].isspace():
            powers = powers + 1 if match["power"] else 0
        if powers > 1:
            return False
    return position == len(text)


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """The unit of this name, from the table above or else from Pint. Raises QuantityError."""
    if not _is_written_as_usual(text):
        raise QuantityError(f"unknown unit {text!r}; expected names such as N.m/s2, digits only as exponents")
    factors = _factors(text.strip())
    if factors is None or any(name not in _UNITS for name, _ in factors):
        unit = _from_pint(text, factors)
        for product in _run_together(text):
            if unit.exponents != parse_unit(product).exponents:
                read = str(_registry().Unit(text)).replace("_", " ")
                raise QuantityError(f"the unit {text!r} would be read as {read!r}; did you mean {product!r}?")
        return unit
    if len(factors) == 1 and factors[0][1] == 1:
        return Unit(text, *_UNITS[factors[0][0]])
    exponents, factor = _ONE, Fraction(1)
    for name, power in factors:
        base, scale, offset = _UNITS[name]
        if offset:
            raise QuantityError(f"{name!r} has an offset, so it cannot stand in the product {text!r}")
        exponents = tuple(a + power * b for a, b in zip(exponents, base, strict=True))
        factor *= _decimal(scale) ** power
    try:
        return Unit(text, exponents, float(factor))
    except OverflowError:
        raise QuantityError(f"the unit {text!r} is too large") from None


def display_factor(unit: Unit, display: Unit) -> float:
    """How many of the display unit make one of the unit: 57.29... for rad shown in deg. Raises QuantityError."""
    if unit.exponents is None or unit.exponents != display.exponents:
        raise QuantityError(f"{str(unit)!r} cannot be shown in {str(display)!r}: their base units differ")
    return float(_decimal(unit.factor) / _decimal(display.factor))


def _decimal(number: float) -> Fraction:
    """The decimal number that is written for a double: 1e-9 is one billionth exactly, so 1 T is 1e9 nT."""
    return Fraction(repr(number))


def _factors(text: str) -> list[tuple[str, int]] | None:
    """`N.m/s2` as [(N, 1), (m, 1), (s, -2)]; None where the text is written otherwise."""
    factors: list[tuple[str, int]] = []
    position, sign = 0, 1
    while match := _FACTOR.match(text, position):
        factors.append((match[1], sign * int(match[2] or 1)))
        if match.end() == len(text):
            return factors
        between = _BETWEEN.match(text, match.end())
        if between is None:
            return None
        position, sign = between.end(), -1 if between[1] == "/" else 1
    return None


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # here, since it takes 0.3 s and few units need it

    try:
        return pint.UnitRegistry(cache_folder=":auto:")
    except OSError:  # no folder to write the cache into
        return pint.UnitRegistry()


def _meant(text: str) -> str:
    """ "; did you mean 'N.m'?" of the names of two units that are run together, or of one in another case."""
    found = [*_run_together(text), *(name for name in _UNITS if name.casefold() == text.casefold() and name != text)]
    return f"; did you mean {' or '.join(map(repr, found[:3]))}?" if found else ""


def _run_together(text: str) -> list[str]:
    """ "Nm" as ["N.m"]."""
    return [f"{text[:i]}.{text[i:]}" for i in range(1, len(text)) if text[:i] in _SI and text[i:] in _SI]


def _from_pint(text: str, factors: list[tuple[str, int]] | None) -> Unit:
    expression = "*".join(f"{name}**({power})" for name, power in factors) if factors else text
    registry = _registry()
    try:
        zero = registry.Quantity(0.0, expression).to_base_units()
        one = registry.Quantity(1.0, expression).to_base_units()
        powers = {str(base): power for base, power in one.unit_items()}
    except Exception:
        raise QuantityError(f"unknown unit {text!r}{_meant(text)}") from None
    names = ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian")
    exponents = [powers.pop(name, 0) for name in names]
    if powers or any(power != int(power) for power in exponents):
        raise QuantityError(f"the unit {text!r} is not made of FMI's base units {', '.join(BASES)}")
    return Unit(text, tuple(map(int, exponents)), one.magnitude - zero.magnitude, zero.magnitude)
