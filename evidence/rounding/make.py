"""docs/evidence/rounding.md: bounds of the rounding errors of controller and allocator, and the largest measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import InputError

from .. import markdown
from ..paper import ROOT
from .cases import CASES, OfAllocator, OfController, larger_table
from .flight_code import FlightCode

PAGE = ROOT / "docs" / "evidence" / "rounding.md"
SEED = 53


@dataclass(frozen=True)
class Row:
    """An output over a range: largest |computed - exact|, by its bound and as measured; largest of its elements."""

    output: str
    bound: float
    measured: float


def make(n: int) -> Path:
    """Measures n samples a block, shared by its ranges, and writes the page.

    Raises InputError as `check` and `measure` do.
    """
    codes = {block: FlightCode(block) for block in dict.fromkeys(case.block for case in CASES)}
    tables: dict[str, list[tuple[str, list[Row]]]] = {block: [] for block in codes}
    for case in CASES:
        rows = measure(case, codes[case.block], math.ceil(n / sum(c.block == case.block for c in CASES)))
        check(case, rows)
        tables[case.block].append((case.title, rows))
    shown = {block: _table(codes[block], of_cases) for block, of_cases in tables.items()}
    PAGE.write_text(markdown.render(Path(__file__).parent, samples=f"{n:,}".replace(",", " "), **shown), "utf-8")
    return PAGE


def measure(case: OfController | OfAllocator, code: FlightCode, n: int, bits: bool = True) -> list[Row]:
    """Bound and measured error of each output. `bits`: raises InputError where the C does not compute what
    operations.py does."""
    rng, bound, errors = np.random.default_rng(SEED), None, dict[str, float]()
    for changes in case.changes:
        record, p = code.parameters(**changes)
        table = case.bound(p)
        bound = table if bound is None else larger_table(bound, table)
        u = _not_held(case, code, record, math.ceil(n / len(case.changes)), rng)
        y = code.outputs(record, u)
        if bits:
            _compare(case, y, case.doubles(code.doubles, p, u))
        for i in range(len(y)):
            for name, values in case.exact(p, u, i).items():
                found = np.ravel(y[name][i])
                worst = max(float(abs(x - float(c)).upper()) for x, c in zip(values, found, strict=True))
                errors[name] = max(errors.get(name, 0.0), worst)
    assert bound is not None
    return [Row(name, max(float(x.error) for x in values), errors[name]) for name, values in bound.items()]


def check(case: OfController | OfAllocator, rows: list[Row]) -> None:
    """Raises InputError where an error is above its bound."""
    for row in rows:
        if not row.measured <= row.bound:
            raise InputError(
                f"{case.block}, {case.title}: {row.output}: the measured rounding error {row.measured:.3g} is above "
                f"its bound {row.bound:.3g}; remedy: look for what loses accuracy in {case.block}.c"
            )


def _not_held(case: Any, code: FlightCode, record: Any, n: int, rng: np.random.Generator) -> Any:
    """n + 1 samples; of the allocator those whose commands are not held."""
    u = case.samples(code, n + 1, rng)
    if case.block != "allocator":
        return u
    while True:
        u = np.concatenate((u[:1], u[1:][~code.outputs(record, u)["holding"]]))
        if len(u) > n:
            return u[: n + 1]
        u = np.concatenate((u, case.samples(code, n + 1, rng)))


def _compare(case: Any, y: Any, computed: dict[str, list[Any]]) -> None:
    for name, values in computed.items():
        rows = np.moveaxis(y[name], 0, -1).reshape(len(values), -1)
        if not all(np.array_equal(row, x) for row, x in zip(rows, values, strict=True)):
            raise InputError(
                f"{case.block}, {case.title}: {name}: {case.block}.c and evidence/rounding/operations.py give "
                "different bits; remedy: write the operations of the C there, in its order"
            )


def _table(code: FlightCode, of_cases: list[tuple[str, list[Row]]]) -> str:
    """A row an output, a column a range; the cell: bound, and measured in brackets."""
    units = {v.name: v.unit for v in code.interface.of("output")}
    rows = [
        (f"`{row.output}`", units[row.output] or "1", *(_cell(rows[i]) for _, rows in of_cases))
        for i, row in enumerate(of_cases[0][1])
    ]
    return markdown.table(rows, "|".join(("output", "unit", *(title for title, _ in of_cases))))


def _cell(row: Row) -> str:
    return f"{_up(row.bound)} ({_up(row.measured)})"


def _up(x: float) -> str:
    """To two digits, rounded up."""
    if x == 0.0:
        return "0"
    digit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return f"{math.ceil(x / digit) * digit:.1e}".replace("e-0", "e-").replace("e+0", "e")
