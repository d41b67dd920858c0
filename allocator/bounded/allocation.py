"""The allocation as a weighted least squares problem in the actuators' limits.

minimise |R m - A d - r|^2 + w_r^2 |m - m_p|^2 + w_w^2 |d - d_p|^2 over dipoles m (3,) A m2 and wheel torques d (n,) =
dl_w/dt, N m, with R = [u1 x b_B, u2 x b_B, u3 x b_B], each column times the gain of its rod, A = [a1, ...], the wheels'
axes times their gains, and r the demand without the torque of the spinning wheels. Since R turns no moment along the
field into torque, the preference m_p, d_p decides there, and it may cost a little torque elsewhere. Tests:
tests/allocator/bounded/test_bounded.py.

Requirements: AB-1, AB-2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .box import Array, least_squares

INDEPENDENT_MIN = 1e-6
"""Volume of unit axes below which they count as lying in one plane."""


class Actuators(NamedTuple):
    """What there is, rods before wheels, (n,) each; of rods in A m2, of wheels in N m."""

    torque: Array
    """(3, n): the effectiveness, N m on the body per A m2 or N m."""
    limit: Array
    low: Array
    high: Array
    preferred: Array
    """What is preferred where the demand leaves a choice; beyond a limit it counts as the limit."""
    weight: Array
    """Torque error, in N m, that costs as much as a deviation of one unit from the preferred command."""


def rod_matrix(b_B: Array, U: Array) -> Array:
    """R (3,3), N m per A m2: column i is u_i x b_B [16]. b_B (3,) T; U (3,3) has the rods' unit axes as rows."""
    b1, b2, b3 = b_B.tolist()
    return np.array(((0.0, b3, -b2), (-b3, 0.0, b1), (b2, -b1, 0.0))) @ U.T


def spin_torque(omega_B: Array, h_w: Array, axes: Array) -> Array:
    """Torque on the turning body of wheels that spin without torque, -Omega x sum l_w a, (3,) N m [14]; h_w (n,);
    axes (n,3), unit."""
    O1, O2, O3 = omega_B.tolist()
    h1, h2, h3 = (h_w @ axes).tolist()
    return np.array((O3 * h2 - O2 * h3, O1 * h3 - O3 * h1, O2 * h1 - O1 * h2))


def wheel_limits(h_w: Array, period: float, torque_max: Array, momentum_max: Array) -> tuple[Array, Array]:
    """The limits of wheel torques that stand for `period` s, (n,) N m each: |h_w + period dl_w/dt| <= momentum_max too.

    Zero is always within them. A wheel that is past its limit is not driven back by them, only not further out.
    """
    low = -np.minimum(np.maximum((momentum_max + h_w) / period, 0.0), torque_max)
    high = np.minimum(np.maximum((momentum_max - h_w) / period, 0.0), torque_max)
    return low, high


def null_space(axes: Array) -> Array | None:
    """Unit vector (4,) of the torques of four wheels that cancel on the body: of each wheel the volume of the others'
    axes, in turn with plus and minus. None for fewer wheels and for axes (n,3) in one plane."""
    if len(axes) < 4:
        return None
    n = np.array([(-1.0) ** i * np.linalg.det(np.delete(axes, i, axis=0)) for i in range(4)])
    size = float(np.linalg.norm(n))
    return n / size if size > INDEPENDENT_MIN else None


def null_space_motion(h_w: Array, n: Array, away: float, momentum_max: Array) -> float:
    """By how much momenta h_w (4,) have to move along n (4,) until each is `away` from rest and from its limit, N m s.

    The least such motion; where none suffices, the one that leaves the worst wheel least to wish.
    """
    moved = np.abs(n) >= INDEPENDENT_MIN
    h, n, most = h_w[moved], n[moved], momentum_max[moved]
    far = np.maximum(most - away, away)
    near = np.full_like(far, away)
    ends = np.stack((near, far, -near, -far), axis=1)
    motions = np.concatenate(([0.0], ((ends - h[:, None]) / n[:, None]).ravel()))
    size = np.abs(h + motions[:, None] * n)
    wish = np.maximum(away - size, size - most + away).max(axis=1)
    wish = np.where(wish < 1e-9 * away, 0.0, wish)
    return float(motions[np.lexsort((np.abs(motions), wish))[0]])


def allocate(r: Array, a: Actuators) -> tuple[Array, float]:
    """The commands (n,) that give r (3,) N m as nearly as the limits and the preference let them, and the largest
    command over its limit that there would be without limits."""
    if not len(a.limit):
        return np.zeros(0), 0.0
    low, high = a.low / a.limit, a.high / a.limit
    weights = a.weight * a.limit
    A = np.vstack((a.torque * a.limit, np.diag(weights)))
    y = np.concatenate((r, weights * np.clip(a.preferred / a.limit, low, high)))
    x, free = least_squares(A, y, low, high)
    return x * a.limit, float(np.abs(free).max())
