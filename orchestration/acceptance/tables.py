"""Reads the two tables of a test vector, parameters.csv and vector.csv, and says the line of what is wrong.

Tests: tests/orchestration/acceptance/test_vector.py.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Container, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, reason
from ..fmu.model import Element, Floats, Model, Variable

_UNEVEN = 0.01
"""An interval may differ from the others by so much of it: times may be rounded."""

Lines = list[tuple[int, list[str]]]
"""The cells of each line that is not empty, and its number."""


def read_table(path: Path) -> tuple[list[str], Floats]:
    """Returns header and rows of a vector.csv, whose times are evenly spaced. Raises InputError."""
    (_, header), *rows = _lines(path, "a column 'time', then inputs and outputs, in two rows or more")
    if header[0] != "time" or len(rows) < 2:
        raise InputError(f"{path}: expected a column 'time', then inputs and outputs, in two rows or more")
    for line, cells in rows:
        if len(cells) != len(header):
            raise InputError(f"{path}:{line}: expected {len(header)} values, as in the header, found {len(cells)}")
    values = [
        [_number(text, f"{path}:{line}: {label}") for label, text in zip(header, cells, strict=True)]
        for line, cells in rows
    ]
    table = np.array(values)
    steps = np.diff(table[:, 0])
    step = float(np.median(steps))
    uneven = np.flatnonzero((steps <= 0.0) | (np.abs(steps - step) > _UNEVEN * step))
    if len(uneven):
        i = int(uneven[0])
        expected = f"{table[i, 0] + step:.10g} s, after {table[i, 0]:.10g} s" if step > 0.0 else "times that rise"
        raise InputError(f"{path}:{rows[i + 1][0]}: time: expected {expected}, found {table[i + 1, 0]:.10g}")
    return header, table


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Returns rows as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def columns_of(model: Model, header: list[str], folder: Path) -> dict[str, list[int]]:
    """Returns the columns of the elements of each input and output. Raises InputError."""
    path = folder / "vector.csv"
    labels = {v.label(p): Element(v.name, p) for v in model.of("input", "output") for p in range(v.size)}
    columns: dict[str, dict[int, int]] = {}
    for column, label in enumerate(header[1:], start=1):
        if label not in labels:
            raise InputError(f"{path}:1: {model.name} has no input or output {label!r}")
        name, position = labels[label]
        if position in columns.setdefault(name, {}):
            raise InputError(f"{path}:1: the column {label!r} is there twice")
        columns[name][position] = column
    for name, places in columns.items():
        if left := [e.position for e in model.variables[name].elements if e.position not in places]:
            raise InputError(f"{path}:1: expected a column {model.variables[name].label(left[0])!r}, too")
    return {name: [places[p] for p in sorted(places)] for name, places in columns.items()}


def parameters_of(model: Model, folder: Path, left_out: Container[str] = ()) -> dict[str, Any]:
    """Returns the vector's parameters, for a scenario; none where there is a header only. Raises InputError."""
    path = folder / "parameters.csv"
    (_, header), *rows = _lines(path, "a header 'name,value', then a parameter a line")
    if header != ["name", "value"]:
        raise InputError(f"{path}:1: expected the header 'name,value', found {','.join(header)!r}")
    values: dict[str, Any] = {}
    for line, cells in rows:
        if len(cells) != 2:
            raise InputError(f"{path}:{line}: expected a name and a value, found {','.join(cells)!r}")
        label, text = cells
        name, key = label.partition("[")[0], label.replace("][", ",")
        variable = model.variables.get(name)
        if variable is None or variable.causality != "parameter":
            raise InputError(f"{path}:{line}: {model.name} has no parameter {label!r}")
        if key in values:
            raise InputError(f"{path}:{line}: the parameter {label!r} is there twice")
        if name not in left_out:
            values[key] = _value(variable, text, f"{path}:{line}: {label}")
    return values


def _lines(path: Path, expected: str) -> Lines:
    """Returns at least one line. Raises InputError."""
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: it is no regular file; expected {expected}")
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}; expected a test vector, as 'orchestrate new' writes it") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: expected text in UTF-8") from None
    reader = csv.reader(io.StringIO(text, newline=""))
    try:
        lines = [(reader.line_num, cells) for cells in reader if cells]
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: expected cells with commas between them: {error}") from None
    if not lines:
        raise InputError(f"{path}: it is empty; expected {expected}")
    return lines


def _value(variable: Variable, text: str, place: str) -> Any:
    if variable.type == "string":
        return text
    number = _number(text, place)
    if variable.type == "boolean":
        return number != 0.0
    if variable.type == "real":
        return number
    if number != int(number):
        raise InputError(f"{place}: expected a whole number, found {text!r}")
    if variable.type == "enumeration":
        return {number: item for item, number in variable.items}.get(int(number), text)
    return int(number)


def _number(text: str, place: str) -> float:
    """Returns a finite number. Raises InputError."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{place}: expected a number, found {text!r}")
    return number
