"""From a distribution as the file says it to the sampler of its values, and to words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...errors import as_written
from ...fmu.model import Floats
from ...quantities import QuantityError, Unit, convert, convert_difference, parse, real
from ..file.distributions import Steps, Varied
from . import samplers


def numbers_only(value: Any) -> bool:
    """Returns whether it is a number, or a list of numbers."""
    leaves = value if isinstance(value, list) else [value]
    return all(isinstance(x, float | int) and not isinstance(x, bool) for x in leaves) and bool(leaves)


def examples(sampler: samplers.Sampler) -> list[Any]:
    """Returns all values of a choice or a grid; of another distribution the one at the centre."""
    return list(sampler.values) if isinstance(sampler, samplers.Pick) else [sampler.value([0.5] * sampler.count)]


def sampler(entry: Varied) -> tuple[samplers.Sampler, Unit | None]:
    """Returns the distribution of an entry, and the unit of its numbers, if they have one. Raises QuantityError."""
    if entry.uniform is not None:
        (low, high), unit = _measured(*entry.uniform)
        if low.shape != high.shape:
            raise QuantityError("expected both ends with as many elements")
        if not (low < high).all():
            raise QuantityError(f"expected [low, high], found {entry.uniform!r}")
        return samplers.Uniform(low, high), unit
    if entry.normal is not None:
        return _normal(entry)
    if entry.lognormal is not None:
        (median,), unit = _measured(entry.lognormal.median)
        if not (median > 0.0).all():
            raise QuantityError("the median of a log-normal distribution is above 0")
        return samplers.LogNormal(median, entry.lognormal.sigma), unit
    if entry.integers is not None:
        if entry.integers[0] > entry.integers[1]:
            raise QuantityError(f"expected [low, high], found {entry.integers!r}")
        return samplers.Integers(*entry.integers), None
    if entry.rotation is not None:
        return samplers.Rotation(), None
    if isinstance(entry.sphere, Varied):
        inner, unit = sampler(entry.sphere)
        if wrong := [value for value in examples(inner) if isinstance(value, list) or not numbers_only(value)]:
            raise QuantityError(f"sphere: expected one number as its length, found {as_written(wrong[0])}")
        return samplers.Sphere(inner), _length(unit)
    if entry.sphere is not None:
        (length,), unit = _measured(entry.sphere)
        if length.shape or length < 0.0:
            raise QuantityError(f"sphere: expected one length, zero or more, found {as_written(entry.sphere)}")
        return samplers.Sphere(float(length)), _length(unit)
    return _pick(entry)


def _length(unit: Unit | None) -> Unit | None:
    """Returns the unit of a length. Raises QuantityError for one with an offset, which each element would be given."""
    if unit is not None and unit.offset:
        raise QuantityError(f"sphere: expected a unit without an offset, found {unit}")
    return unit


def _normal(entry: Varied) -> tuple[samplers.Sampler, Unit | None]:
    normal = entry.normal
    assert normal is not None
    ends = [end for end in (normal.low, normal.high) if end is not None]
    if normal.covariance is not None:
        (mean,), unit = _measured(normal.mean)
        covariance = (
            np.array(normal.covariance, float) if len({len(row) for row in normal.covariance}) == 1 else np.zeros(0)
        )
        if covariance.shape != (mean.size, mean.size):
            raise QuantityError(f"covariance: expected {mean.size} rows of {mean.size} numbers")
        try:
            return samplers.Correlated(mean, samplers.root_of(covariance)), unit
        except ValueError as error:
            raise QuantityError(f"covariance: {error}") from None
    (mean, deviation, *limits), unit = _measured(normal.mean, normal.deviation, *ends, differences=(1,))
    if deviation.shape not in ((), mean.shape):
        raise QuantityError("expected a deviation for each element of the mean, or one for all")
    if not (deviation > 0.0).all():
        raise QuantityError("expected a deviation above 0")
    low = float(limits.pop(0)) if normal.low is not None else -np.inf
    high = float(limits.pop(0)) if normal.high is not None else np.inf
    if low >= high:
        raise QuantityError(f"expected low below high, found {low:g} and {high:g}")
    return samplers.Normal(mean, np.broadcast_to(deviation, mean.shape).copy(), low, high), unit


def _pick(entry: Varied) -> tuple[samplers.Sampler, Unit | None]:
    unit: Unit | None = None
    values = entry.choice if entry.choice is not None else entry.grid
    if isinstance(values, Steps):
        (start, to), unit = _measured(values.start, values.to)
        n = values.points - 1
        numbers = [float(start) + (float(to) - float(start)) * i / n for i in range(n)] + [float(to)]
        given: list[Any] = numbers
    else:
        assert values is not None
        given = list(values)
        try:
            measured, unit = _measured(*given)
            if (any(m.shape for m in measured) and unit) or not all(isinstance(value, int) for value in given):
                given = [number.tolist() for number in measured]
        except QuantityError:
            pass  # names of items, or whole matrices
    weights = np.array(entry.weights or [1.0] * len(given), float)
    ends = np.cumsum(weights) / weights.sum()
    return samplers.Pick(tuple(given), (*ends[:-1].tolist(), 1.0), entry.grid is not None), unit


def _measured(*quantities: Any, differences: Sequence[int] = ()) -> tuple[list[Floats], Unit | None]:
    """Returns numbers of quantities, or of lists of them, in one unit: the first that is given. Raises QuantityError.

    Those at the places `differences` are of two values, as a deviation is, so that the offset of a unit has no part in
    them.
    """
    unit: Unit | None = None
    bare = False
    arrays = []
    for place, given in enumerate(quantities):
        into = convert_difference if place in differences else convert
        numbers = []
        for item in given if isinstance(given, list) else [given]:
            if isinstance(item, bool) or not isinstance(item, int | float | str):
                raise QuantityError(f"expected a number or text with a unit, found {as_written(item)}")
            number, own = parse(item) if isinstance(item, str) else (real(item), None)
            if own is None:
                bare = bare or number != 0.0
            else:
                unit = unit or own
                number = into(number, own, unit)
            numbers.append(number)
        arrays.append(np.array(numbers) if isinstance(given, list) else np.array(numbers[0]))
    if unit is not None and bare:
        raise QuantityError(f"expected a unit at each number, as {unit}, or at none")
    if not all(np.isfinite(array).all() for array in arrays):
        raise QuantityError("expected finite numbers")
    return arrays, unit


def describe(entry: Varied) -> str:
    """Returns the distribution in words."""
    if entry.uniform is not None:
        return f"uniform from {_words(entry.uniform[0])} to {_words(entry.uniform[1])}"
    if entry.normal is not None:
        n = entry.normal
        spread = "correlated" if n.covariance is not None else f"deviation {_words(n.deviation)}"
        ends = "".join(f", {word} {_words(end)}" for word, end in (("from", n.low), ("to", n.high)) if end is not None)
        return f"normal, mean {_words(n.mean)}, {spread}{ends}"
    if entry.lognormal is not None:
        return f"log-normal, median {_words(entry.lognormal.median)}, sigma {entry.lognormal.sigma:g}"
    if entry.integers is not None:
        return f"whole number from {entry.integers[0]} to {entry.integers[1]}"
    if entry.rotation is not None:
        return "uniform over all attitudes"
    if entry.sphere is not None:
        length = describe(entry.sphere) if isinstance(entry.sphere, Varied) else _words(entry.sphere)
        return f"any direction, length {length}"
    if isinstance(entry.grid, Steps):
        return f"{entry.grid.points} points from {_words(entry.grid.start)} to {_words(entry.grid.to)}"
    if entry.expression is not None:
        return entry.expression
    values = entry.choice if entry.choice is not None else entry.grid
    assert isinstance(values, list)
    more = f" and {len(values) - 5} more" if len(values) > 5 else ""
    return f"one of {', '.join(map(_words, values[:5]))}{more}" + (", weighted" if entry.weights else "")


def _words(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_words, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
