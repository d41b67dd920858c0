"""The allocation as a weighted least squares problem in the actuators' limits.

minimise |R m - d a - r|^2 + w_r^2 |m - m_p|^2 + w_w^2 (d - d_p)^2 over dipoles m (3,) A m2 and wheel torque d =
dl_w/dt, N m, a the wheel's axis, with R = [u1 x b_B, u2 x b_B, u3 x b_B], each column times the gain of its rod, and r
the demand without the torque of the spinning wheel. Since R turns no moment along the field into torque, the preference
m_p, d_p decides there, and it may cost a little torque elsewhere. Tests: tests/allocator/bounded/test_bounded.py.

Requirements: AB-1, AB-2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .box import Array, least_squares


class Limits(NamedTuple):
    """Limits of the commands: |m_i| <= dipole_i, (3,) A m2; wheel_low <= dl_w/dt <= wheel_high, N m."""

    dipole: Array
    wheel_low: float
    wheel_high: float
    wheel_torque: float
    """The motor's own limit, N m."""


class Preference(NamedTuple):
    """The commands that are preferred where the demand leaves a choice, with weights that bound their cost in
    torque."""

    dipole: Array
    """(3,) A m2 along the rods."""
    wheel_torque: float
    """dl_w/dt, N m."""
    rod_weight: float
    """T = N m/(A m2)."""
    wheel_weight: float


class Allocated(NamedTuple):
    dipole: Array
    """(3,) A m2 along the rods."""
    wheel_torque: float
    """dl_w/dt, N m."""
    fraction: float
    """Largest command over its limit that there would be without limits."""


def rod_matrix(b_B: Array, U: Array) -> Array:
    """R (3,3), N m per A m2: column i is u_i x b_B [16]. b_B (3,) T; U (3,3) has the rods' unit axes as rows."""
    b1, b2, b3 = b_B.tolist()
    return np.array(((0.0, b3, -b2), (-b3, 0.0, b1), (b2, -b1, 0.0))) @ U.T


def spin_torque(omega_B: Array, h_w: float, axis: Array) -> Array:
    """Torque on the turning body of a wheel that spins without torque, -l_w Omega x a, (3,) N m [14]; a:
    unit axis (3,)."""
    O1, O2, O3 = omega_B.tolist()
    a1, a2, a3 = axis.tolist()
    return np.array((h_w * (O3 * a2 - O2 * a3), h_w * (O1 * a3 - O3 * a1), h_w * (O2 * a1 - O1 * a2)))


def limits(h_w: float, period: float, dipole: Array, torque_max: float, momentum_max: float) -> Limits:
    """The limits of a command that stands for `period` s: |h_w + period dl_w/dt| <= momentum_max too, h_w in N m s;
    dipole (3,) A m2.

    Zero is always within them. A wheel that is past its limit is not driven back by them, only not further out.
    """
    low = -min(max((momentum_max + h_w) / period, 0.0), torque_max)
    high = min(max((momentum_max - h_w) / period, 0.0), torque_max)
    return Limits(dipole, low, high, torque_max)


def allocate(r: Array, R: Array, axis: Array, limit: Limits, preference: Preference) -> Allocated:
    """The commands that give r (3,) N m by R (3,3) and the wheel on its unit axis (3,), as nearly as the limits and the
    preference let them.

    A preference beyond a limit counts as the limit.
    """
    scale = np.array((*limit.dipole.tolist(), limit.wheel_torque))
    low = np.array((-1.0, -1.0, -1.0, limit.wheel_low / limit.wheel_torque))
    high = np.array((1.0, 1.0, 1.0, limit.wheel_high / limit.wheel_torque))
    wanted = np.array((*preference.dipole.tolist(), preference.wheel_torque)) / scale
    w_r, w_w = preference.rod_weight, preference.wheel_weight
    weights = np.array((w_r, w_r, w_r, w_w)) * scale
    A = np.zeros((7, 4))
    A[:3, :3] = R * limit.dipole
    A[:3, 3] = -limit.wheel_torque * axis
    A[range(3, 7), range(4)] = weights
    y = np.concatenate((r, weights * np.clip(wanted, low, high)))
    x, free = least_squares(A, y, low, high)
    commands = x * scale
    return Allocated(commands[:3], float(commands[3]), float(np.abs(free).max()))
