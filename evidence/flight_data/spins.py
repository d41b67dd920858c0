"""Spins with known answers through the estimator in C: with its bank, and one filter beside it, on the same sensors.

Plant, sensors and estimator are the FMUs of this project; the light of the Earth on the photodiodes is that of the
plant's sensors (Cunningham's view factor), which the estimator's own model only resembles. Tests:
tests/evidence/flight_data/test_spins.py."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from orchestration import Result, run

SECONDS, WRONG = 300.0, math.radians(10.0)
BIAS, SCALE = math.radians(1.0), 0.01
"""Standard deviations of the gyro's bias, rad/s, and scale in each axis, drawn for each spin."""
FACES = {3: (3, 1, 5), 6: range(6)}
"""Photodiodes by their number: those of SUCHAI-3 look along -y, -x and -z."""
KINDS = ("field and gyro", "with currents of three faces", "with currents of six faces")


def scenario(number: int, faces: int, seconds: float = SECONDS) -> dict[str, Any]:
    """A spin of 20 to 60 deg/s about an axis near -y, from any attitude and place of the orbit.

    A gyro of 1.6e-3 rad/s of noise whose scale and bias are off by what is drawn, a magnetometer of 0.3 uT, and
    photodiodes of 2% of noise in the light of Sun and Earth.
    """
    rng = np.random.default_rng((52, number))
    scale, bias = SCALE * rng.normal(), BIAS * rng.normal(size=3)
    plant = {
        "dipole_cmd": [0.0, 0.0, 0.0],
        "wheel_torque_cmd": 0.0,
        "J_B": [[0.04, 0.0, 0.0], [0.0, 0.0399, 0.0], [0.0, 0.0, 0.007]],
        "orbit_radius": 6.87e6,
        "inclination": math.radians(97.4),
        "node_longitude": rng.uniform(0.0, 2.0 * math.pi),
        "argument_of_latitude": rng.uniform(0.0, 2.0 * math.pi),
        "epoch": "2023-09-04T12:00:00Z",
        "Q0": Rotation.random(random_state=rng).as_matrix().tolist(),
        "omega_B0": (math.radians(rng.uniform(20.0, 60.0)) * np.array([0.02, -0.99, 0.02])).tolist(),
    }
    sensors = {
        "rate_noise": 1.6e-3,
        "rate_bias_B": bias.tolist(),
        "rate_scale": (scale * np.eye(3)).tolist(),
        "field_noise": 3e-7,
        "sun_sensor_noise": 0.02,
        "albedo": 0.3,
        "seed": number + 1,
    }
    one = {
        "epoch": plant["epoch"],
        "field_noise": 5e-7,
        "field_degree": 13,
        "angle_random_walk": 2e-3,
        "rate_random_walk": 1e-6,
        "rate_bias_sigma": 0.03,
    }
    axes = np.vstack((np.eye(3), -np.eye(3)))[[0, 3, 1, 4, 2, 5]]
    axes[[i for i in range(6) if faces and i not in FACES[faces]]] = 0.0
    bank = {**one, "bank": True, "sun_sensor_axes": axes.tolist()}
    measured = ("omega_B_measured", "b_B_measured", "r_N_measured", "v_N_measured")
    truth = ("R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w", "sun_N", "sunlight")
    return {
        "name": "spin",
        "step": 1.0,
        "duration": seconds,
        "blocks": {
            "plant": {"fmu": "plant", "start": plant},
            "sensors": {"fmu": "plant_sensors", "start": sensors},
            "one": {"fmu": "estimator", "start": one},
            "bank": {"fmu": "estimator", "start": bank},
        },
        "connections": [f"plant.{name} -> sensors.{name}" for name in truth]
        + [f"sensors.{name} -> {block}.{name}" for name in measured for block in ("one", "bank")]
        + (["sensors.sun_sensors -> bank.sun_sensors"] if faces else []),
        "record": {
            "signals": [
                "plant.R_NB",
                *("one.R_NB", "one.attitude_valid", "one.nis"),
                *("bank.R_NB", "bank.attitude_valid", "bank.attitude_doubtful", "bank.ambiguity", "bank.rate_scale_B"),
            ]
        },
    }


class Case(NamedTuple):
    """State of a spin at its end."""

    off: float
    """rad, NaN where no attitude was given"""
    trusted: bool
    nis: float
    """Mean of the field's over the last 100 s, 3 for a filter that is consistent; NaN for the bank"""


def case(item: tuple[int, int]) -> tuple[Case, Case]:
    """The spin of a number and a number of faces (0, 3, 6): by the one filter, by the bank."""
    result = run(scenario(*item))
    nis = float(result["one.nis"][-100:, 0].mean())
    return _ended(result, "one", nis), _ended(result, "bank", math.nan)


def _ended(result: Result, block: str, nis: float) -> Case:
    R = result[f"{block}.R_NB"][-1]
    off = Rotation.from_matrix(R.T @ result["plant.R_NB"][-1]).magnitude() if R.any() else math.nan
    return Case(float(off), bool(result[f"{block}.attitude_valid"][-1]), nis)


def counted(cases: Sequence[Case]) -> dict[str, int]:
    """Returns how many ended right and valid, right or without attitude and not valid, wrong and not valid, wrong and
    valid.
    """
    wrong = [c.off > WRONG for c in cases]  # NaN is not
    return {
        "right, trusted": sum(c.trusted and not w for c, w in zip(cases, wrong, strict=True)),
        "not wrong, reported": sum(not c.trusted and not w for c, w in zip(cases, wrong, strict=True)),
        "wrong, reported": sum(not c.trusted and w for c, w in zip(cases, wrong, strict=True)),
        "wrong, not reported": sum(c.trusted and w for c, w in zip(cases, wrong, strict=True)),
    }


def largest_trusted(cases: Sequence[Case]) -> float:
    """deg, the worst attitude that was trusted."""
    return math.degrees(max((c.off for c in cases if c.trusted), default=0.0))


def worst_quiet(cases: Sequence[Case]) -> Case | None:
    """The case that is the farthest off though it is trusted and its innovations are quiet; None without one."""
    quiet = [c for c in cases if c.trusted and c.off > WRONG and c.nis < 4.5]
    return max(quiet, key=lambda c: c.off, default=None)
