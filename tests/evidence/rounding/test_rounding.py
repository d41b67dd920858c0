"""The bounds of rounding errors: rigorous operations, above what is measured, and below what a planted loss gives."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from orchestration import InputError

pytest.importorskip("flint", reason="python-flint is not installed: pip install '.[measures]'")

from evidence.rounding.bound import Bound, Bounds, octaves
from evidence.rounding.cases import CASES, det_least
from evidence.rounding.flight_code import FlightCode
from evidence.rounding.make import check, measure

CONTROLLER, ALLOCATOR = CASES[0], CASES[5]


@pytest.mark.parametrize("name", ["+", "*", "/", "norm"])
def test_no_operation_errs_by_more_than_its_bound_on_operands_that_err(name: str) -> None:
    """Against exact fractions: operands of up to 3 and 1, the second at least 0.5, that are computed 1e-12 off."""
    rng = np.random.default_rng(0)
    x, y = (3.0, 1e-12), (1.0, 1e-12)
    bound = {
        "+": lambda: Bound(*x) + Bound(*y),
        "*": lambda: Bound(*x) * Bound(*y),
        "/": lambda: Bounds.divide(Bound(*x), Bound(*y), 0.5),
        "norm": lambda: Bounds.norm([Bound(*x), Bound(*y), Bound(0)]),
    }[name]()
    for _ in range(2000):
        a, b = rng.uniform(-3.0, 3.0), rng.uniform(0.5, 1.0)
        a_off, b_off = a + rng.uniform(-1e-12, 1e-12), b + rng.uniform(-1e-12, 1e-12)
        exact, computed = {
            "+": lambda a=a, b=b, c=a_off, d=b_off: (Fraction(a) + Fraction(b), c + d),
            "*": lambda a=a, b=b, c=a_off, d=b_off: (Fraction(a) * Fraction(b), c * d),
            "/": lambda a=a, b=b, c=a_off, d=b_off: (Fraction(a) / Fraction(b), c / d),
            "norm": lambda a=a, b=b, c=a_off, d=b_off: (
                Fraction(float(np.hypot(np.longdouble(a), np.longdouble(b)))),
                float(np.sqrt(c * c + d * d)),
            ),
        }[name]()
        slack = 4e-16 if name == "norm" else 0.0  # of the witness
        assert abs(Fraction(computed) - exact) <= float(bound.error) + slack


def test_octaves_cover_a_range() -> None:
    parts = octaves(6.5e6, 1.73e8)
    assert parts[0][0] == 6.5e6
    assert parts[-1][1] >= 1.73e8
    assert all(end == begin for (_, end), (begin, _) in pairwise(parts))


def test_no_direction_of_the_field_has_a_smaller_determinant_of_the_rods() -> None:
    _, p = FlightCode("allocator").parameters()
    rng, U, least = np.random.default_rng(0), np.asarray(p.rod_axes), det_least(p)
    found = []
    for _ in range(3000):
        b, n = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        n = np.cross(b, n) / np.linalg.norm(np.cross(b, n))
        A = np.column_stack((np.cross(U, b) @ n, np.cross(U, b) @ np.cross(b, n)))
        found.append(np.linalg.det(A.T @ A))
    assert least <= min(found) <= 1.05 * least


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.block}, {case.title}")
def test_the_c_errs_by_less_than_its_bound_and_computes_what_was_bounded(case: Any) -> None:
    rows = measure(case, FlightCode(case.block), 300)
    check(case, rows)
    assert all(row.bound < 1.0 for row in rows) or "whole" in case.title


PLANTED = {
    "the angle from its cosine alone": (
        CONTROLLER,
        "attitude_error",
        (
            "e->angle = principal_angle(e->Q);",
            "const double c = 0.5 * (e->Q.a.x + e->Q.b.y + e->Q.c.z - 1.0);\n"
            "    e->angle = atan2(sqrt(larger(1.0 - c * c, 0.0)), c);",
        ),
    ),
    "a rate in single precision": (
        CONTROLLER,
        "tau_cmd_B",
        (
            "e->omega = subtract(vector(u->omega_B), e->Omega_d_B);",
            "e->omega = subtract(vector(u->omega_B), e->Omega_d_B);\n    e->omega.x = (double)(float)e->omega.x;",
        ),
    ),
    "a basis from what is left of a demand along the field": (
        ALLOCATOR,
        "dipole_cmd",
        ("ACROSS_MIN = 1e-3;", "ACROSS_MIN = 1e-12;"),
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_loss_of_accuracy_is_named(name: str) -> None:
    case, output, (before, after) = PLANTED[name]
    code = FlightCode(case.block, (f"{case.block}.c", before, after))
    with pytest.raises(InputError, match="give different bits"):
        measure(case, code, 300)
    with pytest.raises(InputError, match=rf"{case.title}: \w+: the measured rounding error .* is above its bound"):
        check(case, rows := measure(case, code, 2000, bits=False))
    assert (
        next(row for row in rows if row.output == output).measured
        > next(row for row in rows if row.output == output).bound
    )
