"""Inputs that an engineer knows rather than the plant's parameters: what a scenario's helper inputs stand for.

Each takes its value and the parameters in force, in SI units, and gives the parameters that follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .orbit import WGS84_RADIUS
from .parameters import Parameters


def altitude(value: float, parameters: Mapping[str, Any]) -> dict[str, float]:
    """The radius, m, of a circular orbit at this height, m, above the equatorial radius of WGS 84, 6378.137 km.

    Raises ValueError where the orbit does not start from its radius.
    """
    if parameters["orbit_start"] != "circular":
        raise ValueError(f"expected orbit_start circular beside it, found {parameters['orbit_start']}")
    return {"orbit_radius": WGS84_RADIUS + value}


def omega_LVLH_B0(value: list[float], parameters: Mapping[str, Any]) -> dict[str, list[float]]:
    """omega_B0, rad/s, of a body rate (3,) relative to LVLH, rad/s, in B: zeros are at rest in LVLH.

    LVLH turns with r x v/|r|^2 of the orbit at t = 0; a drift of the node turns it further, by 1e-6 rad/s at most.
    """
    given: dict[str, Any] = {name: np.array(v) if isinstance(v, list) else v for name, v in parameters.items()}
    p = Parameters(**given)
    r, v = p.orbit.position_velocity(0.0)
    rate: list[float] = (np.array(value) + p.R_NB0.T @ np.cross(r, v) / (r @ r)).tolist()
    return {"omega_B0": rate}
