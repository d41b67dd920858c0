"""A day at a ground station and 100 orbits of hold with sets of wheels: docs/evidence/wheels_long.csv.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestration import InputError, run

from .. import files
from ..crew import crew
from ..flight.schemes import Data, base_of, change
from ..paper import ROOT
from ..satellites.classes import CLASSES, FIELD, SHARES
from .cases import CONDITIONS, WHEELS, Flights, scenario, with_set

FILE = ROOT / "docs" / "evidence" / "wheels_long.csv"
DAY, HOLD = "a day at a ground station", "100 orbits of hold, all errors"
DURATION = {DAY: 86400.0, HOLD: 6e5}
TARGET = 6
"""The supervisor's mode in which a station is followed."""
BEGIN, INTERVAL = 3000.0, 5.0
"""s: from which on it is judged, and between its records."""


@dataclass(frozen=True)
class Long:
    """Errors in deg, from BEGIN on."""

    flight: str
    satellite: str
    rms: float
    largest: float
    wheel_share: float
    """The fullest wheel, of its limit."""


def _day(satellite: str) -> Data:
    """The station is followed all the time, above and below the horizon, by the sensors of track_ground_station."""
    data = base_of("track_ground_station")
    for entry in data["blocks"].values():
        entry.setdefault("every", 1)
    data = with_set(data, satellite)
    data.pop("phases", None)
    data["timeline"] = [{"at": 600.0, "set": {"supervisor.command": TARGET}}]
    return change(data, {"sensors.h_w": 0.0})


def _hold(satellite: str) -> Data:
    """The first drawn errors of the tumbles, from the target at rest."""
    flights = Flights(satellite, "errors")
    data = change(scenario(flights, CONDITIONS["errors"]), flights.drawn(1)[0])
    push = SHARES[True] * CLASSES[satellite].dipole_max * FIELD * np.ones(3) / math.sqrt(3.0)
    for name in ("omega_B0", "omega_LVLH_B0"):
        data["blocks"]["plant"]["start"].pop(name, None)
    rest = {"plant.Q0": np.eye(3), "plant.omega_LVLH_B0": [0.0] * 3, "plant.disturbance_torque_B": push}
    return change(data, rest)


def fly(which: tuple[str, str]) -> Long:
    """Flies one: its name and the satellite."""
    name, satellite = which
    data = _day(satellite) if name == DAY else _hold(satellite)
    signals = ["judge.attitude_error", "plant.h_w", *(["supervisor.mode"] if name == DAY else [])]
    record = {"interval": INTERVAL, "signals": signals}
    result = run({**data, "duration": DURATION[name], "record": record})
    late = result.time >= BEGIN
    if name == DAY and not (result["supervisor.mode"][late] == TARGET).all():
        raise InputError(f"{name}, {satellite}: the station was not followed all the time")
    angle = np.degrees(result["judge.attitude_error"][late])
    share = float(np.abs(result["plant.h_w"][late]).max()) / CLASSES[satellite].wheel_momentum_max
    return Long(name, satellite, math.sqrt(float((angle**2).mean())), float(angle.max()), share)


def make(jobs: int) -> Iterator[str]:
    """Flies them, and writes the file."""
    wanted = [(name, satellite) for name in DURATION for satellite in WHEELS]
    with crew(jobs) as hands:
        files.save(Long, FILE, hands.each("long flights", fly, wanted), 4)
    yield f"written: {FILE}"


def load() -> list[Long]:
    return files.load_if_any(Long, FILE, "python -m evidence wheels --part long")
