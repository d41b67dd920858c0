"""The records of a folder: every CSV or Parquet file, with the columns of the public data or those of `columns.yaml`;
one with a column `sheet` holds several."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from inflight.nutation import Motion
from inflight.orbit import read_elements
from inflight.records import Flight, flight
from orchestration import InputError
from orchestration.errors import Place, naming
from orchestration.quantities import parse_unit
from orchestration.scenario import complaints, text
from orchestration.scenario.telemetry import Column, Telemetry, TimeColumn
from orchestration.scenario.types import Model
from orchestration.telemetry.record import Record
from orchestration.telemetry.rows import blocks, header_of

Floats = NDArray[np.float64]
SUN = "sun_currents"
"""Currents of the faces -y, -x and -z; a file may be without them."""
NORMALS = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
COLUMNS, NAMED = "columns.yaml", ("omega_B_measured", "b_B_measured")


_PUBLIC = {
    NAMED[0]: {"of": ["gyro_x", "gyro_y", "gyro_z"], "unit": "deg/s"},
    NAMED[1]: {"of": ["mag_x", "mag_y", "mag_z"], "unit": "mG"},
    SUN: {"of": ["sun2", "sun3", "sun4"]},
}


class Layout(Model):
    """Columns of a folder's files, from its file `columns.yaml`; by default those of the public data."""

    time: TimeColumn = TimeColumn(column="unix_s", scale="UTC", epoch="1970-01-01T00:00:00.5")
    """A clock that counts whole seconds is half a second late on average."""
    columns: Annotated[dict[str, Column], Field(min_length=1)]
    record: str = "sheet"
    """The column that tells the records of a file apart, where there is one."""


def records(folder: Path, long: float) -> tuple[list[Flight], list[Motion]]:
    """Returns the flights of a folder that last at least `long` s, and the rates of the shorter ones; its .txt files
    hold element sets. Raises InputError."""
    files = sorted(path for path in folder.iterdir() if path.suffix in (".csv", ".parquet"))
    texts = [path for path in sorted(folder.glob("*.txt")) if "\n1 " in "\n" + path.read_text("utf-8", "replace")]
    elements = [s for path in texts for s in read_elements(path)]
    if not files or not elements:
        raise InputError(
            f"--data {folder}: expected .csv or .parquet files and a .txt file of element sets, found {len(files)} "
            f"and {len(elements)} element sets"
        )
    layout = _layout(folder / COLUMNS)
    flown: list[Flight] = []
    short: list[Motion] = []
    for path in files:
        for name, record, rows in _of(path, layout):
            rate, both = (rows[np.isfinite(rows[:, 1:end]).all(axis=1)] for end in (4, 7))
            if len(both) >= 300 and np.ptp(both[:, 0]) >= long and np.ptp(both[:, 0]) < 20 * len(both):
                with naming(Place(path.name)):
                    flown.append(flight(name, record, rows, elements))
            elif len(rate) >= 10:
                factor = parse_unit(layout.columns[NAMED[0]].unit).factor
                short.append(Motion(name, rate[:, 0] - rate[0, 0], factor * rate[:, 1:4]))
    return flown, short


def _layout(path: Path) -> Layout:
    if not path.exists():
        return Layout.model_validate({"columns": _PUBLIC})
    source = text.read(path)
    layout = complaints.checked(Layout, source)
    for name, size in (*zip(NAMED, (3, 3), strict=True), (SUN, len(NORMALS))):
        found = layout.columns.get(name)
        if (found is None and name != SUN) or (found is not None and found.shape != (size,)):
            raise InputError(source.error(("columns",), f"expected {name} of {size} columns"))
    columns = {name: layout.columns[name] for name in (*NAMED, SUN) if name in layout.columns}
    return layout.model_copy(update={"columns": columns})


def _of(path: Path, layout: Layout) -> Iterator[tuple[str, Record, Floats]]:
    header = header_of(path, path.name)
    there = header.places.keys()
    columns = {n: column for n, column in layout.columns.items() if n != SUN or there & set(column.cells)}
    where: list[dict[str, str]] = [{}]
    if layout.record in there:
        names = dict.fromkeys(cell for block in blocks(path, header, [layout.record]) for cell in block.columns[0])
        where = [{layout.record: name} for name in names]
    for chosen in where:
        entry: dict[str, Any] = {"file": path.name, "time": layout.time, "columns": columns, "where": chosen}
        record = Record(Telemetry.model_validate(entry | {"disordered": "sorted"}), path, path.name)
        yield chosen.get(layout.record, path.stem), record, np.concatenate(list(record.stream()))
