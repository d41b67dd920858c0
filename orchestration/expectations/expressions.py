"""Expressions of signals, evaluated on many instants at once: `cross(plant.omega_B, plant.H_B)`.

An expression has a shape and a unit, both known before the run. Values are in SI base units; the radian is no unit here,
since a rate times a momentum is a torque.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Sequence

import numpy as np

from ..fmu.model import Floats, Variable
from ..quantities import ONE
from ..scenario.references import Reference
from ..system.wiring import Node
from .functions import (
    FUNCTIONS,
    PLAIN,
    Expression,
    ExpressionError,
    Samples,
    common_unit,
    negative,
    nodes_of,
    times,
    wide,
)

Find = Callable[[Reference], tuple[Variable, list[Node]]]
"""The elements that a reference means. Raises InputError."""


def parse(text: str, find: Find) -> Expression:
    """The expression of a text. Raises ExpressionError, and what `find` raises."""
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"expected an expression such as 'rate(plant.h_w)', found {text!r}") from None
    try:
        return _expression(tree, find)
    except RecursionError:
        raise ExpressionError("the expression is nested too deeply") from None


def _expression(tree: ast.expr, find: Find) -> Expression:
    if isinstance(tree, ast.Constant) and isinstance(tree.value, (int, float)) and not isinstance(tree.value, bool):
        number = _number(tree.value)
        return Expression((), None if number == 0.0 else PLAIN, lambda s: np.full(len(s.time), number))
    if isinstance(tree, (ast.Attribute, ast.Subscript)):
        return _signal(tree, find)
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        return negative(_expression(tree.operand, find))
    if isinstance(tree, ast.List):
        return _list([_expression(item, find) for item in tree.elts])
    if isinstance(tree, ast.BinOp):
        return _product(tree, find)
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
        if tree.func.id not in FUNCTIONS:
            raise ExpressionError(f"unknown function {tree.func.id!r}; there are {', '.join(FUNCTIONS)}")
        count, make = FUNCTIONS[tree.func.id]
        if len(tree.args) != count:
            raise ExpressionError(f"{tree.func.id} takes {count} argument{'s' if count > 1 else ''}")
        return make(*(_expression(argument, find) for argument in tree.args))
    raise ExpressionError(f"expected signals, numbers, lists, + - * / @ ** and functions, found {ast.unparse(tree)!r}")


def _number(value: float) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ExpressionError("expected a finite number")
    return number


def _signal(tree: ast.expr, find: Find) -> Expression:
    variable, nodes = find(Reference(ast.unparse(tree).replace("(", "").replace(")", "")))
    if variable.type not in ("real", "integer"):
        raise ExpressionError(f"{ast.unparse(tree)} is {variable.kind}; expected a number")
    whole = len(nodes) == variable.size
    parts = [variable.at([node.element.position]).unit or ONE for node in nodes]
    if any(unit.exponents is None for unit in parts) or len({unit.exponents for unit in parts}) != 1:
        raise ExpressionError(f"{ast.unparse(tree)}: its unit is not known, or its elements have several")
    factors, offsets = np.array([u.factor for u in parts]), np.array([u.offset for u in parts])
    shape = variable.shape if whole else ()
    exponents = parts[0].exponents

    def value(samples: Samples) -> Floats:
        flat = np.stack([samples.columns[node] for node in nodes], axis=1) * factors + offsets
        return flat.reshape(len(flat), *shape)

    return Expression(shape, exponents[:-1] if exponents else None, value, tuple(nodes))


def _list(items: Sequence[Expression]) -> Expression:
    if not items or any(item.shape != items[0].shape for item in items):
        raise ExpressionError("a list holds items of one shape")
    unit = common_unit(items, "the items of a list")
    return Expression(
        (len(items), *items[0].shape), unit, lambda s: np.stack([i.value(s) for i in items], axis=1), nodes_of(*items)
    )


def _product(tree: ast.BinOp, find: Find) -> Expression:
    left = _expression(tree.left, find)
    if isinstance(tree.op, ast.Pow):
        power = tree.right.value if isinstance(tree.right, ast.Constant) else None
        if not isinstance(power, int) or not 0 < power < 10:
            raise ExpressionError("expected a whole exponent of 1 to 9")
        unit = None if left.unit is None else tuple(power * e for e in left.unit)
        return Expression(left.shape, unit, lambda s: left.value(s) ** power, left.nodes)
    right = _expression(tree.right, find)
    if isinstance(tree.op, ast.MatMult):
        return _matrix_product(left, right)
    operation = {ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide}.get(type(tree.op))
    if operation is None:
        raise ExpressionError("expected one of + - * / @ **")
    if isinstance(tree.op, (ast.Add, ast.Sub)):
        unit = common_unit((left, right), "both sides of + and -")
    else:
        unit = times(left, right, -1 if isinstance(tree.op, ast.Div) else 1)
    if left.shape != right.shape and left.shape and right.shape:
        raise ExpressionError(f"the shapes differ: {list(left.shape)} and {list(right.shape)}")
    shape = left.shape or right.shape

    def value(samples: Samples) -> Floats:
        a, b = (wide(part.value(samples), part.shape, shape) for part in (left, right))
        return np.asarray(operation(a, b))

    return Expression(shape, unit, value, nodes_of(left, right))


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
