"""The folder of a run: signals, manifest, expectations, and a page that shows them.

It takes the place of what an earlier run left in it; files that are not a run's own are not touched. Its files
get their names only when all of them are complete, the manifest last.

`signals.csv` has `time` as its first column and then `block.variable`, with `[i]` for an element of a
vector and `[i][j]` for one of a matrix, since common readers split at commas even between quotes.
Numbers are the shortest decimals that read back as the same doubles; booleans are 0 and 1.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

import numpy as np
from pydantic_core import to_json

from ..errors import InputError, ResultsError
from . import report
from .data import RunData, json_text

_ROWS = 4096
"""Rows of CSV that are made at a time."""


def write(result: RunData, folder: Path, format: str = "csv") -> Path:
    """Writes the folder and returns it. Raises ResultsError where it cannot be written; nothing of a run is then in it.

    Of a run that did not come to its first sample there are no signals.
    """
    check(format)
    expected = {
        "complete": _complete(result),
        "passed": result.passed,
        "expectations": [asdict(outcome) for outcome in result.outcomes],
        "holds": [{**asdict(hold), "text": hold.text} for hold in result.holds],
    }
    files: dict[str, Callable[[Path], None]] = {
        "expectations.json": lambda path: _json(path, expected),
        "manifest.json": lambda path: _json(path, result.manifest),  # the last one, since it vouches for the others
    }
    if len(result.time):
        files = {f"signals.{format}": lambda path: FORMATS[format][0](result, path), **files}
    parts = {folder / name: folder / f"{name}.part" for name in files}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("manifest.json", "expectations.json", "report.html", *(f"signals.{name}" for name in FORMATS)):
            (folder / name).unlink(missing_ok=True)
        for path, part in parts.items():
            files[path.name](part)
        for path, part in parts.items():
            os.replace(part, path)
    except OSError as error:
        where = str(error.filename or folder).removesuffix(".part")
        problem = ResultsError(f"the results cannot be written: {where}: {error.strerror or error}")
        problem.result = result
        raise problem from None
    finally:
        for part in parts.values():
            with suppress(OSError):
                part.unlink(missing_ok=True)
    _report(result, folder)
    return folder


def _report(result: RunData, folder: Path) -> None:
    """Writes the page. Where that fails, the results stand without it, and a warning of the run says why."""
    path, part = folder / "report.html", folder / "report.html.part"
    try:
        report.write(result, part)
        os.replace(part, path)
    except Exception as error:
        result.warnings.append(f"{path} cannot be written: {type(error).__name__}: {error}")
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def check(format: str) -> None:
    """Refuses a format that is unknown, or whose package is not installed."""
    if format not in FORMATS:
        raise InputError(f"there is no format {format!r}; expected one of {', '.join(FORMATS)}")
    package = FORMATS[format][1]
    if package and importlib.util.find_spec(package) is None:
        raise InputError(f"--format {format} needs the package {package}: pip install {package}")


def check_writable(folder: Path) -> None:
    """Refuses a folder that could not be written, before a run is spent on it."""
    existing = next((p for p in (folder, *folder.absolute().parents) if p.exists()), folder)
    if not existing.is_dir():
        raise InputError(f"the results cannot be written to {folder}: {existing} is a file")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"the results cannot be written to {folder}: {existing} is not writable")


def _complete(result: RunData) -> bool:
    return result.failure is None and not result.interrupted


def _json(path: Path, data: object) -> None:
    path.write_text(json_text(data) + "\n", "utf-8")


def _csv(result: RunData, path: Path) -> None:
    with path.open("wb") as file:
        file.write(",".join(["time", *result.labels]).encode() + b"\n")
        for first in range(0, len(result.time), _ROWS):
            part = slice(first, first + _ROWS)
            rows = np.column_stack([result.time[part], result.samples[part]]).tolist()
            file.write(to_json(rows)[2:-2].replace(b"],[", b"\n") + b"\n")  # the fastest writer of shortest decimals


def _parquet(result: RunData, path: Path) -> None:
    import pyarrow  # optional, and slow to import
    import pyarrow.parquet

    arrays = [result.time] + [np.ascontiguousarray(column) for column in result.samples.T]
    pyarrow.parquet.write_table(pyarrow.table(arrays, names=["time", *result.labels]), path)


def _mat(result: RunData, path: Path) -> None:
    """A struct for each block, with whole vectors and matrices as fields; `time` beside them."""
    from scipy.io import savemat  # slow to import

    blocks: dict[str, dict[str, object]] = {}
    for name in result:
        block, _, variable = name.partition(".")
        field = "".join(c if c.isalnum() else "_" for c in variable).strip("_")
        blocks.setdefault(block, {})[field] = result[name]
    savemat(path, {"time": result.time, **blocks}, oned_as="column", long_field_names=True, do_compression=True)


FORMATS: dict[str, tuple[Callable[[RunData, Path], None], str]] = {
    "csv": (_csv, ""),
    "parquet": (_parquet, "pyarrow"),
    "mat": (_mat, "scipy"),
}
"""How each format is written, and the package that it needs."""
