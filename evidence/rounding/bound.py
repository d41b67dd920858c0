"""Two kinds of numbers for the lines of operations.py: bounds of rounding errors, and doubles.

A bound says of a quantity how large its exact value is at most and how far the computed one is from it at most
(running error analysis: Higham, Accuracy and Stability of Numerical Algorithms, 3.3). The bounds are computed in
balls of Arb (python-flint), so that their own rounding is enclosed. Tests: tests/evidence/rounding/test_rounding.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import arb

UNIT = arb(2) ** -53
"""Of double precision, with rounding to nearest."""
LEAST = arb(2) ** -1075
"""What a result below the normal numbers loses at most."""
ELEMENTARY = 5 * UNIT
"""Of atan2 and log1p: 2.5 units in the last place, which tests/native/test_elementary.py measures."""


def _up(x: Any) -> Any:
    """The upper end of a ball."""
    return arb(x).upper()


class Bound:
    """|exact| <= size, |computed - exact| <= error."""

    __slots__ = ("error", "size")

    def __init__(self, size: Any, error: Any = 0) -> None:
        self.size, self.error = _up(size), _up(error)

    @classmethod
    def of(cls, x: Any) -> Bound:
        return x if isinstance(x, Bound) else cls(abs(float(x)))

    def rounded(self) -> Bound:
        """After the rounding of a result that was exact for its computed operands."""
        return Bound(self.size, self.error + UNIT * (self.size + self.error) + LEAST)

    def __add__(self, other: Any) -> Bound:
        y = Bound.of(other)
        return Bound(self.size + y.size, self.error + y.error).rounded()

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Any) -> Bound:
        y = Bound.of(other)
        error = self.size * y.error + self.error * y.size + self.error * y.error
        return Bound(self.size * y.size, error).rounded()

    __rmul__ = __mul__

    def __neg__(self) -> Bound:
        return self

    def __abs__(self) -> Bound:
        return self


class Bounds:
    """Functions of bounds. `least` is what a denominator or the argument of a root has at least, `most` what a
    quotient has at most, exactly."""

    @staticmethod
    def within(x: Any, size: Any) -> Bound:
        """x, of which the exact value is known to be at most `size`."""
        b = Bound.of(x)
        return Bound(min(b.size, _up(size)), b.error)

    @staticmethod
    def divide(x: Any, y: Any, least: Any, most: Any = math.inf) -> Bound:
        x, y, least = Bound.of(x), Bound.of(y), arb(least)
        size, computed = min(_up(x.size / least), _up(most)), least - y.error
        if not computed > 0:
            raise ValueError(f"the error of a denominator, {float(y.error):.3g}, is not below it, {float(least):.3g}")
        return Bound(size, (x.error + size * y.error) / computed).rounded()

    @staticmethod
    def sqrt(x: Any, least: Any) -> Bound:
        return Bound(x.size.sqrt(), x.error / arb(least).sqrt()).rounded()

    @staticmethod
    def norm(v: Sequence[Any]) -> Bound:
        """Three roundings of the sum and half of them after the root, whose own is the last."""
        size = sum((Bound.of(x).size ** 2 for x in v), arb(0)).sqrt()
        error = sum((Bound.of(x).error ** 2 for x in v), arb(0)).sqrt()
        return Bound(size, error + 3 * UNIT * (size + error) + arb(2) ** -536)

    @staticmethod
    def direction(size: Any, v: Sequence[Any], least: Any) -> list[Bound]:
        """v over its length, which was computed as `size`: it turns by the error of v over the length at most; three
        roundings in the length, one in 1/length, one in the product."""
        error = sum((Bound.of(x).error ** 2 for x in v), arb(0)).sqrt()
        if not error < arb(least):
            raise ValueError(f"a vector of length {float(arb(least)):.3g} has the error {float(error):.3g}")
        return [Bound(1, error / (arb(least) - error) + 6 * UNIT)] * 3

    @staticmethod
    def atan2(y: Any, x: Any, least: Any) -> Bound:
        """The angle of a vector whose length is at least `least`: as far off as the vector, over its length."""
        turned = ((y.error**2 + x.error**2).sqrt() / arb(least)).asin()
        return Bound(arb.pi(), turned + ELEMENTARY * (arb.pi() + turned))

    @staticmethod
    def log1p(x: Any) -> Bound:
        """Returns log(1 + x) for x of at least 0, where the slope is at most 1."""
        size = (1 + x.size).log()
        return Bound(size, x.error + ELEMENTARY * (size + x.error) + LEAST)

    @staticmethod
    def larger(x: Any, y: Any) -> Bound:
        a, b = Bound.of(x), Bound.of(y)
        return Bound(max(a.size, b.size), max(a.error, b.error))

    @staticmethod
    def either(condition: Callable[[], Any], x: Sequence[Any], y: Sequence[Any]) -> list[Any]:
        """Whichever the condition takes; it is not looked at."""
        return [Bounds.larger(a, b) for a, b in zip(x, y, strict=True)]


class Doubles:
    """The same functions of arrays of doubles, with what is known of sizes looked at; atan2 and log1p are the C's."""

    def __init__(self, atan2: Callable[[Any, Any], Any], log1p: Callable[[Any], Any]) -> None:
        self._atan2, self.log1p = atan2, log1p

    @staticmethod
    def within(x: Any, size: Any) -> Any:
        if not np.all(np.abs(x) <= float(_up(size)) * (1 + 1e-3)):
            raise ValueError(f"{np.max(np.abs(x)):.6g} is above {float(_up(size)):.6g}, which was taken as its limit")
        return x

    @staticmethod
    def divide(x: Any, y: Any, least: Any, most: Any = math.inf) -> Any:
        if not np.all(np.abs(y) >= float(arb(least)) * (1 - 1e-3)):
            raise ValueError(f"{np.min(np.abs(y)):.6g} is below {float(arb(least)):.6g}, which was taken as its least")
        return Doubles.within(x / y, most)

    @staticmethod
    def sqrt(x: Any, least: Any) -> Any:
        return np.sqrt(x)

    @staticmethod
    def norm(v: Sequence[Any]) -> Any:
        return np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])

    @staticmethod
    def direction(size: Any, v: Sequence[Any], least: Any) -> list[Any]:
        inverse = Doubles.divide(1.0, size, least)
        return [inverse * x for x in v]

    def atan2(self, y: Any, x: Any, least: Any) -> Any:
        return self._atan2(y, x)

    @staticmethod
    def larger(x: Any, y: Any) -> Any:
        return np.where(x > y, x, y)

    @staticmethod
    def either(condition: Callable[[], Any], x: Sequence[Any], y: Sequence[Any]) -> list[Any]:
        return [np.where(condition(), a, b) for a, b in zip(x, y, strict=True)]


def octaves(low: float, high: float) -> list[tuple[float, float]]:
    """Parts of a range in each of which the largest is at most twice the least."""
    n = max(1, math.ceil(math.log2(high / low)))
    return [(low * 2.0**i, low * 2.0 ** (i + 1)) for i in range(n)]
