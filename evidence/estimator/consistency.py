"""Whether the estimator's covariance is that of its errors: free tumbles, sensors with white noise, no controller.
Tests: tests/estimator/test_flights.py."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from orchestration import Result, run

from ..paper import Array

DURATION, STEP, FROM = 900.0, 0.5, 300.0
"""s; the errors count from FROM on, when every run has an attitude."""
BIAS, FIELD_BIAS = 1e-4, 200e-9
"""Standard deviations of the biases, drawn for each run, rad/s and T."""
FREEDOM = {"field": 3, "Sun": 2, "star tracker": 3}
"""Degrees of freedom of each innovation."""


def tumble(index: int, tracker: bool, duration: float = DURATION) -> dict[str, Any]:
    """The scenario of a run: attitude, rate up to 1 deg/s, node and biases by the index."""
    rng = np.random.default_rng((17, index))
    noise = {"angle_random_walk": 4.4e-5, "rate_random_walk": 0.0}
    white = {"attitude_noise": 5e-5, "attitude_noise_about": 3e-4, "attitude_rate_max": 0.0 if tracker else 1e-12}
    sensors = {
        **noise,
        **white,
        "rate_bias_B": (BIAS * rng.normal(size=3)).tolist(),
        "field_bias_B": (FIELD_BIAS * rng.normal(size=3)).tolist(),
        "field_noise": 3e-7,
        "sun_sensor": "fine",
        "fine_sun_half_angle": math.pi,
        "fine_sun_noise": 0.02,
        "seed": index + 1,
    }
    estimator = {
        **noise,
        "rate_bias_sigma": BIAS,
        "field_bias_sigma": FIELD_BIAS,
        "field_noise": 3e-7,
        "field_degree": 13,
        "sun_noise": 0.02,
        "attitude_noise": 5e-5,
        "attitude_noise_boresight": 3e-4,
        "gate": 1e6,
    }
    rate = rng.normal(size=3)
    plant = {
        "dipole_cmd": [0.0, 0.0, 0.0],
        "wheel_torque_cmd": 0.0,
        "Q0": Rotation.random(random_state=rng).as_matrix().tolist(),
        "omega_B0": (math.radians(1.0) * rng.uniform() ** (1 / 3) * rate / np.linalg.norm(rate)).tolist(),
        "node_longitude": rng.uniform(0.0, 2.0 * math.pi),
    }
    measured = ("omega_B_measured", "b_B_measured", "r_N_measured", "v_N_measured", "sun_B_measured", "R_NB_measured")
    counts = ("rate_sample", "field_sample", "orbit_sample", "sun_sample", "attitude_sample")
    truth = ("R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w", "sun_N", "sunlight")
    return {
        "name": "estimator_consistency",
        "step": STEP,
        "duration": duration,
        "blocks": {
            "plant": {"fmu": "plant", "start": plant},
            "sensors": {"fmu": "plant_sensors", "start": sensors},
            "estimator": {"fmu": "estimator", "start": estimator},
        },
        "connections": [f"plant.{name} -> sensors.{name}" for name in truth]
        + [f"sensors.{name} -> estimator.{name}" for name in (*measured, *counts)],
        "record": {
            "interval": 1.0,
            "signals": ["plant.R_NB", "plant.sunlight"]
            + [f"estimator.{n}" for n in ("R_NB", "rate_bias_B", "covariance", "attitude_sigma_B", "nis")],
        },
    }


def errors(result: Result, bias: Array) -> Array:
    """(n, 6): the turn from the estimated to the true attitude in body axes, rad, and the error of the bias, rad/s."""
    seen = np.abs(result["estimator.R_NB"]).sum(axis=(1, 2)) > 0.0
    found = np.full((len(seen), 6), np.nan)
    turns = np.swapaxes(result["estimator.R_NB"][seen], 1, 2) @ result["plant.R_NB"][seen]
    found[seen, :3] = Rotation.from_matrix(turns).as_rotvec()
    found[seen, 3:] = bias - result["estimator.rate_bias_B"][seen]
    return found


def measured(item: tuple[int, bool]) -> dict[str, Array]:
    """Returns for a run at its recorded times NEES (n,), nis (n, 3), attitude error, rad, and sunlight (n,)."""
    data = tumble(*item)
    result = run(data)
    e = errors(result, np.array(data["blocks"]["sensors"]["start"]["rate_bias_B"]))
    nees = np.einsum("ni,ni->n", e, np.linalg.solve(result["estimator.covariance"], e[:, :, None])[:, :, 0])
    return {
        "time": result.time,
        "nees": nees,
        "nis": result["estimator.nis"],
        "angle": np.linalg.norm(e[:, :3], axis=1),
        "sunlight": result["plant.sunlight"],
    }


def bounds(freedom: int, runs: int) -> tuple[float, float]:
    """Returns the middle 95% of the mean over so many runs of a chi-square number."""
    low, high = chi2.ppf((0.025, 0.975), freedom * runs) / runs
    return float(low), float(high)


def summary(runs: list[dict[str, Array]], tracker: bool) -> list[tuple[str, float, float, float, float]]:
    """Rows: what, its mean over runs and times, the bounds of a mean over the runs, the share of times within them."""
    late = runs[0]["time"] >= FROM
    rows = []
    nees = np.mean([r["nees"][late] for r in runs], axis=0)
    low, high = bounds(6, len(runs))
    rows.append(("NEES, 6", float(nees.mean()), low, high, float(((nees >= low) & (nees <= high)).mean())))
    for sensor, (name, freedom) in enumerate(FREEDOM.items()):
        if name == "star tracker" and not tracker:
            continue
        shown = np.array([r["sunlight"][late] >= 1.0 if name == "Sun" else np.ones(late.sum(), bool) for r in runs])
        values = np.array([r["nis"][late][:, sensor] for r in runs])
        within, means = [], []
        for i in range(values.shape[1]):
            chosen = values[shown[:, i], i]
            low, high = bounds(freedom, len(chosen))
            means.append(chosen.mean())
            within.append(low <= means[-1] <= high)
        rows.append(
            (f"NIS of {name}, {freedom}", float(np.mean(means)), *bounds(freedom, len(runs)), float(np.mean(within)))
        )
    return rows
