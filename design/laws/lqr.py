"""A linear-quadratic regulator about LVLH: the least mean of |error|^2/a^2 + |tau|^2/u^2 of a body without a field.

Of the double integrator about each axis the Riccati equation has the closed form k = u/a, d = sqrt(2 J k). By Bryson's
rule a is the largest error that is meant, 1 rad, and u the torque that the actuators give (bandwidth.py).
"""

from typing import Any

import numpy as np

from design.laws import bandwidth


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    R, r, v = inputs.R_NB, inputs.r_N, inputs.v_N
    normal = np.cross(r, v)
    down, side = -r / np.linalg.norm(r), -normal / np.linalg.norm(normal)
    Q = np.column_stack((np.cross(side, down), side, down)).T @ R
    error = 0.5 * np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])
    rate = inputs.omega_B - R.T @ (normal / (r @ r)) if R.any() else inputs.omega_B
    k = bandwidth.frequency(parameters) ** 2 * np.trace(parameters.J_B) / 3.0
    return {"tau_cmd_B": -k * error - np.sqrt(2.0 * np.diag(parameters.J_B) * k) * rate}
