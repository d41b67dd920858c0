"""The block under test: its instances, inputs that fit it, and how outputs are compared."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from tests.native.driver import Instance

from . import core, flat
from .truth import DAYS, NORMAL, orbit

BLOCK = "controller_planned"
J = np.diag([2.13, 3.04, 3.09])
RODS = 25.0 * flat.RODS
E1 = np.array([1.0, 0.0, 0.0])
AS_MEASURED = {
    "attitude_noise": 0.0,
    "rate_noise": 0.0,
    "identify": False,
    "disturbance_max": 0.0,
    "residual_dipole_max": 0.0,
    "rate_bias_max": 0.0,
}
"""No estimator between the measurements and the law."""
KNOWN = {name: value for name, value in AS_MEASURED.items() if not name.endswith("noise")}
"""Nothing to be learned: also from motions that no satellite has."""
SEARCHED = 40.0
"""s, by which the search for the first plan is over."""


def lvlh(t=0.0):
    r, _ = orbit(t)
    z, y = -r / np.linalg.norm(r), -NORMAL
    return np.column_stack((np.cross(y, z), y, z))


def near_target(t):
    """Inputs as of a satellite that nods about LVLH: smooth functions of time, so acquisition and hold."""
    r, v = orbit(t)
    angle = 0.2 * np.array([math.cos(0.02 * t), math.sin(0.01 * t), 0.5])
    R = lvlh(t) @ Rotation.from_rotvec(angle).as_matrix()
    return {
        "R_NB": R,
        "omega_B": [-0.004 * math.sin(0.02 * t), -1.08e-3 + 0.002 * math.cos(0.01 * t), 0.0],
        "r_N": r, "v_N": v, "h_w": 0.004 * math.cos(0.01 * t), "b_B": R.T @ core.field_at("igrf14", DAYS, 10, r, t),
        "u_applied": [3.0, -2.0, 5.0 * math.cos(0.03 * t), -4e-5 * math.sin(0.01 * t)],
    }  # fmt: skip


def at_target(t):
    """At rest in LVLH with nothing to do: a motion that the equations have."""
    r, v = orbit(t)
    rate = np.linalg.norm(np.cross(r, v)) / (r @ r)
    R = lvlh(t)
    still = {"R_NB": R, "omega_B": [0.0, -rate, 0.0], "h_w": 0.0, "u_applied": [0.0, 0.0, 0.0, 0.0]}
    return {**near_target(t), **still, "b_B": R.T @ core.field_at("igrf14", DAYS, 10, r, t)}


def tumbling(t):
    """A spin about a principal axis, without torque."""
    R, B = Rotation.from_rotvec([0.0, 0.07 * t, 0.0]).as_matrix(), core.field_at("igrf14", DAYS, 10, orbit(t)[0], t)
    still = {"u_applied": [0.0, 0.0, 0.0, 0.0], "h_w": 0.0}
    return {**near_target(t), **still, "omega_B": [0.0, 0.07, 0.0], "R_NB": R, "b_B": R.T @ B}


def feed(it, values):
    for name, value in values.items():
        it.set(name, value)


def started(inputs=near_target, **changes):
    it = Instance(BLOCK)
    feed(it, changes)
    feed(it, inputs(0.0))
    it.initialize()
    return it


def run(it, first, last, h=0.5, inputs=near_target):
    """Steps of h from first to last, s; the outputs after each."""
    found = []
    for i in range(round(first / h), round(last / h)):
        feed(it, inputs((i + 1) * h))
        it.step(i * h, h)
        found.append(it.outputs())
    return found


def same(a, b):
    return all(np.array_equal(a[name], b[name]) for name in a)


def alike(a, b, rel=1e-9):
    return all(np.allclose(a[name], b[name], rtol=rel, atol=rel * max(1e-6, np.abs(b[name]).max())) for name in a)
