"""Expressions of a campaign: arithmetic on the values that it draws, and nothing else that Python could do."""

from __future__ import annotations

import ast
from collections.abc import Callable, Container, Mapping
from typing import Any

import numpy as np

from ... import rotation
from ...errors import hint
from ...expressions import OPERATIONS, ExpressionError, Grammar
from ...quantities import QuantityError

_LENGTH_MAX, _SHOWN = 1000, 60


def _rotation(axis: Any, angle: Any) -> Any:
    return np.array(rotation.about([float(x) for x in axis], float(angle))).reshape(3, 3)


def _euler(a: Any, b: Any, c: Any) -> Any:
    return np.array(rotation.euler([float(a), float(b), float(c)], "ZYX")).reshape(3, 3)


FUNCTIONS: dict[str, tuple[int | None, Callable[..., Any]]] = {
    "abs": (1, np.abs),
    "cos": (1, np.cos),
    "cross": (2, np.cross),
    "diag": (1, np.diag),
    "dot": (2, np.dot),
    "euler": (3, _euler),
    "exp": (1, np.exp),
    "log": (1, np.log),
    "max": (None, lambda *values: np.max(np.array(values))),
    "min": (None, lambda *values: np.min(np.array(values))),
    "norm": (1, np.linalg.norm),
    "rotation": (2, _rotation),
    "sin": (1, np.sin),
    "sqrt": (1, np.sqrt),
    "tan": (1, np.tan),
    "transpose": (1, np.transpose),
}
"""By name: how many values it takes, None for one or more, and what it gives.

`rotation(axis, angle)` and `euler(yaw, pitch, roll)` give matrices that turn vectors; angles in rad."""
_CONSTANTS = {"pi": np.pi}
_OPERATIONS = {**OPERATIONS, ast.Pow: lambda a, b: np.power(np.asarray(a, float), np.asarray(b, float))}

_Value = Callable[[Mapping[str, Any]], Any]
"""What computes a part of an expression from the values of its names."""


class NoValue(QuantityError):
    """The expression of an entry has no value at some point; `key` is where it stands in the campaign file."""

    def __init__(self, name: str, helper: bool, text: str) -> None:
        super().__init__(f"{name}: {text}")
        self.key = ("draw" if helper else "vary", name, "expression")
        self.text = text


class _Arithmetic(Grammar[_Value]):
    example = "arithmetic such as 'diag(J + error)'"
    functions = FUNCTIONS

    def __init__(self, known: Container[str], names: list[str]) -> None:
        self._known, self._names = known, names
        self.uses: set[str] = set()

    def number(self, value: float) -> _Value:
        return lambda values: float(value)

    def negative(self, part: _Value) -> _Value:
        return lambda values: -part(values)

    def items(self, parts: list[_Value]) -> _Value:
        return lambda values: np.array([part(values) for part in parts])

    def operation(self, kind: type[ast.operator], left: _Value, right: _Value) -> _Value:
        compute = _OPERATIONS[kind]
        return lambda values: compute(left(values), right(values))

    def call(self, function: Callable[..., Any], parts: list[_Value]) -> _Value:
        return lambda values: function(*(part(values) for part in parts))

    def named(self, node: ast.expr, part: Callable[[ast.expr], _Value]) -> _Value:
        if isinstance(node, ast.Subscript):
            return self._element(node, part(node.value))
        if not isinstance(node, ast.Name):
            self.refuse(node)
        name = node.id
        if name not in self._known and name not in _CONSTANTS:
            raise ExpressionError(f"there is no value {name!r} under 'draw' above it{hint(name, self._names)}")
        self.uses.add(name)

        def value(values: Mapping[str, Any]) -> Any:
            value = values[name] if name in values else _CONSTANTS[name]
            return np.asarray(value, float) if isinstance(value, list) else value

        return value

    def _element(self, node: ast.Subscript, whole: _Value) -> _Value:
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        counts = [place.value if isinstance(place, ast.Constant) else None for place in places]
        index = tuple(count - 1 for count in counts if type(count) is int and count >= 1)
        if len(index) < len(places):
            raise ExpressionError(f"an element is written by whole numbers from 1 on, found {ast.unparse(node)!r}")

        def value(values: Mapping[str, Any]) -> Any:
            of = np.asarray(whole(values))
            if len(index) > of.ndim or any(i >= n for i, n in zip(index, of.shape, strict=False)):
                size = " x ".join(map(str, of.shape)) + " elements" if of.ndim else "no elements, it is one number"
                raise IndexError(f"{ast.unparse(node.value)} has {size}, found {ast.unparse(node)}")
            return of[index]

        return value


class Expression:
    """An expression whose names are known. `value` computes it."""

    def __init__(self, text: str, known: Container[str], names: list[str]) -> None:
        """`known` are the values that may stand in it; `names` is the same, for hints. Raises QuantityError."""
        self.text = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
        if len(text) > _LENGTH_MAX:
            raise QuantityError(
                f"the expression is too long: expected at most {_LENGTH_MAX} characters, found {len(text)}; "
                "remedy: give its parts names under 'draw'"
            )
        grammar = _Arithmetic(known, names)
        self._made_of = text, known, names
        self._value, self.uses = grammar.read(text), grammar.uses

    def __reduce__(self) -> tuple[Any, ...]:
        """Makes it anew in another process, for the workers of a campaign."""
        return Expression, self._made_of

    def value(self, values: Mapping[str, Any]) -> Any:
        """Returns a float, or nested lists of floats. Raises QuantityError."""
        try:
            with np.errstate(all="ignore"):
                result = np.asarray(self._value(values), float)
        except (ValueError, TypeError, IndexError, ArithmeticError, MemoryError) as error:
            raise QuantityError(f"{self.text!r} cannot be computed: {error}") from None
        if not np.isfinite(result).all():
            raise QuantityError(f"{self.text!r} is not finite")
        return result.tolist()

    def of(self, name: str, helper: bool, values: Mapping[str, Any]) -> Any:
        """Returns the value of the entry of this name. Raises NoValue."""
        try:
            return self.value(values)
        except QuantityError as error:
            raise NoValue(name, helper, str(error)) from None
