"""Values of a record's ports: columns of a block as numbers, in the port's unit, corrected, NaN where missing.

Tests: tests/orchestration/telemetry/test_record.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..errors import InputError, Place, Problem
from ..quantities import QuantityError, parse_unit
from ..scenario.telemetry import Column
from .rows import Block, Header
from .times import number

Floats = NDArray[np.float64]


def check(header: Header, columns: Mapping[str, Column]) -> None:
    """Raises InputError where a port's columns are not in the header, or its unit or correction does not fit them."""
    for name, column in columns.items():
        for cell in column.cells:
            header.place(cell)
            stated = header.units.get(cell)
            try:
                fits = stated is None or parse_unit(stated).fits(parse_unit(column.unit))
            except QuantityError:
                fits = False
            if not fits:
                text = f"the unit {stated!r} of this column does not fit {column.unit!r} of {name}"
                raise InputError(Problem(text, place=Place(header.file, header.line, cell)))
        _check_correction(name, column)


def _check_correction(name: str, column: Column) -> None:
    width, offset = len(column.cells), column.offset
    widths = {len(row) - 1 if isinstance(row, list) else len(offset) for row in offset} if offset else set()
    if offset is not None and widths != {width}:
        raise InputError(f"{name}: offset: expected {width} numbers, or rows of time and {width} numbers")
    if column.matrix is not None and any(len(row) != width for row in column.matrix):
        raise InputError(f"{name}: matrix: expected rows of {width} numbers")
    for key in ("offset", "matrix", "gain"):
        if not all(np.isfinite(row).all() for row in getattr(column, key) or ()):
            raise InputError(f"{name}: {key}: expected finite numbers, found one that is not")
    for key in ("offset", "gain"):
        knots = [row[0] for row in getattr(column, key) or () if not isinstance(row, float)]
        if knots != sorted(knots):
            raise InputError(f"{name}: {key}: expected rows in the order of their times")


def values(block: Block, at: int, header: Header, columns: Mapping[str, Column], times: Floats) -> Iterator[Floats]:
    """Returns each port's values (n, elements) in turn; `at` is the place of the first one's columns in the block."""
    for name, column in columns.items():
        cells = column.cells
        raw = np.column_stack([_floats(block, block.columns[at + i], cell) for i, cell in enumerate(cells)])
        raw[np.isin(raw, column.missing) | ~np.isfinite(raw)] = np.nan  # 1e999 is no number either
        if column.required and len(bad := np.argwhere(~np.isfinite(raw))):
            row, k = bad[0]
            text = f"expected a value, since {name} is required, found {block.columns[at + k][row]!r}"
            raise block.error(int(row), cells[k], text)
        for i, stated in enumerate(map(header.units.get, cells)):
            if stated is not None and stated != column.unit:
                factor, zero = parse_unit(stated).conversion(parse_unit(column.unit))
                raw[:, i] = raw[:, i] * factor + zero
        at += len(cells)
        yield corrected(raw, column, times) if column.quaternion is None else _matrices(raw, column, block)


def _matrices(quaternions: Floats, column: Column, block: Block) -> Floats:
    """The matrices (n, 9), row by row; NaN where a component is missing."""
    last = column.quaternion == "scalar last"
    found = np.full((len(quaternions), 9), np.nan)
    for row in np.flatnonzero(np.isfinite(quaternions).all(axis=1)).tolist():
        q = quaternions[row].tolist()
        try:
            R = rotation.matrix([q[3], *q[:3]] if last else q)
        except ValueError as error:
            raise block.error(row, column.cells[0], str(error)) from None
        found[row] = rotation.transposed(R) if column.inverse else R
    return found


def corrected(raw: Floats, column: Column, times: Floats) -> Floats:
    """Returns matrix (gain(t) raw - offset), rows (n, elements)."""
    values = raw
    if column.gain:
        knots, factors = np.array(column.gain).T
        values = values * np.interp(times, knots, factors)[:, None]
    if column.offset is not None:
        offset = np.array(column.offset)
        if offset.ndim == 2:
            offset = np.column_stack([np.interp(times, offset[:, 0], taken) for taken in offset[:, 1:].T])
        values = values - offset
    if column.matrix is not None:
        values = values @ np.array(column.matrix).T
    return values


def _floats(block: Block, cells: Sequence[str], name: str) -> Floats:
    with suppress(ValueError):
        return np.array([number(cell) if cell else np.nan for cell in cells])
    for row, cell in enumerate(cells):
        if cell.strip() and not are_numbers([cell]):
            comma = ", whose comma has to be a point" if are_numbers([cell.replace(",", ".")]) else ""
            raise block.error(row, name, f"expected a number, found {cell!r}{comma}")
    return np.array([number(cell) if cell.strip() else np.nan for cell in cells])


def are_numbers(cells: Sequence[str]) -> bool:
    try:
        [number(cell) for cell in cells]
    except ValueError:
        return False
    return True
