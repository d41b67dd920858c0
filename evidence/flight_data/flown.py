"""A record through the shipped estimator in C: its columns, calibrated, in the place of sensors, by a scenario."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from estimator.bank import Noise
from inflight.attitude import Attitudes
from inflight.magnetometer import Calibration
from inflight.records import Flight
from orchestration import run

from .records import COLUMNS

TESLA = 1e-7
"""Of the columns' unit, mG."""


def scenario(
    file: Path, orbit: Path, flight: Flight, calibration: Calibration, gyro: Attitudes, noise: Noise
) -> dict[str, Any]:
    """The scenario of a record: telemetry and ephemeris in the place of sensors, with what the calibrations wrote."""
    rate = COLUMNS["omega_B_measured"] | {
        "offset": np.degrees(gyro.bias).tolist(),
        "matrix": np.diag(1.0 / (1.0 + gyro.scale)).tolist(),
    }
    field = COLUMNS["b_B_measured"] | {
        "offset": np.column_stack((calibration.knots, (calibration.bias + calibration.drift) / TESLA)).tolist(),
        "matrix": calibration.A.tolist(),
        "gain": np.column_stack((calibration.knots, calibration.gain)).tolist(),
    }
    place = {
        f"{name}_measured": {"of": [f"{name}{i}" for i in "123"], "unit": unit}
        for name, unit in (("r_N", "m"), ("v_N", "m/s"))
    }
    return {
        "name": "flight_data",
        "step": 1.0,
        "duration": float(flight.t[-1]),
        "blocks": {
            "sensors": {
                "telemetry": {
                    "file": str(file),
                    "time": {"column": "unix_s", "scale": "UTC"},
                    "columns": {"omega_B_measured": rate, "b_B_measured": field},
                }
            },
            "gnss": {"telemetry": {"file": str(orbit), "time": {"column": "t", "scale": "elapsed"}, "columns": place}},
            "estimator": {
                "fmu": "estimator",
                "start": {
                    "epoch": f"{flight.orbit.epoch:%Y-%m-%dT%H:%M:%SZ}",
                    "field_noise": noise.field,
                    "field_degree": 13,
                    "angle_random_walk": noise.angle,
                    "rate_bias_sigma": noise.bias / 10.0,
                    "rate_random_walk": 10.0 * noise.bias_walk,
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
        "record": {"signals": ["estimator.R_NB", "estimator.attitude_valid", "estimator.rate_bias_B", "estimator.nis"]},
    }


def through_the_estimator(
    file: Path, flight: Flight, calibration: Calibration, gyro: Attitudes, noise: Noise
) -> Attitudes:
    """Its attitudes at the record's rows; unique where it says that its attitude is valid."""
    with TemporaryDirectory() as folder:
        orbit = Path(folder, "orbit.csv")
        with orbit.open("w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(["t", *(f"{name}{i}" for name in ("r_N", "v_N") for i in "123")])
            writer.writerows(np.column_stack((flight.t, flight.orbit.r_N, flight.orbit.v_N)).tolist())
        result = run(scenario(file.resolve(), orbit, flight, calibration, gyro, noise))
    column = {label: i for i, label in enumerate(result.labels)}
    rows = np.rint(flight.t).astype(int)
    R = result.samples[:, [column[f"estimator.R_NB[{i}][{j}]"] for i in (1, 2, 3) for j in (1, 2, 3)]][rows]
    valid = result.samples[rows, column["estimator.attitude_valid"]] > 0.5
    nis = result.samples[rows, column["estimator.nis[1]"]]
    bias = result.samples[-1, [column[f"estimator.rate_bias_B[{i}]"] for i in (1, 2, 3)]]
    return replace(gyro, R=R.reshape(-1, 3, 3), ambiguity=np.where(valid, 0.0, np.pi), nis=nis, bias=bias)
