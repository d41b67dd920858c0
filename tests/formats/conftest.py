"""A run in closed form: a body that turns at a constant rate about an axis of its own, on a circular orbit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from formats.recorded import Recorded

EPOCH = "2016-12-31T23:59:50Z"  # a leap second follows after 10 s
RATE = np.array([0.06, -0.08, 0.05])
START = Rotation.random(random_state=5)
MU, RADIUS = 3.986004418e14, 7.0e6


def attitude(time):
    return START * Rotation.from_rotvec(np.multiply.outer(time, RATE))


@pytest.fixture
def flown():
    time = np.arange(0.0, 60.5, 0.5)
    angle = np.sqrt(MU / RADIUS**3) * time
    u, v = np.array([0.6, 0.8, 0.0]), np.array([-0.64, 0.48, 0.6])
    position = RADIUS * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), v))
    velocity = np.sqrt(MU / RADIUS) * (np.outer(-np.sin(angle), u) + np.outer(np.cos(angle), v))
    signals = {
        "plant.R_NB": attitude(time).as_matrix(),
        "plant.omega_B": np.tile(RATE, (len(time), 1)),
        "plant.r_N": position,
        "plant.v_N": velocity,
        "plant.h_w": np.sin(time),
    }
    units = {"plant.omega_B": "rad/s", "plant.r_N": "m", "plant.v_N": "m/s", "plant.h_w": "N.m.s"}
    return Recorded("spin", time, signals, units, {"plant": {"epoch": EPOCH}}, "2026-01-02T03:04:05+00:00")
