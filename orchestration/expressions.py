"""Expressions in scenarios, campaigns and templates: arithmetic on what has a name, and nothing else of Python.

Tests: tests/orchestration/expectations/test_expressions.py, tests/orchestration/campaign/drawing/test_expression.py.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any, Generic, NoReturn, TypeVar

from .errors import hint
from .quantities import QuantityError

T = TypeVar("T")
_DEPTH_MAX = 100

OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.MatMult: operator.matmul,
    ast.Pow: operator.pow,
}


class ExpressionError(QuantityError):
    """The text is no expression, or its parts do not fit."""


class Grammar(Generic[T]):
    """Reads expressions; a subclass says what each part of them stands for."""

    example: str
    """What is expected, for messages."""
    functions: Mapping[str, tuple[int | None, Callable[..., Any]]]
    """By name: how many values a function takes, None for one or more, and what it gives."""

    def read(self, text: str) -> T:
        """Returns what a text stands for. Raises ExpressionError, and what the subclass raises."""
        return self._of(tree(text, self.example), 0)

    def number(self, value: float) -> T:
        raise NotImplementedError

    def negative(self, part: T) -> T:
        raise NotImplementedError

    def items(self, parts: list[T]) -> T:
        raise NotImplementedError

    def operation(self, kind: type[ast.operator], left: T, right: T) -> T:
        """Returns the result of one of OPERATIONS."""
        raise NotImplementedError

    def call(self, function: Callable[..., Any], parts: list[T]) -> T:
        raise NotImplementedError

    def named(self, node: ast.expr, part: Callable[[ast.expr], T]) -> T:
        """Returns what a name or an element of it stands for; `part` reads a part of the node."""
        self.refuse(node)

    def refuse(self, node: ast.expr) -> NoReturn:
        raise ExpressionError(f"expected {self.example}, found {ast.unparse(node)!r}")

    def _of(self, node: ast.expr, depth: int) -> T:
        if depth > _DEPTH_MAX:
            raise ExpressionError("the expression is nested too deeply")

        def part(inner: ast.expr) -> T:
            return self._of(inner, depth + 1)

        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return self.number(value)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return part(operand)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.negative(part(operand))
            case ast.List(elts=items) | ast.Tuple(elts=items):
                return self.items([part(item) for item in items])
            case ast.BinOp(left, kind, right) if type(kind) in OPERATIONS:
                return self.operation(type(kind), part(left), part(right))
            case ast.Call(ast.Name(name), arguments, []):
                return self.call(self._function(name, node), [part(argument) for argument in arguments])
            case ast.Name() | ast.Attribute() | ast.Subscript():
                return self.named(node, part)
        self.refuse(node)

    def _function(self, name: str, node: ast.Call) -> Callable[..., Any]:
        if name not in self.functions:
            raise ExpressionError(f"there is no function {name!r}{hint(name, self.functions)}")
        wanted, function = self.functions[name]
        if len(node.args) != wanted if wanted else not node.args:
            values = f"{wanted or 'one or more'} value{'' if wanted == 1 else 's'}"
            raise ExpressionError(f"{name} takes {values}, found {len(node.args)} in {ast.unparse(node)!r}")
        return function


def tree(text: str, example: str = "an expression") -> ast.expr:
    """Returns a text as Python reads it. Raises ExpressionError."""
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(f"expected {example}, found {text!r}: {getattr(error, 'msg', error)}") from None
