"""The formats of a run's signals.

The first column is `time`; then comes `block.variable`, with `[i]` for an element of a vector and `[i][j]` for one of a
matrix, since common readers split at commas even between quotes. Numbers in CSV are the shortest decimals that read
back as the same doubles; booleans are 0 and 1. MAT has a struct for each block, with whole vectors and matrices as
fields. Names are written as fmu/names.py says.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import to_json

from ..errors import InputError
from ..fmu.model import Model
from ..fmu.names import field, unescaped
from ..system import signals
from ..system.wiring import Node
from .data import RunData

_ROWS = 128
"""Rows of CSV that are made at a time: few enough to stay in the processor's cache."""
_FIELD_MAX = 63
"""Characters that MATLAB reads of the name of a field."""
_TOP = ("time", "units")
"""What stands in a MAT file beside the blocks."""


def check(format: str) -> None:
    """Refuses a format that is unknown, or whose package is not installed."""
    if format not in FORMATS:
        raise InputError(f"there is no format {format!r}; expected one of {', '.join(FORMATS)}")
    package = FORMATS[format][1]
    if package and importlib.util.find_spec(package) is None:
        raise InputError(f"--format {format} needs the package {package}: pip install {package}")


def check_names(columns: Iterable[Node], models: Mapping[str, Model], format: str) -> None:
    """Refuses names that a format has no room for, before a run is spent on them."""
    if format != "mat":
        return
    for name in signals.names(columns, models):
        for part in _fields(name):
            if len(part) > _FIELD_MAX:
                message = f"--format mat: the name {part} of {name} has {len(part)} characters; "
                message += f"MATLAB reads at most {_FIELD_MAX}"
                raise InputError(f"{message}; remedy: --format csv or parquet, or leave it out of record.signals")


def write(result: RunData, folder: Path, format: str) -> None:
    """Writes the signals into a folder."""
    FORMATS[format][0](result, folder / f"signals.{format}")


def _csv(result: RunData, path: Path) -> None:
    with path.open("wb") as file:
        file.write(",".join(["time", *result.labels]).encode() + b"\n")
        for first in range(0, len(result.time), _ROWS):
            part = slice(first, first + _ROWS)
            rows = np.column_stack([result.time[part], result.samples[part]]).tolist()
            file.write(to_json(rows)[2:-2].replace(b"],[", b"\n") + b"\n")  # the fastest writer of shortest decimals


def _parquet(result: RunData, path: Path) -> None:
    """Each column says its unit in its field's metadata, under `unit`."""
    import pyarrow  # optional, and slow to import  # noqa: PLC0415
    import pyarrow.parquet  # optional, and slow to import  # noqa: PLC0415

    units = {
        "time": "s",
        **{label: result.unit_of_column(node) for label, node in zip(result.labels, result.columns, strict=True)},
    }
    schema = pyarrow.schema(
        [pyarrow.field(n, pyarrow.float64(), metadata={"unit": u} if u else None) for n, u in units.items()]
    )
    arrays = [result.time] + [np.ascontiguousarray(column) for column in result.samples.T]
    pyarrow.parquet.write_table(pyarrow.table(arrays, schema=schema), path)


def _mat(result: RunData, path: Path) -> None:
    """`units` has the same structs and fields as the blocks, with text."""
    from scipy.io import savemat  # slow to import  # noqa: PLC0415

    blocks: dict[str, dict[str, Any]] = {}
    units: dict[str, dict[str, str]] = {}
    for name in result:
        block, variable = _fields(name)
        blocks.setdefault(block, {})[variable] = result[name]
        units.setdefault(block, {})[variable] = result.units[name]
    content = {"time": result.time, "units": {"time": "s", **units}, **blocks}
    savemat(path, content, oned_as="column", long_field_names=True, do_compression=True)


def _fields(name: str) -> tuple[str, str]:
    """Returns what a MAT file calls the block and the variable of a signal."""
    block, _, variable = name.partition(".")
    return field(block, _TOP), field(unescaped(variable))


FORMATS: dict[str, tuple[Callable[[RunData, Path], None], str]] = {
    "csv": (_csv, ""),
    "parquet": (_parquet, "pyarrow"),
    "mat": (_mat, "scipy"),
}
"""How each format is written, and the package that it needs."""
