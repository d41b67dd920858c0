"""Attitude dynamics on SO(3): the Lie group variational integrator of a gyrostat.

One step of length h takes the attitude R and the body momentum Pi = J Omega + h_B [12], h_B the wheels' momentum
sum l_i u_i (in the paper l_w e1), along [1] and [13]. From the discrete Lagrangian

    L_d = (1/h) tr[(I - F) J_d] - 1/2 tr(hm^ F),     R+ = R F,     J_d = 1/2 tr(J) I - J,

with hm the mean of h_B over the step and a = h (Pi + h/2 M(t)), the Cayley vector f of F
solves

    (a - p) + a x f + ((a + p).f) f - 2 J f = 0,        p = h hm,

and then Pi+ = F^T (Pi + h/2 M(t)) + h/2 M(t + h). The wheels' torques are internal: they appear in hm
only, so R Pi is kept to rounding without external moments, whatever the wheels do. R is never
reprojected. Unforced form: Lee, Leok and McClamroch, IEEE CCA 2005.

The step is symmetric and of order 2; its symmetric compositions have order 4 (Suzuki, Phys. Lett. A
146, 1990) and 6 (Yoshida, Phys. Lett. A 150, 1990, solution A). Tests: tests/plant/test_integrator_order.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .so3 import Array, cayley, solve

Moment = Callable[[Array, float, Array], Array]
"""External moment (3,) in body axes, N m, of attitude R (3,3), time t and body rate Omega (3,)."""


def _suzuki4() -> tuple[float, ...]:
    outer = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
    return (outer, outer, 1.0 - 4.0 * outer, outer, outer)


def _yoshida6() -> tuple[float, ...]:
    w1, w2, w3 = -1.17767998417887, 0.235573213359357, 0.784513610477560
    return (w3, w2, w1, 1.0 - 2.0 * (w1 + w2 + w3), w1, w2, w3)


COMPOSITIONS: dict[int, tuple[float, ...]] = {2: (1.0,), 4: _suzuki4(), 6: _yoshida6()}
"""Lengths of the substeps over the length of the step, by order."""


@dataclass(frozen=True)
class Body:
    """The satellite as the integrator sees it: its inertia J (3,3), kg m2, with the wheels locked."""

    J: Array
    J_inverse: Array
    rate_dependent: bool = False
    """Whether the moment depends on Omega: then the second half kick is solved implicitly."""


def lgvi_step(
    R: Array,
    Pi: Array,
    moment_start: Array,
    moment: Moment,
    body: Body,
    t: float,
    h: float,
    wheel_mean: Array,
    wheel_end: Array,
) -> tuple[Array, Array, Array]:
    """One second-order step from t to t + h; h may be negative, as compositions need.

    R (3,3), Pi (3,) N m s, moment_start (3,) N m the moment at t; wheel_mean (3,) the mean of the wheels' momentum over
    the step and wheel_end (3,) its value at the end, N m s, body axes. Returns R, Pi and the moment at t + h."""
    kicked = Pi + 0.5 * h * moment_start
    F = cayley(_solve_cayley(h * kicked, h * wheel_mean, body))
    R_next = R.dot(F)
    Pi_free = F.T.dot(kicked)
    # Explicit unless the moment depends on Omega; then the fixed point contracts like h/2 |dM/dOmega| / J.
    Pi_next = Pi_free
    for _ in range(50 if body.rate_dependent else 1):
        moment_end = moment(R_next, t + h, body.J_inverse.dot(Pi_next - wheel_end))
        previous, Pi_next = Pi_next, Pi_free + 0.5 * h * moment_end
        if body.rate_dependent and np.abs(Pi_next - previous).max() <= 1e-15 * np.abs(Pi_next).max():
            break
    return R_next, Pi_next, moment_end


def _solve_cayley(a: Array, p: Array, body: Body) -> Array:
    """f (3,) from (a - p) + a x f + ((a + p).f) f - 2 J f = 0 by Newton's method; on floats, which takes a
    quarter of the time."""
    (a1, a2, a3), (p1, p2, p3) = a.tolist(), p.tolist()
    d1, d2, d3 = difference = a1 - p1, a2 - p2, a3 - p3
    s1, s2, s3 = a1 + p1, a2 + p2, a3 + p3
    (j11, j12, j13), (j21, j22, j23), (j31, j32, j33) = body.J.tolist()
    # The part of the Jacobian that does not change: a^ - 2 J.
    l11, l12, l13 = -2.0 * j11, -a3 - 2.0 * j12, a2 - 2.0 * j13
    l21, l22, l23 = a3 - 2.0 * j21, -2.0 * j22, -a1 - 2.0 * j23
    l31, l32, l33 = -a2 - 2.0 * j31, a1 - 2.0 * j32, -2.0 * j33
    x, y, z = (0.5 * body.J_inverse.dot(difference)).tolist()
    for _ in range(20):
        along = s1 * x + s2 * y + s3 * z
        residual = (
            d1 + l11 * x + l12 * y + l13 * z + along * x,
            d2 + l21 * x + l22 * y + l23 * z + along * y,
            d3 + l31 * x + l32 * y + l33 * z + along * z,
        )
        change = solve(
            (
                (l11 + x * s1 + along, l12 + x * s2, l13 + x * s3),
                (l21 + y * s1, l22 + y * s2 + along, l23 + y * s3),
                (l31 + z * s1, l32 + z * s2, l33 + z * s3 + along),
            ),
            residual,
        )
        x, y, z = x - change[0], y - change[1], z - change[2]
        size = math.hypot(*change)
        # Newton's error squares: after a change of 1e-9 what is left is rounding.
        if size <= 1e-9 * (1.0 + math.hypot(x, y, z)):
            return np.array((x, y, z))
        if not size < 1e6:
            break
    raise ValueError(
        "step_max: expected a turn below about 1 rad in an internal step, so that the attitude step converges, "
        f"found h J^-1 Pi = {(body.J_inverse @ difference).tolist()} rad"
    )
