"""Torque-free motion against Jacobi's elliptic functions."""

from __future__ import annotations

from functools import cache
from itertools import permutations

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between
from tests.authorities.free_body import FreeBody
from tests.authorities.registry import authority
from tests.plant.motion import bare, checked, command, fly

LANDAU = "Landau and Lifshitz, Mechanics, section 37; scipy.special.ellipj, elliprf, elliprj"


@cache
def worst_over_orderings() -> tuple[float, float]:
    """Largest error of rate, rad/s, and attitude, rad, of order 6 at 0.25 s after 100 s.

    All six orders of the moments along the body axes, round the largest and round the least, and with products of
    inertia.
    """
    rate_error = angle_error = 0.0
    for k, moments in enumerate(permutations((2.13, 2.66, 3.09))):
        for about in (int(np.argmin(moments)), int(np.argmax(moments))):
            axes = np.eye(3) if k % 2 else Rotation.random(random_state=k).as_matrix()
            J = axes @ np.diag(moments) @ axes.T
            Omega = axes @ (np.array([0.03, -0.04, 0.02]) + 0.08 * np.eye(3)[about])
            R0 = Rotation.random(random_state=100 + k).as_matrix()
            body = FreeBody(J, Omega, R0)
            R, rate = bare(6, 0.25, 400, R0, Omega, J)
            rate_error = max(rate_error, float(np.abs(rate - body.rate(100.0)).max()))
            angle_error = max(angle_error, angle_between(R, body.attitude(100.0)))
    return rate_error, angle_error


@authority(
    "Torque-free",
    "Body rates after 100 s, order 6, 0.25 s, all orderings",
    source=LANDAU,
    unit="rad/s",
    tolerance=1e-10,
)
def torque_free_rates() -> float:
    return worst_over_orderings()[0]


@authority(
    "Torque-free", "Attitude after 100 s, order 6, 0.25 s, all orderings", source=LANDAU, unit="rad", tolerance=1e-9
)
def torque_free_attitude() -> float:
    return worst_over_orderings()[1]


@authority(
    "Torque-free",
    "Attitude of the plant block after 386 s of the paper's tumble V.B, order 4, 0.1 s",
    source=LANDAU,
    unit="rad",
    tolerance=1e-8,
)
def paper_tumble() -> float:
    p = checked(gravity_gradient=False, omega_B0=[0.0400, -0.0789, 0.0400], integrator_order=4, step_max=0.1)
    x = fly(p, command(), 0.1, 3860)[-1]
    return angle_between(x.R, FreeBody(p.J_B, p.omega_B0, p.R_NB0).attitude(386.0))
