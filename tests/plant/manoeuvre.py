"""The forced manoeuvre on which orders are measured: full inertia, all actuators at work, commands of a fixed period.

The rods are twenty times as strong as the paper's, so that an error in the forcing shows beside that of the free
motion.
"""

from __future__ import annotations

import numpy as np

import plant
from evidence.verification.rk4 import angle_between, environment, pack, truth
from tests.plant.motion import FULL_INERTIA, checked, command

PERIOD = 4.0
COMMANDS = (
    ((400.0, -300.0, 350.0), 2e-3),
    ((-200.0, 450.0, 100.0), -1e-3),
    ((150.0, -250.0, -450.0), 1.5e-3),
    ((-450.0, 100.0, -300.0), -3e-3),
    ((300.0, -400.0, -150.0), 1e-3),
)


def parameters(order: int, step: float, **changes):
    start = {"J_B": FULL_INERTIA, "omega_B0": [0.08, -0.1, 0.07], "h_w0": 0.012, "dipole_max": 500.0}
    return checked(**{**start, **changes, "integrator_order": order, "step_max": step})


def flown(p) -> plant.State:
    x = plant.start(p, command())
    for dipole, torque in COMMANDS:
        x, _ = plant.step(x, command(dipole, torque), p, PERIOD)
    return x


def true_end(p) -> np.ndarray:
    """R, Omega, l_w at the end, by DOP853 on the paper's equations."""
    y = pack(p.R_NB0, p.omega_B0, p.h_w0)
    for i, (dipole, torque) in enumerate(COMMANDS):
        moment = environment(p, p.rods_to_body @ np.array(dipole))
        y = truth(y, i * PERIOD, (i + 1) * PERIOD, p.J_B, moment, lambda l_w, torque=torque: torque)
    return y


def error(x: plant.State, p, y: np.ndarray) -> float:
    """Attitude error, rad, and rate error, rad/s, together."""
    return angle_between(x.R, y[:9].reshape(3, 3)) + float(np.abs(x.Omega(p) - y[9:12]).max())


STEPS = {2: (1.0, 0.5, 0.25, 0.125), 4: (2.0, 1.0, 0.5, 0.25), 6: (1.0, 0.5, 0.25)}
"""Steps on which the order shows: small enough to be asymptotic, large enough to stay above rounding."""


def errors(order: int, **changes) -> dict[float, float]:
    y = true_end(parameters(order, 1.0, **changes))
    found = {}
    for step in STEPS[order]:
        p = parameters(order, step, **changes)
        found[step] = error(flown(p), p, y)
    return found
