"""A finding of a comparison, and how its text shows numbers.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from plant.so3 import Array


@dataclass(frozen=True)
class Finding:
    what: str
    """With its number."""
    bound: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.what}; expected {self.bound}; {self.remedy}"


def unit_meant(value: float, least: float, most: float) -> str:
    """The unit by whose mistake a value may be beyond its bounds."""
    for name, factor in (("g.m2", 1e-3), ("kg.cm2", 1e-4), ("kg.mm2", 1e-6)):
        for scaled, said in (
            (value * factor, f"in {name} it would fit"),
            (value / factor, f"it may be meant in kg.m2, not {name}"),
        ):
            if least <= scaled <= most:
                return said
    return "no unit of inertia explains it"


def size_text(size: Array) -> str:
    """Lengths along the axes as text."""
    return " by ".join(f"{x:.3g}" for x in size) + " m"


def parts(causes: Mapping[str, float]) -> str:
    """Torques by cause as text, the largest first."""
    return ", ".join(f"{name} {value:.2g}" for name, value in sorted(causes.items(), key=lambda c: -c[1]))
