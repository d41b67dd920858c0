"""The classes of docs/satellites.md, and their tumbles as campaigns: inertia, actuators and size of each, and nothing tuned."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..flight.cases import DRAWN, Group
from ..flight.schemes import NO_ERRORS, base, change
from ..paper import INERTIA, Array

FIELD = 4.4e-5
"""T: dipole_max times this is the torque of the rods, of which a disturbance is a share."""
DURATION = 2e4
"""s: three orbits or more, at 350 to 1200 km."""
PAPER_RODS = [[3**-0.5, 3**-0.5, -(3**-0.5)], [3**-0.5, -(3**-0.5), 3**-0.5], [0.0, 0.0, 1.0]]
ACROSS = (1.0 - np.eye(3)).tolist()
"""Second moments of mass along the axes become moments of inertia about them."""
BODY_RODS = np.eye(3).tolist()


@dataclass(frozen=True)
class Satellite:
    """moments (3,) kg m2, A m2, N m, N m s, width and length in m."""

    moments: tuple[float, float, float]
    dipole_max: float
    wheel_torque_max: float
    wheel_momentum_max: float
    size: tuple[float, float]
    rod_axes: list[list[float]]


def box(mass: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Principal moments, kg m2, of a homogeneous box of so many kg and m."""
    return mass / 12 * (y * y + z * z), mass / 12 * (z * z + x * x), mass / 12 * (x * x + y * y)


def _of(body: tuple[float, float, float, float], dipole: float, torque: float, momentum: float) -> Satellite:
    return Satellite(box(*body), dipole, torque, momentum, (body[1], body[3]), BODY_RODS)


CLASSES = {
    "1U": _of((1.3, 0.1, 0.1, 0.113), 0.2, 1e-4, 1e-3),
    "1U, no wheel": _of((1.3, 0.1, 0.1, 0.113), 0.2, 1e-9, 1e-9),
    "3U": _of((4.0, 0.1, 0.1, 0.34), 0.3, 3e-4, 2e-3),
    "6U": _of((10.0, 0.1, 0.23, 0.34), 0.5, 1e-3, 1e-2),
    "12U": _of((20.0, 0.23, 0.23, 0.34), 1.0, 2e-3, 2e-2),
    "50 kg": Satellite(INERTIA, 25.0, 3e-3, 3e-2, (0.5, 0.6), PAPER_RODS),
    "150 kg": _of((150.0, 0.6, 0.6, 0.9), 40.0, 1.5e-2, 0.4),
    "500 kg": _of((500.0, 1.0, 1.0, 1.5), 100.0, 4e-2, 4.0),
    "50 kg, flat": _of((50.0, 1.2, 1.2, 0.2), 25.0, 3e-3, 3e-2),
    "50 kg, elongated": _of((50.0, 0.4, 0.4, 2.0), 25.0, 3e-3, 3e-2),
}


def tumbles(name: str, runs: int, errors: bool = False) -> Group:
    """Random tumbles of a class: attitude, rate to 6 deg/s, node, inclination 0 to 98 deg, height 350 to 1200 km.

    Nominal: a disturbance of a thousandth of the rods' torque. Errors as in docs/flight.md, but for a disturbance of a hundredth.
    """
    it = CLASSES[name]
    data = base()
    data["shared"] |= {
        "J_B": {"diagonal": list(it.moments)},
        "dipole_max": it.dipole_max,
        "wheel_torque_max": it.wheel_torque_max,
        "wheel_momentum_max": it.wheel_momentum_max,
        "wheel_inertia": max(5e-4 * it.wheel_momentum_max, 1e-9),
        "rod_axes": it.rod_axes,
    }
    change(data, {"plant.body_width": it.size[0], "plant.body_length": it.size[1]})
    if not errors:
        change(data, NO_ERRORS)
    push = (1e-2 if errors else 1e-3) * it.dipole_max * FIELD
    drawn = {**DRAWN, "radius": {"uniform": ["6721 km", "7571 km"]}, "tilt": {"uniform": ["0 deg", "98 deg"]}}
    vary = {
        "plant.Q0": "attitude",
        "plant.omega_B0": "omega",
        "plant.node_longitude": "node",
        "plant.orbit_radius": "radius",
        "plant.inclination": "tilt",
        "plant.disturbance_torque_B": f"{push} * push",
        "sensors.seed": "noise",
    }
    if errors:
        of_mass = [sum(it.moments) / 2.0 - moment for moment in it.moments]
        vary["plant.J_error_B"] = f"diag({ACROSS} @ ({of_mass} * sqrt(2) * off * [side1, side2, side3]))"
        vary["controller.field_error"] = "field"
    kind = "errors" if errors else "nominal"
    return Group(f"{name} {kind}", data, runs, 500, drawn, vary, DURATION, DURATION)


def settled(angle: Array, rate: Array) -> Array:
    """When both were settled, s, infinite where one was not within the last 2000 s; each (n,), NaN for never."""
    times = np.where(np.isnan(angle) | np.isnan(rate), math.inf, np.maximum(angle, rate))
    return np.where(times <= DURATION - 2000.0, times, math.inf)
