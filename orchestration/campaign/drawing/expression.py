"""Expressions of a campaign: arithmetic on the values that it draws, and nothing else that Python could do."""

from __future__ import annotations

import ast
from collections.abc import Callable, Container, Mapping
from typing import Any

import numpy as np

from ... import rotation
from ...errors import hint
from ...quantities import QuantityError

_LENGTH_MAX, _DEPTH_MAX, _SHOWN = 1000, 50, 60


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
_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: np.power(np.asarray(a, float), np.asarray(b, float)),
    ast.MatMult: lambda a, b: a @ b,
}


class NoValue(QuantityError):
    """The expression of an entry has no value at some point; `key` is where it stands in the campaign file."""

    def __init__(self, name: str, helper: bool, text: str) -> None:
        super().__init__(f"{name}: {text}")
        self.key = ("draw" if helper else "vary", name, "expression")
        self.text = text


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
        try:
            self._body = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise QuantityError(f"no arithmetic: {getattr(error, 'msg', error)} in {self.text!r}") from None
        self.uses: set[str] = set()
        self._check(self._body, known, names, 0)

    def _check(self, node: ast.expr, known: Container[str], names: list[str], depth: int) -> None:
        if depth > _DEPTH_MAX:
            raise QuantityError(f"nested too deeply: {self.text!r}")
        parts: list[ast.expr]
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            parts = []
        elif isinstance(node, ast.Name):
            if node.id not in known and node.id not in _CONSTANTS:
                raise QuantityError(f"there is no value {node.id!r} under 'draw' above it{hint(node.id, names)}")
            self.uses.add(node.id)
            parts = []
        elif isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            parts = [node.left, node.right]
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            parts = [node.operand]
        elif isinstance(node, ast.List | ast.Tuple):
            parts = list(node.elts)
        elif isinstance(node, ast.Subscript):
            parts = [node.value]
            places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            if not all(isinstance(p, ast.Constant) and type(p.value) is int and p.value >= 1 for p in places):
                raise QuantityError(f"an element is written by whole numbers from 1 on, found {ast.unparse(node)!r}")
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            if node.func.id not in FUNCTIONS:
                raise QuantityError(f"there is no function {node.func.id!r}{hint(node.func.id, FUNCTIONS)}")
            parts = list(node.args)
            wanted, _ = FUNCTIONS[node.func.id]
            if len(parts) != wanted if wanted else not parts:
                expected = f"{wanted or 'one or more'} value{'' if wanted == 1 else 's'}"
                raise QuantityError(f"{node.func.id} takes {expected}, found {len(parts)} in {ast.unparse(node)!r}")
        else:
            raise QuantityError(f"expected arithmetic such as 'diag(J + error)', found {ast.unparse(node)!r}")
        for part in parts:
            self._check(part, known, names, depth + 1)

    def value(self, values: Mapping[str, Any]) -> Any:
        """A float, or nested lists of floats. Raises QuantityError."""
        try:
            with np.errstate(all="ignore"):
                result = np.asarray(self._compute(self._body, values), float)
        except (ValueError, TypeError, IndexError, ArithmeticError, MemoryError) as error:
            raise QuantityError(f"{self.text!r} cannot be computed: {error}") from None
        if not np.isfinite(result).all():
            raise QuantityError(f"{self.text!r} is not finite")
        return result.tolist()

    def of(self, name: str, helper: bool, values: Mapping[str, Any]) -> Any:
        """The value of the entry of this name. Raises NoValue."""
        try:
            return self.value(values)
        except QuantityError as error:
            raise NoValue(name, helper, str(error)) from None

    def _compute(self, node: ast.expr, values: Mapping[str, Any]) -> Any:
        if isinstance(node, ast.Constant):
            return float(node.value)  # type: ignore[arg-type]
        if isinstance(node, ast.Name):
            value = values[node.id] if node.id in values else _CONSTANTS[node.id]
            return np.asarray(value, float) if isinstance(value, list) else value
        if isinstance(node, ast.BinOp):
            return _BINARY[type(node.op)](self._compute(node.left, values), self._compute(node.right, values))
        if isinstance(node, ast.UnaryOp):
            value = self._compute(node.operand, values)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.List | ast.Tuple):
            return np.array([self._compute(item, values) for item in node.elts])
        if isinstance(node, ast.Subscript):
            places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            index = tuple(place.value - 1 for place in places)  # type: ignore[attr-defined]
            of = np.asarray(self._compute(node.value, values))
            if len(index) > of.ndim or any(i >= n for i, n in zip(index, of.shape, strict=False)):
                size = " x ".join(map(str, of.shape)) + " elements" if of.ndim else "no elements, it is one number"
                raise IndexError(f"{ast.unparse(node.value)} has {size}, found {ast.unparse(node)}")
            return of[index]
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        return FUNCTIONS[node.func.id][1](*(self._compute(item, values) for item in node.args))
