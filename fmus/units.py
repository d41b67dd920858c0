"""Units by their names, as FMI 2.0 declares them: integer exponents of the base units, a factor and an offset,

    value in base units = factor * value in this unit + offset

The radian counts as a base unit, as in FMI, so "rad/s" and "1/s" differ. SI units are understood here, in FMI's way of
writing (`N.m`, `m3/s2`, `kg.m2`) and in the usual other ones (`N m`, `Nm`, `N-m`, `m^2`, `m²`); any other unit is
looked up with Pint.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from typing import Any

from .unit_table import BASES, NO_UNIT, ONE_WORD, OTHER_NAMES, SI, UNITS, Exponents

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
        """Returns whether values convert into the other unit. A unit of which only the name is known fits units of that
        name."""
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


_FACTOR = re.compile(r"([^\s\d./*^\N{MIDDLE DOT}()+-]+|1)(?:(?:\^|\*\*)?(?:\(([-+]?\d+)\)|([-+]?\d+)))?")
_BETWEEN = re.compile(r"\s*(\*(?!\*)|\.|\N{MIDDLE DOT}|/|\s)\s*")
_PLAIN = {ord(sign): plain for sign, plain in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⋅", "0123456789-.", strict=True)}
_HYPHEN = re.compile(r"(?<=[^\W\d_])-(?=[^\W\d_])")
_TOKEN = re.compile(
    r"\s+|[./()\N{MIDDLE DOT}]|\*(?!\*)|(?<!.)1(?!\w)|(?<!\w)[^\W\d](?:[^\W\d]|\d{1,2}(?!\d))*|[%\N{DEGREE SIGN}]"
    r"|(?P<power>(?:(?:\^|\*\*)\s*\(?[-+]?|\(?[-+])\d{1,2}(?!\d)\)?)"
)


def _is_written_as_usual(text: str) -> bool:
    """Returns whether it holds names, products, quotients and exponents only. Pint would also compute 9**9**9**9,
    without end.
    """
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
    if text.strip() in NO_UNIT:
        return Unit(text)
    if (other := OTHER_NAMES.get(text.strip())) is not None:
        return replace(parse_unit(other), name=text)
    plain = _HYPHEN.sub(".", text.translate(_PLAIN)).strip()
    if not _is_written_as_usual(plain):
        raise QuantityError(f"unknown unit {text!r}; expected names such as N.m/s2, digits only as exponents")
    factors = _factors(plain)
    if factors is None or any(name not in UNITS for name, _ in factors):
        unit = _from_pint(text, plain, factors)
        for product in _run_together(text):
            if unit.exponents != parse_unit(product).exponents:
                read = str(_registry().Unit(text)).replace("_", " ")
                raise QuantityError(f"the unit {text!r} would be read as {read!r}; did you mean {product!r}?")
        return unit
    if len(factors) == 1 and factors[0][1] == 1:
        return Unit(text, *UNITS[factors[0][0]])
    exponents, factor = _ONE, Fraction(1)
    for name, power in factors:
        base, scale, offset = UNITS[name]
        if offset:
            raise QuantityError(f"{name!r} has an offset, so it cannot stand in the product {text!r}")
        exponents = tuple(a + power * b for a, b in zip(exponents, base, strict=True))
        factor *= _decimal(scale) ** power
    try:
        return Unit(text, exponents, float(factor))
    except OverflowError:
        raise QuantityError(f"the unit {text!r} is too large") from None


def display_factor(unit: Unit, display: Unit) -> float:
    """Returns how many display units make one unit: 57.29... for rad shown in deg. Raises QuantityError."""
    if unit.exponents is None or unit.exponents != display.exponents:
        raise QuantityError(f"{str(unit)!r} cannot be shown in {str(display)!r}: their base units differ")
    return float(_decimal(unit.factor) / _decimal(display.factor))


def _decimal(number: float) -> Fraction:
    """The decimal number that is written for a double: 1e-9 is one billionth exactly, so 1 T is 1e9 nT."""
    return Fraction(repr(number))


def _factors(text: str) -> list[tuple[str, int]] | None:
    """`mNm/(rad/s2)` as [(mN, 1), (m, 1), (rad, -1), (s, 2)]; None where the text is written otherwise."""
    factors: list[tuple[str, int]] = []
    position, sign, groups = 0, 1, [1]
    while True:
        while text.startswith("(", position):
            groups.append(sign)
            position += 1
        match = _FACTOR.match(text, position)
        power = int(match[2] or match[3] or 1) if match else 0
        if match is None or power == 0:
            return None
        *first, last = ONE_WORD.get(match[1], (match[1],))
        factors += [*((name, sign) for name in first), (last, sign * power)]
        position = match.end()
        while text.startswith(")", position) and len(groups) > 1:
            groups.pop()
            position += 1
        if position == len(text):
            return factors if len(groups) == 1 else None
        between = _BETWEEN.match(text, position)
        if between is None:
            return None
        position, sign = between.end(), groups[-1] * (-1 if between[1] == "/" else 1)


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # here, since it takes 0.3 s and few units need it  # noqa: PLC0415

    try:
        return pint.UnitRegistry(cache_folder=":auto:")
    except Exception:  # no folder to write the cache into, or a file of it that another process is just writing
        return pint.UnitRegistry()


def _meant(text: str) -> str:
    """ "; did you mean 'N.m'?" of the names of two units that are run together, of one in another case, or misspelt."""
    found = [*_run_together(text), *(name for name in UNITS if name.casefold() == text.casefold() and name != text)]
    if not found and (other := re.sub(r"[^\W\d_]+", lambda match: _in_other_case(match[0], text), text)) != text:
        found = [other]
    for name in re.findall(r"[^\W\d_]{3,}", text) if not found else ():
        turned = [known for known in UNITS if sorted(known) == sorted(name)]  # "dge" is no "dg"
        if name not in UNITS and (near := turned or get_close_matches(name, UNITS, 1, 0.7)):
            found.append(text.replace(name, near[0], 1))
    return f"; did you mean {' or '.join(map(repr, found[:3]))}?" if found else ""


def _in_other_case(name: str, text: str) -> str:
    """The unit of this name in another case; where all of the text is in capitals, "S" is taken for a second."""
    if name in UNITS and not text.isupper():
        return name
    known = [unit for unit in UNITS if unit.casefold() == name.casefold()]
    return min(known, key=lambda unit: (unit != unit.lower(), unit), default=name)


def _run_together(text: str) -> list[str]:
    """ "Nm" as ["N.m"]."""
    return [f"{text[:i]}.{text[i:]}" for i in range(1, len(text)) if text[:i] in SI and text[i:] in SI]


def _from_pint(text: str, plain: str, factors: list[tuple[str, int]] | None) -> Unit:
    expression = "*".join(f"{name}**({power})" for name, power in factors) if factors else plain
    registry = _registry()
    try:
        zero, one, two = (registry.Quantity(n, expression).to_base_units() for n in (0.0, 1.0, 2.0))
        powers = {str(base): power for base, power in one.unit_items()}
    except Exception:
        raise QuantityError(f"unknown unit {text!r}{_meant(text)}") from None
    if not math.isclose(two.magnitude - one.magnitude, one.magnitude - zero.magnitude, rel_tol=1e-9):
        raise QuantityError(f"the unit {text!r} is logarithmic; expected the number itself, in a linear unit")
    names = ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian")
    exponents = [powers.pop(name, 0) for name in names]
    if powers or any(power != int(power) for power in exponents):
        raise QuantityError(f"the unit {text!r} is not made of FMI's base units {', '.join(BASES)}")
    return Unit(text, tuple(map(int, exponents)), one.magnitude - zero.magnitude, zero.magnitude)
