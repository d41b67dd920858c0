"""Expressions: arithmetic, and nothing else."""

from __future__ import annotations

import math
import pickle

import pytest

from orchestration.campaign.drawing.expression import Expression
from orchestration.quantities import QuantityError

KNOWN = {"a": 2.0, "v": [1.0, 2.0, 3.0], "R": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]}


def value(text):
    return Expression(text, KNOWN, list(KNOWN)).value(KNOWN)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a + 1", 3.0),
        ("-v * (1 + a)", [-3.0, -6.0, -9.0]),
        ("diag(v)[2,2]", 2.0),
        ("R @ v", [-2.0, 1.0, 3.0]),
        ("v[3] ** 2 / 3", 3.0),
        ("[a, v[1], norm([3, 4])]", [2.0, 1.0, 5.0]),
        ("rotation([0, 0, 1], pi / 2) @ [1, 0, 0]", [0.0, 1.0, 0.0]),
        ("exp(log(a)) + sqrt(4) - abs(-1)", 3.0),
        ("sin(0) + cos(0) + tan(pi / 4)", 2.0),
        ("transpose(R) @ cross(v, [0, 0, 1])", [-1.0, -2.0, 0.0]),
        ("dot(v, v) + euler(0, 0, 0)[1,1]", 15.0),
        ("max(a, 5, -1) + min(v)", 6.0),
    ],
)
def test_arithmetic_gives_its_value(text, expected):
    assert value(text) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("b + 1", "there is no value 'b'"),
        ("sqr(a)", "did you mean 'sqrt'"),
        ("__import__('os').system('true')", "expected arithmetic"),
        ("a.__class__", "expected arithmetic"),
        ("(lambda: 1)()", "expected arithmetic"),
        ("'text'", "expected arithmetic"),
        ("a if a else a", "expected arithmetic"),
        ("v[0]", "from 1 on"),
        ("a +", "expected arithmetic"),
        ("norm(v, a)", r"norm takes 1 value, found 2 in 'norm\(v, a\)'"),
        ("cos(a, v)", "cos takes 1 value, found 2"),
        ("cross(v)", "cross takes 2 values, found 1"),
        ("max()", "max takes one or more values, found 0"),
        ("(" * 300 + "a" + ")" * 300, "expected arithmetic"),
        ("+".join("a" * 600), "at most 1000 characters"),
        ("-" * 200 + "a", "nested too deeply"),
    ],
)
def test_anything_else_is_refused_before_a_run(text, message):
    with pytest.raises(QuantityError, match=message):
        value(text)


@pytest.mark.parametrize("text", ["v[4]", "R @ [1, 2]", "1 / (a - 2)", "9.0 ** 9 ** 9", "log(0 * a)"])
def test_what_has_no_finite_value_is_an_error(text):
    with pytest.raises(QuantityError, match="cannot be computed|is not finite"):
        value(text)


def test_an_expression_gives_the_same_in_another_process():
    made = Expression("R @ v + a", KNOWN, list(KNOWN))
    assert pickle.loads(pickle.dumps(made)).value(KNOWN) == made.value(KNOWN)


def test_a_large_power_costs_no_time():
    with pytest.raises(QuantityError):
        value("99999999 ** 99999999 ** 99999999")
    assert math.isfinite(value("2 ** 10"))
