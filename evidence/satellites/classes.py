"""The satellites of docs/evidence/satellites.md, and their tumbles as campaigns: inertia, actuators and size of each,
and nothing tuned."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..flight.cases import DRAWN, HOLD, RATE, Group
from ..flight.schemes import NO_ERRORS, Data, base, change
from ..paper import INERTIA, Array

FIELD = 4.4e-5
"""T: dipole_max times this is the torque of the rods, of which a disturbance is a share."""
SHARES = {False: 1e-3, True: 1e-2}
"""This share, nominal and with errors; a tenth of it without a wheel."""
DURATION, EARLY = 2e4, 9e3
"""s: three orbits or more, at 350 to 1200 km; after EARLY it is told what becomes of a flight."""
SEED = 500
PAPER_RODS = [[3**-0.5, 3**-0.5, -(3**-0.5)], [3**-0.5, -(3**-0.5), 3**-0.5], [0.0, 0.0, 1.0]]
BODY_RODS = np.eye(3).tolist()
ACROSS = (1.0 - np.eye(3)).tolist()
"""Second moments of mass along the axes become moments of inertia about them."""


@dataclass(frozen=True)
class Satellite:
    """moments (3,) kg m2, A m2, N m, N m s, width and length in m, the wheel's axis (3,), the largest rate drawn,
    deg/s, and the body axis along the length."""

    moments: tuple[float, float, float]
    dipole_max: float
    wheel_torque_max: float
    wheel_momentum_max: float
    size: tuple[float, float]
    rod_axes: list[list[float]]
    wheel_axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    rate_max: float = 6.0
    axis: str = "z"

    @property
    def has_wheel(self) -> bool:
        """Returns whether its wheel is more than next to nothing."""
        return self.wheel_torque_max > 1e-6

    @property
    def time(self) -> float:
        """T, s: sqrt(J/(dipole_max FIELD)) with the mean moment, docs/how/planned-scales.md."""
        return math.sqrt(sum(self.moments) / 3.0 / (self.dipole_max * FIELD))

    def disturbance(self, errors: bool) -> float:
        """N m, of the torque fixed in the body."""
        return SHARES[errors] * (1.0 if self.has_wheel else 0.1) * self.dipole_max * FIELD

    @property
    def slow(self) -> float:
        """rad/s, below which the rate is settled: 0.05/T, at least that of docs/evidence/flight.md."""
        return max(0.05 / self.time, RATE)


def box(mass: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Principal moments, kg m2, of a homogeneous box of so many kg and m."""
    return mass / 12 * (y * y + z * z), mass / 12 * (z * z + x * x), mass / 12 * (x * x + y * y)


def _of(body: tuple[float, float, float, float], dipole: float, torque: float, momentum: float) -> Satellite:
    return Satellite(box(*body), dipole, torque, momentum, (body[1], body[3]), BODY_RODS)


CLASSES = {
    "1U": _of((1.3, 0.1, 0.1, 0.113), 0.2, 1e-4, 1e-3),
    "3U": _of((4.0, 0.1, 0.1, 0.34), 0.3, 3e-4, 2e-3),
    "6U": _of((10.0, 0.1, 0.23, 0.34), 0.5, 1e-3, 1e-2),
    "12U": _of((20.0, 0.23, 0.23, 0.34), 1.0, 2e-3, 2e-2),
    "50 kg": Satellite(INERTIA, 25.0, 3e-3, 3e-2, (0.5, 0.6), PAPER_RODS, axis="x"),
    "150 kg": _of((150.0, 0.6, 0.6, 0.9), 40.0, 1.5e-2, 0.4),
    "500 kg": _of((500.0, 1.0, 1.0, 1.5), 100.0, 4e-2, 4.0),
    "50 kg, flat": _of((50.0, 1.2, 1.2, 0.2), 25.0, 3e-3, 3e-2),
    "50 kg, elongated": _of((50.0, 0.4, 0.4, 2.0), 25.0, 3e-3, 3e-2),
}
_PAPER = CLASSES["50 kg"]
VARIANTS = {
    "3U, wheel along e2": replace(CLASSES["3U"], wheel_axis=(0.0, 1.0, 0.0)),
    "12U, wheel along e3": replace(CLASSES["12U"], wheel_axis=(0.0, 0.0, 1.0)),
    "50 kg, wheel along (1, 2, 2)/3": replace(_PAPER, wheel_axis=(1 / 3, 2 / 3, 2 / 3)),
    "50 kg, rates to 30 deg/s": replace(_PAPER, rate_max=30.0),
    "50 kg, inertia x10": replace(_PAPER, moments=(21.3, 30.4, 30.9)),
    "1U, no wheel": replace(CLASSES["1U"], wheel_torque_max=1e-9, wheel_momentum_max=1e-9),
}
"""Rows beside the classes: the wheel's axis, rates and inertia; no wheel, whose flights take longest, last."""
ALL = CLASSES | VARIANTS


def tumbles(name: str, runs: int, errors: bool = False, data: Data | None = None) -> Group:
    """Random tumbles of a satellite: attitude, rate to its `rate_max`, node, inclination 0 to 98 deg, height 350 to
    1200 km.

    `data`: the scenario, of the paper's satellite with errors; flight_tumble without it.

    Errors are those of docs/evidence/flight.md, but for the disturbance and for the inertia: errors of each moment
    for itself would make no body of a flat or a long one. The second moments of mass are off, by sqrt(2) of 5 to 10%
    each, so that the moments of inertia are off as much in the mean square.
    """
    it = ALL[name]
    data = base() if data is None else data
    data["shared"] |= {
        "J_B": {"diagonal": list(it.moments)},
        "dipole_max": it.dipole_max,
        "wheel_torque_max": it.wheel_torque_max,
        "wheel_momentum_max": it.wheel_momentum_max,
        "wheel_inertia": max(5e-4 * it.wheel_momentum_max, 1e-9),
        "wheel_axis": list(it.wheel_axis),
        "rod_axes": it.rod_axes,
    }
    change(data, {"plant.body_width": it.size[0], "plant.body_length": it.size[1], "plant.body_axis": it.axis})
    if not errors:
        change(data, NO_ERRORS)
    drawn = {
        **DRAWN,
        "omega": {"sphere": {"uniform": ["0 deg/s", f"{it.rate_max:g} deg/s"]}},
        "radius": {"uniform": ["6721 km", "7571 km"]},
        "tilt": {"uniform": ["0 deg", "98 deg"]},
    }
    vary = {
        "plant.Q0": "attitude",
        "plant.omega_B0": "omega",
        "plant.node_longitude": "node",
        "plant.orbit_radius": "radius",
        "plant.inclination": "tilt",
        "plant.disturbance_torque_B": f"{it.disturbance(errors)} * push",
        "sensors.seed": "noise",
    }
    if errors:
        of_mass = [sum(it.moments) / 2.0 - moment for moment in it.moments]
        vary["plant.J_error_B"] = f"diag({ACROSS} @ ({of_mass} * sqrt(2) * off * [side1, side2, side3]))"
        vary["controller.field_error"] = "field"
    kind = "errors" if errors else "nominal"
    return Group(f"{name} {kind}", data, runs, SEED, drawn, vary, DURATION, EARLY, it.slow)


def settled(angle: Array, rate: Array) -> Array:
    """Returns when both were settled, s, infinite where one was not within the last HOLD; each (n,), NaN for never."""
    times = np.where(np.isnan(angle) | np.isnan(rate), math.inf, np.maximum(angle, rate))
    return np.where(times <= DURATION - HOLD, times, math.inf)
