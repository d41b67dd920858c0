"""The deviations of a calibration are those of its errors, where the model's errors last for a minute and longer."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from evidence.flight_data.synthetic import BIAS, EPOCH, SETS, A
from inflight.magnetometer import calibrate
from inflight.orbit import orbit_at

TRUTH = np.concatenate((A[np.triu_indices(3)], BIAS))


def record(seed: int, lasting: float, n: int = 1500) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A spin with nutation: errors of 0.15 uT that last for so many s, of the field in N and of the sensor in B, and
    white noise of 0.2 uT."""
    rng = np.random.default_rng(seed)
    t = np.arange(float(n))
    field_N = orbit_at(SETS, EPOCH, t + rng.uniform(0.0, 5400.0)).field_N()
    axis = rng.normal(size=3)
    spin = np.outer(t, np.radians(rng.uniform(15.0, 45.0)) * axis / np.linalg.norm(axis))
    nutation = 0.2 * np.column_stack((np.cos(0.13 * t), 0.0 * t, np.sin(0.13 * t)))
    R = Rotation.random(random_state=seed) * Rotation.from_rotvec(spin) * Rotation.from_rotvec(nutation)
    keep = np.exp(-1.0 / lasting)
    in_N, in_B = (
        lfilter([1.0], [1.0, -keep], 1.5e-7 * np.sqrt(1.0 - keep**2) * rng.normal(size=(n + 1000, 3)), axis=0)[-n:]
        for _ in range(2)
    )
    b = R.inv().apply(field_N + in_N) + in_B + 2e-7 * rng.normal(size=(n, 3))
    return t, b @ np.linalg.inv(A).T + BIAS, np.linalg.norm(field_N, axis=1)


@pytest.mark.fly
def test_intervals_of_95_percent_hold_the_truth_in_88_to_99_of_100():
    inside = []
    for seed in range(14):
        found = calibrate(*record(seed, 60.0))
        off = np.concatenate((found.A[np.triu_indices(3)], found.bias)) - TRUTH
        inside.append(np.abs(off) < 1.96 * found.sigma[:9])
    assert 0.88 <= np.mean(inside) <= 0.99
