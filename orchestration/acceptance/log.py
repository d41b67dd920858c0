"""A recorded log against an FMU, open loop: the log's inputs are played into it, its outputs compared with the log's.

Tests: tests/orchestration/telemetry/test_log.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from ..errors import InputError, hint
from ..fmu.model import Floats, Variable
from ..paths import located
from ..quantities import ONE, parse_unit
from ..scenario import complaints, text
from ..scenario.references import Name
from ..scenario.source import Source
from ..scenario.telemetry import Telemetry
from ..scenario.types import Model, Period, Value
from ..swap.findings import Finding, Fit
from ..telemetry.record import Record
from .vector import compared

STEPS_MAX = 5_000_000
"""Of the FMU; all of them are in memory."""


class Log(Model):
    """A file that says what a recorded log holds."""

    telemetry: Telemetry
    """The file and its columns, called as our inputs and outputs."""
    step: Period | None = None
    """The step of the FMU. Default: the median time between two rows."""
    start: dict[Name, Value] = Field(default_factory=dict)
    """Values of parameters, as in a scenario."""


def against_log(fmu: Path, fitted: Fit, interface: str, path: Path, tolerance: float) -> list[Finding]:
    """Returns how far an FMU's outputs are from those of a log, one finding an output. Raises InputError."""
    source = text.read(path)
    log = complaints.checked(Log, source)
    ports = {v.name: v for v in fitted.reference.model.of("input", "output")}
    for name in log.telemetry.columns:
        if name not in ports:
            text_ = f"{fitted.reference.name} has no input or output {name!r}{hint(name, ports)}"
            raise InputError(source.error(("telemetry", "columns", name), text_))
    with source.naming(("telemetry",)):
        record = Record(log.telemetry, located(log.telemetry.file, source.folder), log.telemetry.file)
        table = np.concatenate(list(record.stream()))
    step = log.step or record.seen.step
    count = int(table[-1, 0] / step + 1e-6) + 1
    if step <= 0.0 or count < 2:
        raise InputError(source.error(("telemetry", "file"), "expected rows at two instants or more, from t = 0 on"))
    if count > STEPS_MAX:
        text_ = f"expected at most {STEPS_MAX} steps to the last row, found {count} of {step:.6g} s"
        remedy = f"'start' at the first row, {table[0, 0]:.10g} s from t = 0, or a longer step"
        raise InputError(source.error(("telemetry", "file"), text_, remedy=remedy))
    place = np.rint(table[:, 0] / step).astype(int)
    table, place = table[(place >= 0) & (place < count)], place[(place >= 0) & (place < count)]
    values: dict[str, Floats] = {}
    at = 1
    for name in log.telemetry.columns:
        size = record.size(name)
        grid = np.full((count, size), np.nan)
        grid[place] = _in_unit(table[:, at : at + size], ports[name], log.telemetry, name, source)
        values[name] = grid
        at += size
    inputs: dict[str, Any] = {}
    for name in (name for name in values if ports[name].causality == "input"):
        with source.naming(("telemetry", "columns", name)):
            held = _held(values[name], name)
        inputs[name] = held.reshape(count, *ports[name].shape).astype(ports[name].dtype)
    expected = {n: grid for n, grid in values.items() if ports[n].causality == "output" and np.isfinite(grid).any()}
    if not expected:
        raise InputError(source.error(("telemetry", "columns"), "expected an output with a value, found none"))
    start: dict[str, Any] = {str(name): value for name, value in log.start.items()}
    time: Floats = step * np.arange(count, dtype=np.float64)
    tolerances = dict.fromkeys(expected, tolerance)
    with source.naming(("telemetry", "columns")):
        return compared(fmu, fitted, interface, time, inputs, expected, start, tolerances, "log")


def _in_unit(values: Floats, port: Variable, entry: Telemetry, name: str, source: Source) -> Floats:
    unit = parse_unit(entry.columns[name].unit)
    if values.shape[1] != port.size or not unit.fits(port.unit or ONE):
        found = f"{values.shape[1]} values in {str(unit)!r}"
        expected = f"{port.size} values in {str(port.unit or ONE)!r}"
        raise InputError(source.error(("telemetry", "columns", name), expected=expected, found=found))
    factor, offset = unit.conversion(port.unit or ONE)
    return values * factor + offset


def _held(grid: Floats, name: str) -> Floats:
    """Returns the last sample at each instant; the first one before it."""
    whole = np.isfinite(grid).all(axis=1)
    if not whole.any():
        raise InputError(f"{name}: expected a sample, found none")
    last = np.maximum.accumulate(np.where(whole, np.arange(len(grid)), -1))
    return grid[np.where(last < 0, int(whole.argmax()), last)]
