"""The records of a folder: every CSV file with the columns of the public data; one with a column `sheet` holds
several."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from inflight.nutation import Motion
from inflight.orbit import read_elements
from inflight.records import Flight, flight
from orchestration import InputError
from orchestration.errors import Place, naming
from orchestration.scenario.telemetry import Telemetry
from orchestration.telemetry.record import Record
from orchestration.telemetry.rows import header_of

Floats = NDArray[np.float64]
COLUMNS: dict[str, dict[str, Any]] = {
    "omega_B_measured": {"of": ["gyro_x", "gyro_y", "gyro_z"], "unit": "deg/s"},
    "b_B_measured": {"of": ["mag_x", "mag_y", "mag_z"], "unit": "mG"},
    "sun_currents": {"of": ["sun2", "sun3", "sun4"]},
}
"""Currents of the faces -y, -x and -z; a file may be without them."""
SUN = "sun_currents"
TIME = {"column": "unix_s", "scale": "UTC", "epoch": "1970-01-01T00:00:00.5"}
"""A clock that counts whole seconds is half a second late on average."""
NORMALS = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def records(folder: Path, long: float) -> tuple[list[Flight], list[Motion]]:
    """Returns the flights of a folder that last at least `long` s, and the rates of the shorter ones; its .txt files
    hold element sets. Raises InputError."""
    files = sorted(folder.glob("*.csv"))
    texts = [path for path in sorted(folder.glob("*.txt")) if "\n1 " in "\n" + path.read_text("utf-8", "replace")]
    elements = [s for path in texts for s in read_elements(path)]
    if not files or not elements:
        raise InputError(
            f"--data {folder}: expected .csv files and a .txt file of element sets, found {len(files)} .csv"
        )
    flown: list[Flight] = []
    short: list[Motion] = []
    for path in files:
        for name, record, rows in _of(path):
            rate, both = (rows[np.isfinite(rows[:, 1:end]).all(axis=1)] for end in (4, 7))
            if len(both) >= 300 and np.ptp(both[:, 0]) >= long and np.ptp(both[:, 0]) < 20 * len(both):
                with naming(Place(path.name)):
                    flown.append(flight(name, record, rows, elements))
            elif len(rate) >= 10:
                short.append(Motion(name, rate[:, 0] - rate[0, 0], np.radians(rate[:, 1:4])))
    return flown, short


def _of(path: Path) -> Iterator[tuple[str, Record, Floats]]:
    where: list[dict[str, str]] = [{}]
    there = header_of(path, path.name).places
    columns = {name: column for name, column in COLUMNS.items() if name != SUN or there.keys() & set(column["of"])}
    if "sheet" in there:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.DictReader(line for line in file if not line.startswith("#"))
            where = [{"sheet": name} for name in dict.fromkeys(row["sheet"] for row in rows)]
    for chosen in where:
        entry = {"file": path.name, "time": TIME, "columns": columns, "where": chosen, "disordered": "sorted"}
        record = Record(Telemetry.model_validate(entry), path, path.name)
        yield chosen.get("sheet", path.stem), record, np.concatenate(list(record.stream()))
