"""What the actuators that are left allow in a flight: the least largest angle of any hold, by the linear programme of
stuck_on.py on the flight's own orbit and disturbance. Tests: tests/evidence/health/test_page.py."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from .rows import SATELLITE, STUCK_SHARE, Row
from .stuck_on import INTERVAL, held, least_angle, of_satellite


def least(row: Row, drawn: Mapping[str, float]) -> float:
    """deg, of the flight with these drawn start values; 0 where enough is left whatever they are."""
    left = row.actuators
    if left is None:
        return 0.0
    orbit = {"node_longitude": drawn["plant.node_longitude"]}
    p = of_satellite(SATELLITE[row.campaign], orbit | {"argument_of_latitude": drawn["plant.argument_of_latitude"]})
    disturbance = [drawn[f"plant.disturbance_torque_B[{i}]"] for i in (1, 2, 3)]
    satellite, B = held(p, left.rods, disturbance, left.wheel, row.at)
    m = np.zeros(3) if left.stuck is None else STUCK_SHARE * p.dipole_max * np.asarray(p.rod_axes)[left.stuck]
    return math.degrees(least_angle(satellite, B, m, INTERVAL))
