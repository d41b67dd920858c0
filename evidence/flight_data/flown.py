"""A record through the shipped estimator in C: its columns, calibrated, in the place of sensors, by a scenario.

The estimator starts from nothing, by its bank; gyro bias and scale are its own. Photodiodes are left out."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from estimator.bank import Noise
from inflight.attitude import Attitudes
from inflight.magnetometer import Calibration
from inflight.records import Flight
from orchestration import run

WHOLE = 1e-6
"""s: the estimator steps at whole seconds, as the rows of these records are."""


def scenario(file: Path, flight: Flight, calibration: Calibration, noise: Noise) -> dict[str, Any]:
    """The scenario of a record: telemetry and ephemeris in the place of sensors, the magnetometer as calibrated."""
    given = {key: calibration.data()[key] for key in ("matrix", "offset", "gain")}
    ports = {
        f"{name}_measured": {"of": [f"{name}{i}" for i in "123"], "unit": unit}
        for name, unit in (("omega_B", "rad/s"), ("b_B", "T"), ("r_N", "m"), ("v_N", "m/s"))
    }
    measured = {"omega_B_measured": ports.pop("omega_B_measured"), "b_B_measured": ports.pop("b_B_measured") | given}
    time = {"column": "t", "scale": "elapsed"}
    return {
        "name": "flight_data",
        "step": 1.0,
        "duration": math.ceil(flight.t[-1]),
        "blocks": {
            "sensors": {"telemetry": {"file": str(file), "time": time, "columns": measured}},
            "gnss": {"telemetry": {"file": str(file), "time": time, "columns": ports}},
            "estimator": {
                "fmu": "estimator",
                "start": {
                    "epoch": flight.orbit.utc,
                    "field_noise": noise.field,
                    "field_degree": 13,
                    "angle_random_walk": noise.angle,
                    "rate_random_walk": noise.bias_walk,
                    "rate_bias_sigma": noise.bias,
                    "rate_scale_sigma": noise.scale,
                    "gate": noise.gate,
                    "bank": True,
                },
            },
        },
        "connections": [
            *(f"sensors.{name}_measured -> estimator.{name}_measured" for name in ("omega_B", "b_B")),
            "sensors.omega_B_measured_sample -> estimator.rate_sample",
            "sensors.b_B_measured_sample -> estimator.field_sample",
            *(f"gnss.{name}_measured -> estimator.{name}_measured" for name in ("r_N", "v_N")),
            "gnss.r_N_measured_sample -> estimator.orbit_sample",
        ],
        "record": {
            "signals": [f"estimator.{name}" for name in ("R_NB", "omega_B", "nis", "ambiguity", "attitude_valid")]
            + [f"estimator.{name}" for name in ("rate_bias_B", "rate_scale_B")]
        },
    }


def through_the_estimator(flight: Flight, calibration: Calibration, noise: Noise) -> Attitudes | None:
    """Its attitudes at the record's rows; ambiguous where it says that its attitude is not valid. None where rows are
    not at whole seconds."""
    if np.abs(flight.t - np.rint(flight.t)).max() > WHOLE:
        return None
    with TemporaryDirectory() as folder:
        file = Path(folder, "rows.csv")
        with file.open("w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(["t", *(f"{name}{i}" for name in ("omega_B", "b_B", "r_N", "v_N") for i in "123")])
            orbit = flight.orbit
            writer.writerows(np.column_stack((flight.t, flight.omega, flight.m, orbit.r_N, orbit.v_N)).tolist())
        result = run(scenario(file, flight, calibration, noise))
    rows = np.rint(flight.t).astype(int)
    of = {name: result[f"estimator.{name}"][rows] for name in ("R_NB", "omega_B", "nis", "ambiguity", "attitude_valid")}
    bias, scale = (result[f"estimator.{name}"][-1] for name in ("rate_bias_B", "rate_scale_B"))
    ambiguity = np.where(of["attitude_valid"] > 0.5, of["ambiguity"], np.pi)
    strain = max(float(np.abs(bias).max()) / noise.bias, float(np.abs(scale).max()) / noise.scale)
    nothing = np.full((6, 6), np.nan)
    return Attitudes(of["R_NB"], of["omega_B"], ambiguity, of["nis"][:, 0], bias, scale, nothing, strain)
