"""Expressions of signals, evaluated on many instants at once: `cross(plant.omega_B, plant.H_B)`.

An expression has a shape and a unit, both known before the run. Values are in SI base units; the radian is no unit
here, since a rate times a momentum is a torque.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable

import numpy as np

from ..errors import InputError
from ..expressions import OPERATIONS, ExpressionError, Grammar, tree
from ..fmu.model import Floats, Variable
from ..quantities import ONE
from ..scenario.references import Reference
from ..system.wiring import Node
from .functions import FUNCTIONS, PLAIN, Expression, Samples, common_unit, elementwise, nodes_of, times

Find = Callable[[Reference], tuple[Variable, list[Node]]]
"""The elements that a reference means. Raises InputError."""


def parse(text: str, find: Find) -> Expression:
    """Returns the expression of a text. Raises ExpressionError, and what `find` raises."""
    return _Signals(find).read(text)


def references(text: str) -> list[Reference]:
    """Returns the signals that an expression reads. Raises ExpressionError."""
    found: list[Reference] = []
    nodes: list[ast.AST] = [tree(text)]
    while nodes:
        node = nodes.pop()
        if isinstance(node, (ast.Attribute, ast.Subscript)):
            found.append(_reference(node))
        else:
            nodes += ast.iter_child_nodes(node)
    return found


def _reference(node: ast.expr) -> Reference:
    try:
        return Reference(ast.unparse(node).replace("(", "").replace(")", ""))
    except InputError as error:
        raise ExpressionError(str(error)) from None


class _Signals(Grammar[Expression]):
    example = "an expression of signals, numbers, lists, + - * / @ ** and functions, such as 'rate(plant.h_w)'"
    functions = FUNCTIONS

    def __init__(self, find: Find) -> None:
        self._find = find

    def number(self, value: float) -> Expression:
        number = _number(value)
        return Expression((), None if number == 0.0 else PLAIN, lambda s: np.full(len(s.time), number), number=value)

    def negative(self, part: Expression) -> Expression:
        return Expression(part.shape, part.unit, lambda s: -part.value(s), part.nodes)

    def items(self, parts: list[Expression]) -> Expression:
        if not parts or any(item.shape != parts[0].shape for item in parts):
            raise ExpressionError("a list holds items of one shape")
        unit, shape = common_unit(parts, "the items of a list"), (len(parts), *parts[0].shape)
        return Expression(shape, unit, lambda s: np.stack([i.value(s) for i in parts], axis=1), nodes_of(*parts))

    def operation(self, kind: type[ast.operator], left: Expression, right: Expression) -> Expression:
        if kind is ast.MatMult:
            return _matrix_product(left, right)
        if kind is ast.Pow:
            return _power(left, right.number)
        if kind in (ast.Add, ast.Sub):
            unit = common_unit((left, right), "both sides of + and -")
        else:
            unit = times(left, right, -1 if kind is ast.Div else 1)
        return elementwise(
            OPERATIONS[kind], left, right, unit, f"the shapes differ: {left.dimensions} and {right.dimensions}"
        )

    def call(self, function: Callable[..., Expression], parts: list[Expression]) -> Expression:
        return function(*parts)

    def named(self, node: ast.expr, part: Callable[[ast.expr], Expression]) -> Expression:
        if isinstance(node, ast.Name):
            self.refuse(node)
        return _signal(node, self._find)


def _number(value: float) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ExpressionError("expected a finite number")
    return number


def _signal(node: ast.expr, find: Find) -> Expression:
    variable, nodes = find(_reference(node))
    if variable.type not in ("real", "integer"):
        raise ExpressionError(f"{ast.unparse(node)} is {variable.kind}; expected a number")
    whole = len(nodes) == variable.size
    parts = [variable.at([node.element.position]).unit or ONE for node in nodes]
    if any(unit.exponents is None for unit in parts) or len({unit.exponents for unit in parts}) != 1:
        raise ExpressionError(f"{ast.unparse(node)}: its unit is not known, or its elements have several")
    factors, offsets = np.array([u.factor for u in parts]), np.array([u.offset for u in parts])
    shape = variable.shape if whole else ()
    exponents = parts[0].exponents

    def value(samples: Samples) -> Floats:
        flat = np.stack([samples.columns[node] for node in nodes], axis=1) * factors + offsets
        return flat.reshape(len(flat), *shape)

    return Expression(shape, exponents[:-1] if exponents else None, value, tuple(nodes))


def _power(base: Expression, power: float | None) -> Expression:
    if not isinstance(power, int) or not 0 < power < 10:
        raise ExpressionError("expected a whole exponent of 1 to 9")
    unit = None if base.unit is None else tuple(power * e for e in base.unit)
    return Expression(base.shape, unit, lambda s: base.value(s) ** power, base.nodes)


def _matrix_product(left: Expression, right: Expression) -> Expression:
    if len(left.shape) != 2 or len(right.shape) not in (1, 2) or left.shape[1] != right.shape[0]:
        raise ExpressionError(f"no matrix product of {list(left.shape)} and {list(right.shape)}")
    sum_ = "nij,nj->ni" if len(right.shape) == 1 else "nij,njk->nik"
    shape = (left.shape[0], *right.shape[1:])
    return Expression(
        shape,
        times(left, right),
        lambda s: np.asarray(np.einsum(sum_, left.value(s), right.value(s))),
        nodes_of(left, right),
    )
