"""Flights with known answers: a spin on an orbit, a magnetometer and a gyro with known errors."""

from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from sgp4.api import Satrec

from estimator.bank import Faces
from inflight.orbit import orbit_at
from inflight.records import Flight

Floats = NDArray[np.float64]
EPOCH = datetime(2023, 9, 4, 14, 48, 23, tzinfo=UTC)
SETS = [
    Satrec.twoline2rv(
        "1 52191U 22033AL  23247.77431173  .00022171  00000+0  61178-3 0  9997",
        "2 52191  97.3601 329.3497 0007739 208.8387 151.2430 15.37072592 79491",
    )
]
A = np.array([[1.12, 0.03, -0.02], [0.0, 1.05, 0.06], [0.0, 0.0, 0.97]])
BIAS = np.array([9e-5, -3e-5, -2e-5])
FACES = Faces(np.array([[0.0, -1, 0], [-1, 0, 0], [0, 0, -1]]), np.full(3, 500.0), albedo=0.0)


def spinning(
    seed: int,
    seconds: int = 900,
    scale: float = 0.0,
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0),
    offset: float = 0.0,
    calibrated: bool = True,
) -> tuple[Flight, Floats, Floats, Floats]:
    """A flight, its true attitudes (n,3,3) and its field in N and rate (3,); attitude and rate are drawn."""
    rng = np.random.default_rng(seed)
    t = np.arange(float(seconds))
    orbit = orbit_at(SETS, EPOCH, t + offset)
    orbit = type(orbit)(EPOCH, t + offset, orbit.r_N, orbit.v_N, orbit.age)
    omega = np.radians(rng.uniform(20.0, 60.0)) * np.array([0.15, -0.98, 0.1])
    R = (Rotation.random(random_state=seed) * Rotation.from_rotvec(np.outer(t, omega))).as_matrix()
    B = orbit.field_N()
    b = np.einsum("nji,nj->ni", R, B) + 3e-7 * rng.normal(size=(len(t), 3))
    gain = 1.0 + 0.02 * np.sin(2.0 * np.pi * t / 3000.0)
    m = b if calibrated else (b @ np.linalg.inv(A).T + BIAS) / gain[:, None]
    measured = (1.0 + scale) * omega + np.array(bias) + 1.6e-3 * rng.normal(size=(len(t), 3))
    light = (
        orbit.sunlight()
        * np.maximum(0.0, np.einsum("nij,nj->ni", R.transpose(0, 2, 1), orbit.sun_N()) @ FACES.normals.T).T
    )
    currents = (FACES.full[:, None] * light).T + 10.0 * rng.normal(size=(len(t), 3))
    flight = Flight("spin", t, measured, m, currents, orbit, [])
    return flight, R, B, omega


def angle(R: Floats, found: Floats) -> Floats:
    """(n,) rad between attitudes."""
    return np.asarray(Rotation.from_matrix(R.transpose(0, 2, 1) @ found).magnitude())
