"""A log in flight as arrays: what gyro, magnetometer and photodiodes gave, and where the satellite was.

A file says what the log holds: `telemetry`, as a block's entry in a scenario has it, with the ports `omega_B_measured`,
`b_B_measured` and, where there are some, `sun_currents`; and `orbit: {tle: FILE}`. Tests:
tests/inflight/test_commands.py."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from orchestration.errors import InputError, hint
from orchestration.paths import located
from orchestration.quantities import parse_unit
from orchestration.scenario import complaints, text
from orchestration.scenario.telemetry import Telemetry
from orchestration.scenario.types import Model
from orchestration.telemetry.record import Record

from .orbit import Orbit, instant, orbit_at, read_elements

Floats = NDArray[np.float64]
PORTS = {"omega_B_measured": "rad/s", "b_B_measured": "T", "sun_currents": "1"}


class Elements(Model):
    """Source of the position."""

    tle: Annotated[str, Field(strict=True, min_length=1)]
    """A file of two-line element sets; of several the nearest counts."""


class Log(Model):
    """A file that says what a log holds."""

    telemetry: Telemetry
    orbit: Elements


@dataclass(frozen=True)
class Flight:
    """Rows of a log in which gyro and magnetometer have values."""

    name: str
    t: Floats
    """(n,) s"""
    omega: Floats
    """(n,3) rad/s, as measured"""
    m: Floats
    """(n,3) T, as measured"""
    currents: Floats
    """(n, faces); NaN where there is none; (n,0) without photodiodes"""
    orbit: Orbit
    notes: list[str]
    field_unit: str = "T"
    rate_unit: str = "rad/s"
    """Those of magnetometer and gyro in the log"""

    def part(self, chosen: NDArray[np.bool_]) -> Flight:
        """Some of its rows."""
        o = self.orbit
        orbit = Orbit(o.epoch, o.t[chosen], o.r_N[chosen], o.v_N[chosen], o.age)
        rows = (self.t[chosen], self.omega[chosen], self.m[chosen], self.currents[chosen])
        return Flight(self.name, *rows, orbit, self.notes, self.field_unit, self.rate_unit)


def read(path: Path) -> Flight:
    """Reads the log that a file describes. Raises InputError."""
    source = text.read(path)
    log = complaints.checked(Log, source)
    for name in log.telemetry.columns:
        if name not in PORTS:
            raise InputError(
                source.error(("telemetry", "columns", name), f"there is no use for {name!r}{hint(name, PORTS)}")
            )
    for name in ("omega_B_measured", "b_B_measured"):
        if name not in log.telemetry.columns:
            raise InputError(source.error(("telemetry", "columns"), f"expected a port {name}, found none"))
    with source.naming(("telemetry",)):
        file = located(log.telemetry.file, source.folder)
        record = Record(log.telemetry, file, log.telemetry.file)
        rows = _rows(record)
    with source.naming(("orbit", "tle")):
        sets = read_elements(located(log.orbit.tle, source.folder))
    return flight(path.stem, record, rows, sets)


def flight(name: str, record: Record, rows: Floats, sets: list[Any]) -> Flight:
    """The flight of a record's rows. Raises InputError where a port has another size or unit, or no element set is
    near."""
    columns: dict[str, Floats] = {}
    at = 1
    for port, column in record.entry.columns.items():
        size, unit = record.size(port), parse_unit(column.unit)
        if port != "sun_currents" and (size != 3 or not unit.fits(parse_unit(PORTS[port]))):
            raise InputError(f"{port}: expected 3 values in {PORTS[port]!r}, found {size} in {column.unit!r}")
        columns[port] = rows[:, at : at + size] * (unit.factor if port != "sun_currents" else 1.0)
        at += size
    whole = np.isfinite(np.hstack((columns["omega_B_measured"], columns["b_B_measured"]))).all(axis=1)
    if whole.sum() < 10:
        raise InputError(f"expected at least 10 rows with rate and field, found {whole.sum()}")
    if not np.ptp(columns["b_B_measured"][whole], axis=0).any():
        raise InputError("b_B_measured: expected a field that changes, found the same in all rows")
    t = rows[whole, 0]
    orbit = orbit_at(sets, instant(record.seen.first), t)
    currents = columns.get("sun_currents", np.empty((len(rows), 0)))[whole]
    return Flight(
        name,
        t,
        columns["omega_B_measured"][whole],
        columns["b_B_measured"][whole],
        currents,
        orbit,
        record.seen.notes(),
        *(record.entry.columns[name].unit for name in ("b_B_measured", "omega_B_measured")),
    )


def _rows(record: Record) -> Floats:
    return np.concatenate(list(record.stream()))
