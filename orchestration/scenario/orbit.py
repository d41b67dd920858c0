"""An orbit by element sets in a scenario: a block's position and velocity as a record, or a plant that follows them.

Which start values and columns an orbit has is known by a package that registers itself under `orchestrate.orbits`; here
they are names and numbers. Tests: tests/orchestration/scenario/test_orbit.py."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fmus import places

from ..errors import InputError, writing
from ..paths import located
from .source import Source
from .types import Model, Period

KIND = "tle"
STEP = 1.0
"""s"""
ROWS_MAX = 2_000_000
MARGIN = 60.0
"""s of rows before the start and behind the end, for times that are shifted."""


class OrbitEntry(Model):
    """Position and velocity by SGP4."""

    tle: Annotated[str, Field(strict=True, min_length=1)]
    """A file of two-line element sets, relative to the scenario; of several the nearest to the start counts."""
    start: Annotated[str, Field(strict=True, min_length=1)]
    """The instant of t = 0 in UTC, ISO 8601."""
    step: Period | None = None
    """Time from row to row; default: 1 s."""


class Ephemeris(NamedTuple):
    """Ephemeris that a registered package makes of element sets at some times."""

    columns: dict[str, tuple[str, NDArray[np.float64]]]
    """By ports, with units; (n, elements)."""
    followed: Callable[[], tuple[dict[str, Any], str]]
    """Returns start values with which a block follows it, and how near."""


def resolved(source: Source, name: str, entry: Any, duration: float) -> Source:
    """Returns the scenario with a record in the place of a block's `orbit`, or, where the block is an FMU, with start
    values by which it follows it over the run; those that are given go before. Raises InputError."""
    orbit: OrbitEntry = entry.orbit
    key = ("blocks", name, "orbit")
    step = orbit.step or STEP
    if not entry.fmu and duration / step > ROWS_MAX:
        raise InputError(source.error((*key, "step"), f"expected at most {ROWS_MAX} rows, found {duration / step:.0f}"))
    with source.naming((*key, "tle")):
        path = located(orbit.tle, source.folder)
        margin = 0.0 if entry.fmu else MARGIN
        times = np.arange(-margin, duration + margin + step, max(step, duration / ROWS_MAX))
        found = _provider()(path, orbit.start, times)
    changed = source.with_entry(key, None)
    if entry.fmu:
        start, near = found.followed()
        told = changed.notes if start.keys() & entry.start.keys() else (*changed.notes, f"{name}: {near}")
        return replace(changed.with_entry(("blocks", name, "start"), start | dict(entry.start)), notes=told)
    return changed.with_entry(("blocks", name, "telemetry"), _record(path, orbit, times, found))


def _record(path: Path, orbit: OrbitEntry, times: NDArray[np.float64], found: Ephemeris) -> dict[str, Any]:
    """Writes the rows, once, and returns the entry of a record that reads them."""
    columns: dict[str, Any] = {}
    header, values = ["t"], [times]
    for port, (unit, table) in found.columns.items():
        names = [f"{port}{i + 1}" for i in range(table.shape[1])]
        columns[port] = {"of": names, "unit": unit, "required": True}
        header += names
        values += list(table.T)
    table = np.column_stack(values)
    digest = hashlib.sha256(table.tobytes()).hexdigest()[:16]
    file = places.work() / "ephemeris" / f"{path.stem}-{digest}.csv"
    if not file.exists():
        with writing(file):
            file.parent.mkdir(parents=True, exist_ok=True)
            part = file.with_suffix(".part")
            with part.open("w", newline="", encoding="utf-8") as out:
                writer = csv.writer(out, lineterminator="\n")
                writer.writerow(header)
                writer.writerows(table.tolist())
            part.replace(file)
    return {"file": str(file), "time": {"column": "t", "scale": "elapsed"}, "columns": columns}


Provider = Callable[[Path, str, NDArray[np.float64]], Ephemeris]


@cache
def _provider() -> Provider:
    found: Mapping[str, Any] = {point.name: point for point in entry_points(group="orchestrate.orbits")}
    try:
        provider: Provider = found[KIND].load()
    except (KeyError, ModuleNotFoundError):
        raise InputError("element sets need SGP4; remedy: pip install 'attitude-cosim[inflight]'") from None
    return provider
