"""What a unit's name means: SI base units with their exponents and a factor, as FMI 2.0 declares them.

Needs pint, so it is for building FMUs, not for running them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import pint

_BASE = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}


class UnitError(ValueError):
    """A unit that is unknown or that FMI 2.0 cannot express; the message names it."""


@dataclass(frozen=True)
class Unit:
    """1 unit = factor * product of base units to their exponents; the exponents in FMI's order, zeros left out."""

    name: str
    exponents: dict[str, int]
    factor: Fraction


@cache
def unit(name: str) -> Unit:
    """Reads a unit's name in the Modelica style, as `N.m`, `kg.m2`, `m3/s2`, `rpm` or `1`. Raises UnitError."""
    try:
        quantity = _registry().Quantity(1, to_pint(name)).to_base_units()
    except (pint.PintError, ValueError, TypeError, AssertionError) as error:
        raise UnitError(f"unit {name!r} is not known: {error}") from None
    powers = dict(quantity.unit_items())
    if unknown := set(powers) - set(_BASE):
        raise UnitError(f"unit {name!r} has the base unit {sorted(unknown)[0]!r}, which FMI 2.0 does not have")
    if any(power.denominator != 1 for power in powers.values()):
        raise UnitError(f"unit {name!r} has a base unit to a fractional power, which FMI 2.0 does not have")
    exponents = {short: int(powers[long]) for long, short in _BASE.items() if long in powers}
    return Unit(name, exponents, Fraction(quantity.magnitude))


def display_factor(name: str, display: str) -> float:
    """How many of the display unit make one of the unit: 57.29... for `rad` shown in `deg`. Raises UnitError."""
    of, shown = unit(name), unit(display)
    if of.exponents != shown.exponents:
        raise UnitError(f"{name!r} cannot be shown in {display!r}: their base units differ")
    return float(of.factor / shown.factor)


def to_pint(name: str) -> str:
    """Modelica's style to pint's: a dot multiplies, a number behind a symbol is its exponent."""
    return re.sub(r"([A-Za-zµΩ]+)(-?\d+)", r"\1**\2", name).replace(".", "*") if name != "1" else ""


@cache
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry(non_int_type=Fraction)
