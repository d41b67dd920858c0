"""The paper's law [8] to LVLH, with gains that suit the satellite.

Small errors have the stiffness w^2 J and the damping 2 z w J: z is `damping`, w `share` of the frequency of
bandwidth.py. Of K = diag(k_i) the stiffness about axis i is k_j + k_k, so k_i = w^2 (tr(J)/2 - J_i).
"""

from typing import Any

import numpy as np

from controller.errors import errors
from controller.law import gravity_gradient, torque
from controller.reference import lvlh
from design.laws import bandwidth

PARAMETERS = {"share": 1.0, "damping": 1.0}
MU = 3.986004418e14  # m3/s2


def step(inputs: Any, parameters: Any, t: float, h: float) -> dict[str, Any]:
    J, R, r = parameters.J_B, inputs.R_NB, inputs.r_N
    w: Any = parameters.share * bandwidth.frequency(parameters)
    L = 2.0 * parameters.damping * w * J
    if not R.any():  # no attitude: the rate alone
        return {"tau_cmd_B": -L @ inputs.omega_B}
    K = w * w * (0.5 * np.trace(J) - np.diag(J))
    found = errors(R, inputs.omega_B, lvlh(r, inputs.v_N))
    return {"tau_cmd_B": torque(J, K, L, 1.0, found, gravity_gradient(MU, J, R, r))}
