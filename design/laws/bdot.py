"""B-dot: dipoles against the change of the measured field. It takes the rate away and holds no attitude.

m = -k/|b|^2 db/dt, with db/dt = b x omega as a body that turns sees it, and k = 2 n (1 + sin i) J_min of Avanzini and
Giulietti (Journal of Guidance, Control, and Dynamics 35(4), 2012), n the orbit's rate and i its inclination.
"""

from typing import Any

import numpy as np


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    r, v, b = inputs.r_N, inputs.v_N, inputs.b_B
    normal = np.cross(r, v)
    n, up = np.linalg.norm(normal) / (r @ r), normal[2] / np.linalg.norm(normal)
    k = 2.0 * n * (1.0 + np.sqrt(1.0 - up * up)) * np.linalg.eigvalsh(parameters.J_B)[0]
    dipole = np.linalg.solve(parameters.rod_axes.T, -k / (b @ b) * np.cross(b, inputs.omega_B))
    limit = parameters.dipole_max * parameters.rod_limits
    dipole = dipole / max(1.0, float(np.abs(dipole / limit).max()))
    return {"tau_cmd_B": np.zeros(3), "dipole_ff": dipole, "wheel_torque_ff": 0.0 * inputs.h_w}
