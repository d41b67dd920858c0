"""The list of comparisons with what this project did not write.

Each authority is a function without arguments that returns a figure; it is right where it lies within
`tolerance` of `expected`. The tests assert it, and `python -m tests.authorities` writes the table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec


@dataclass(frozen=True)
class Authority:
    name: str
    subject: str
    what: str
    source: str
    unit: str
    expected: float
    tolerance: float
    measure: Callable[[], float]
    needs: str | None
    """Package on PyPI and module, as `bsk:Basilisk`, of an optional authority."""

    @property
    def available(self) -> bool:
        return self.needs is None or find_spec(self.needs.split(":")[1]) is not None

    @property
    def quick(self) -> bool:
        """Whether the tests run it too, given its package."""
        return self.needs is None or self.needs.split(":")[0] not in HEAVY

    def agrees(self, figure: float) -> bool:
        return abs(figure - self.expected) <= self.tolerance


HEAVY = ("bsk", "orekit-jpype")
"""Packages of hundreds of megabytes, or that need a Java runtime: run by the command alone."""
REGISTRY: list[Authority] = []


def authority(
    subject: str,
    what: str,
    *,
    source: str,
    tolerance: float,
    unit: str = "",
    expected: float = 0.0,
    needs: str | None = None,
) -> Callable[[Callable[[], float]], Callable[[], float]]:
    """Registers the decorated function."""

    def register(measure: Callable[[], float]) -> Callable[[], float]:
        REGISTRY.append(Authority(measure.__name__, subject, what, source, unit, expected, tolerance, measure, needs))
        return measure

    return register
