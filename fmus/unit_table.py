"""The units that are read without Pint: SI with its prefixes, what is usual beside it, and products
written as one word. Tests: tests/fmus/test_units.py."""

from __future__ import annotations

import math
import re

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
Exponents = tuple[int, ...]


def _unit(exponents: str, factor: float = 1.0, offset: float = 0.0) -> tuple[Exponents, float, float]:
    powers = dict.fromkeys(BASES, 0)
    for term in exponents.split():
        base, power = re.fullmatch(r"([a-zA-Z]+)(-?\d*)", term).groups()  # type: ignore[union-attr]
        powers[base] = int(power or 1)
    return tuple(powers.values()), factor, offset


PREFIXABLE = {
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
    "G": _unit("kg s-2 A-1", 1e-4),
    "gauss": _unit("kg s-2 A-1", 1e-4),
}
PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6}
PREFIXES |= {"G": 1e9, "T": 1e12, "\N{MICRO SIGN}": 1e-6, "\N{GREEK SMALL LETTER MU}": 1e-6}
UNITS = {
    **{
        prefix + name: (e, float(f"{p * f:.15g}"), o)
        for prefix, p in PREFIXES.items()
        for name, (e, f, o) in PREFIXABLE.items()
    },
    **PREFIXABLE,
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
NO_UNIT = ("-", "[-]", "n/a", "none", "unitless")
"""The text in the place of a unit where there is none."""
OTHER_NAMES = {
    "Gauss": "gauss",
    "milligauss": "mgauss",
    "mGauss": "mgauss",
    "uGauss": "ugauss",
    "RPM": "rpm",
    "dps": "deg/s",
}
"""How engineers write some of these."""
SI = PREFIXABLE.keys() | {prefix + name for prefix in PREFIXES for name in PREFIXABLE}
_PRODUCTS = ("N m", "N m s", "A m", "A s", "V s", "J s", "W s")
ONE_WORD = {
    (prefix + product).replace(" ", ""): tuple((prefix + product).split())
    for prefix in ("", *PREFIXES)
    for product in _PRODUCTS
} | {"kgm": ("kg", "m")}
"""Products that are usually written as one word: `mNms` is mN.m.s. An exponent is that of the last, as in `Am2`."""
