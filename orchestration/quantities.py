"""Quantities: text such as "98 deg" or "15 A.m2", and the conversion from one unit to another."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from fmus.units import BASES, ONE, SECOND, Exponents, QuantityError, Unit, parse_unit

from .errors import as_written

__all__ = ["BASES", "ONE", "SECOND", "Exponents", "QuantityError", "Unit"]
__all__ += ["Quantity", "convert", "convert_difference", "parse", "parse_unit", "real", "shown", "suffix"]
__all__ += ["value_in", "with_unit"]


@dataclass(frozen=True, repr=False)
class Quantity:
    """A number with its unit, as data; `str` writes it as `parse` reads it."""

    number: float
    unit: Unit

    def __str__(self) -> str:
        return f"{self.number!r} {self.unit}"

    def __repr__(self) -> str:
        return repr(str(self))


def convert(value: float, unit: Unit, to: Unit) -> float:
    """The value in another unit. Raises QuantityError where the units do not fit."""
    if not unit.fits(to):
        raise QuantityError(f"the unit {str(unit)!r} does not fit {str(to)!r}")
    if unit.factor == to.factor and unit.offset == to.offset:
        return value
    return (value * unit.factor + unit.offset - to.offset) / to.factor


def convert_difference(value: float, unit: Unit, to: Unit) -> float:
    """A difference of two values in another unit: the offset of a unit has no part in it. Raises QuantityError."""
    if not unit.fits(to):
        raise QuantityError(f"the unit {str(unit)!r} does not fit {str(to)!r}")
    return value if unit.factor == to.factor else value * unit.factor / to.factor


_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$", re.DOTALL)

_COMMA = re.compile(r"\s*([-+]?\d+),(\d+)")


def parse(text: str) -> tuple[float, Unit | None]:
    """Number and unit of "98 deg"; no unit for "98". Raises QuantityError."""
    match = _NUMBER.match(text)
    if match is None:
        raise QuantityError(f"expected a number with a unit such as '98 deg', found {text!r}")
    number, unit = match.groups()
    if comma := _COMMA.match(text):
        raise QuantityError(f"expected a decimal point, {comma[1]}.{comma[2]}, found a decimal comma in {text!r}")
    return float(number), parse_unit(unit) if unit else None


def real(value: float) -> float:
    """A number as a double. Raises QuantityError where it has too many digits for one."""
    try:
        return float(value)
    except OverflowError:
        raise QuantityError("expected a number below 1.8e308, found a larger one") from None


def value_in(value: object, unit: Unit) -> float:
    """A finite number, given as such, as a Quantity or as text with a unit, in `unit`. Raises QuantityError."""
    if isinstance(value, Quantity):
        return convert(value.number, value.unit, unit)
    if isinstance(value, str):
        number, own = parse(value)
        if own is not None:
            number = convert(number, own, unit)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        number = real(value)
    else:
        raise QuantityError(f"expected a number or text with a unit, found {as_written(value)}")
    if not math.isfinite(number):
        raise QuantityError(f"expected a finite number, found {value}")
    return number


def shown(unit: Unit | None) -> str:
    """A unit as it stands behind a value; "" for none, and for 1."""
    return "" if unit is None or str(unit) in ("", "1") else str(unit)


def suffix(unit: Unit | None) -> str:
    """The same with a space before it."""
    return f" {shown(unit)}".rstrip()


def with_unit(value: float, unit: str) -> str:
    """A value with its unit, to four figures."""
    return f"{value:.4g} {unit}".rstrip()
