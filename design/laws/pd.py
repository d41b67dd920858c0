"""Quaternion feedback to LVLH: tau = -k q_e - d omega_e, at the frequency of bandwidth.py, damping 1."""

from typing import Any

import numpy as np

from design.laws import bandwidth


def errors(inputs: Any) -> tuple[np.ndarray, np.ndarray]:
    """Twice the vector part of the error's quaternion, and the rate error, both (3,) in body axes."""
    R, r, v = inputs.R_NB, inputs.r_N, inputs.v_N
    if not R.any():  # no attitude: the rate alone
        return np.zeros(3), inputs.omega_B
    normal = np.cross(r, v)
    down, side = -r / np.linalg.norm(r), -normal / np.linalg.norm(normal)
    desired = np.column_stack((np.cross(side, down), side, down))
    Q = desired.T @ R
    scalar = 0.5 * np.sqrt(max(1.0 + np.trace(Q), 1e-6))
    vector = np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]]) / (4.0 * scalar)
    return 2.0 * vector, inputs.omega_B - R.T @ (normal / (r @ r))


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    error, rate = errors(inputs)
    J = parameters.J_B
    w = bandwidth.frequency(parameters)
    return {"tau_cmd_B": -(w * w) * (J @ error) - 2.0 * w * (J @ rate)}
