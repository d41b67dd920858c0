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
from orchestration.scenario.telemetry import Telemetry
from orchestration.telemetry.record import Record
from orchestration.telemetry.rows import header_of

Floats = NDArray[np.float64]
COLUMNS: dict[str, dict[str, Any]] = {
    "omega_B_measured": {"of": ["gyro_x", "gyro_y", "gyro_z"], "unit": "deg/s"},
    "b_B_measured": {"of": ["mag_x", "mag_y", "mag_z"], "unit": "mG"},
    "sun_currents": {"of": ["sun2", "sun3", "sun4"]},
}
"""Currents of the faces -y, -x and -z."""
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
            rate = rows[np.isfinite(rows[:, 1:4]).all(axis=1)]
            if len(rate) >= 300 and np.ptp(rate[:, 0]) >= long and rate[-1, 0] < 20 * len(rate):
                flown.append(flight(name, record, rows, elements))
            elif len(rate) >= 10:
                short.append(Motion(name, rate[:, 0] - rate[0, 0], np.radians(rate[:, 1:4])))
    return flown, short


def _of(path: Path) -> Iterator[tuple[str, Record, Floats]]:
    where: list[dict[str, str]] = [{}]
    if "sheet" in header_of(path, path.name).places:
        with path.open(newline="", encoding="utf-8") as file:
            rows = csv.DictReader(line for line in file if not line.startswith("#"))
            where = [{"sheet": name} for name in dict.fromkeys(row["sheet"] for row in rows)]
    for chosen in where:
        entry = {"file": path.name, "time": {"column": "unix_s", "scale": "UTC"}, "columns": COLUMNS, "where": chosen}
        record = Record(Telemetry.model_validate(entry), path, path.name)
        yield chosen.get("sheet", path.stem), record, np.concatenate(list(record.stream()))
