"""The parts of expressions of signals: values of many instants at once with a shape and a unit, and the functions of
them.

Values are in SI base units; the radian is no unit here, since a rate times a momentum is a torque.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..expressions import ExpressionError
from ..fmu.model import Floats
from ..system.wiring import Node

Exponents = tuple[int, ...] | None
"""Of kg, m, s, A, K, mol, cd; None for what fits any unit, such as 0."""

PLAIN: Exponents = (0,) * 7
_SECOND: Exponents = (0, 0, 1, 0, 0, 0, 0)
MEMORY = 3
"""Instants before the first that is looked at that an expression may reach back to."""


@dataclass(frozen=True)
class Samples:
    """Instants (n,) and values (n,) of each element, in the units of the ports."""

    time: Floats
    columns: Mapping[Node, Floats]


@dataclass(frozen=True)
class Expression:
    """A text as values (n, *shape) of samples."""

    shape: tuple[int, ...]
    unit: Exponents
    value: Callable[[Samples], Floats]
    nodes: tuple[Node, ...] = ()
    """The elements that it reads."""
    number: float | None = None
    """As it is written, where it is a number."""

    @property
    def dimensions(self) -> str:
        """Returns the lengths of its shape, for messages."""
        return str(list(self.shape))


def wide(value: Floats, own: tuple[int, ...], shape: tuple[int, ...]) -> Floats:
    """Returns a scalar as wide as a vector or a matrix."""
    return value if own == shape else value.reshape(len(value), *(1 for _ in shape))


def nodes_of(*parts: Expression) -> tuple[Node, ...]:
    return tuple(dict.fromkeys(node for part in parts for node in part.nodes))


def common_unit(parts: Sequence[Expression], what: str) -> Exponents:
    units = {part.unit for part in parts if part.unit is not None}
    if len(units) > 1:
        raise ExpressionError(f"{what} have different units: {' and '.join(sorted(map(written, units)))}")
    return units.pop() if units else None


def written(unit: Exponents) -> str:
    """Returns a unit in base units, in words."""
    names = ("kg", "m", "s", "A", "K", "mol", "cd")
    powers = [f"{name}{power if power != 1 else ''}" for name, power in zip(names, unit or (), strict=False) if power]
    return ".".join(powers) or "1"


def times(left: Expression, right: Expression, sign: int = 1) -> Exponents:
    if left.unit is None or right.unit is None:
        return None
    return tuple(a + sign * b for a, b in zip(left.unit, right.unit, strict=True))


def elementwise(
    function: Callable[..., Floats], left: Expression, right: Expression, unit: Exponents, misfit: str
) -> Expression:
    """Returns a function of two values of one shape, or of a scalar and a value of any.

    Raises ExpressionError, a misfit.
    """
    if left.shape != right.shape and left.shape and right.shape:
        raise ExpressionError(misfit)
    shape = left.shape or right.shape

    def value(samples: Samples) -> Floats:
        return np.asarray(function(*(wide(part.value(samples), part.shape, shape) for part in (left, right))))

    return Expression(shape, unit, value, nodes_of(left, right))


def _shift(values: Floats) -> Floats:
    """Returns those of the instant before; not known at the first."""
    return np.concatenate((np.full_like(values[:1], np.nan), values[:-1]))


def _previous(x: Expression) -> Expression:
    return Expression(x.shape, x.unit, lambda s: _shift(x.value(s)), x.nodes)


def _mean(x: Expression) -> Expression:
    def value(samples: Samples) -> Floats:
        values = x.value(samples)
        return 0.5 * (values + _shift(values))

    return Expression(x.shape, x.unit, value, x.nodes)


def _rate(x: Expression) -> Expression:
    unit = None if x.unit is None else tuple(a - b for a, b in zip(x.unit, _SECOND or (), strict=True))

    def value(samples: Samples) -> Floats:
        values, steps = x.value(samples), samples.time - _shift(samples.time)
        return (values - _shift(values)) / wide(steps, (), x.shape)

    return Expression(x.shape, unit, value, x.nodes)


def _turn_rate(R: Expression) -> Expression:
    """log(R_before^T R)/h: the mean rate in the axes of the columns."""
    _expect(R, (3, 3), "turn_rate")

    def value(samples: Samples) -> Floats:
        values, steps = R.value(samples), samples.time - _shift(samples.time)
        turned = np.einsum("nji,njk->nik", _shift(values), values)
        axis = 0.5 * np.stack([turned[:, i, j] - turned[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
        sine = np.linalg.norm(axis, axis=1)
        angle = np.arctan2(sine, 0.5 * (np.trace(turned, axis1=1, axis2=2) - 1.0))
        scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)
        return axis * (scale / steps)[:, None]

    return Expression((3,), tuple(-e for e in _SECOND or ()), value, R.nodes)


def _norm(x: Expression) -> Expression:
    return Expression((), x.unit, lambda s: np.sqrt((x.value(s).reshape(len(s.time), -1) ** 2).sum(axis=1)), x.nodes)


def _abs(x: Expression) -> Expression:
    return Expression(x.shape, x.unit, lambda s: np.abs(x.value(s)), x.nodes)


def _dot(a: Expression, b: Expression) -> Expression:
    if a.shape != b.shape or len(a.shape) != 1:
        raise ExpressionError("dot takes two vectors of one length")
    return Expression((), times(a, b), lambda s: (a.value(s) * b.value(s)).sum(axis=1), nodes_of(a, b))


def _cross(a: Expression, b: Expression) -> Expression:
    _expect(a, (3,), "cross")
    _expect(b, (3,), "cross")
    return Expression((3,), times(a, b), lambda s: np.asarray(np.cross(a.value(s), b.value(s))), nodes_of(a, b))


def _transpose(x: Expression) -> Expression:
    if len(x.shape) != 2:
        raise ExpressionError("transpose takes a matrix")
    return Expression(x.shape[::-1], x.unit, lambda s: x.value(s).transpose(0, 2, 1), x.nodes)


def _det(x: Expression) -> Expression:
    _expect(x, (3, 3), "det")
    unit = None if x.unit is None else tuple(3 * e for e in x.unit)
    return Expression((), unit, lambda s: np.asarray(np.linalg.det(x.value(s))), x.nodes)


def _least(function: Callable[..., Floats]) -> Callable[[Expression, Expression], Expression]:
    def make(a: Expression, b: Expression) -> Expression:
        unit = common_unit((a, b), "both arguments")
        return elementwise(function, a, b, unit, "both arguments have one shape, or one is a scalar")

    return make


def _expect(x: Expression, shape: tuple[int, ...], name: str) -> None:
    if x.shape != shape:
        raise ExpressionError(f"{name} takes {list(shape)}, found {list(x.shape) or 'a scalar'}")


FUNCTIONS: dict[str, tuple[int, Callable[..., Expression]]] = {
    "norm": (1, _norm),
    "abs": (1, _abs),
    "dot": (2, _dot),
    "cross": (2, _cross),
    "transpose": (1, _transpose),
    "det": (1, _det),
    "minimum": (2, _least(np.minimum)),
    "maximum": (2, _least(np.maximum)),
    "previous": (1, _previous),
    "mean": (1, _mean),
    "rate": (1, _rate),
    "turn_rate": (1, _turn_rate),
}
"""The functions by name, each with the number of its arguments."""
