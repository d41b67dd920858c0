"""Slews: a turn that fades from one reference to the next, with the rate and the torque that the user allows.

Requirement: SV-2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .reference import Reference
from .so3 import Array, coefficients, exp, hat, log, norm

PEAK_RATE, PEAK_CHANGE = 15.0 / 8.0, 10.0 / math.sqrt(3.0)
"""Of the quintic from rest to rest: the largest rate in units of angle/T, the largest acceleration in angle/T^2."""
PEAK_CHANGE_OF_RATE = 3.9413
"""The largest acceleration of the quintic that takes an initial rate to zero, in units of rate/T."""
RATE_LEFT = 0.25
"""An initial rate counts as leaving at least this share of the largest rate to the turn."""


class Slew(NamedTuple):
    """phi(s) = phi0 f(s/T) + dphi0 T g(s/T): the turn from the destination's attitude, exp(phi^), s after the start."""

    duration: float
    """T, s."""
    phi0: Array
    """(3,) rad, in the destination's desired body axes."""
    dphi0: Array
    """(3,) rad/s: rate and attitude are continuous where the slew begins."""


def begin(now: Reference, to: Reference, J: Array, rate_max: float, torque_max: float) -> Slew:
    """The slew from a reference to another. J (3,3) kg m2, rate_max rad/s, torque_max N m.

    T is the least with (10/sqrt 3) |J phi0|/T^2 + 3.94 |J dphi0|/T <= torque_max and (15/8) |phi0|/T + |dphi0| <=
    rate_max:
    exact for a turn from rest to rest about one axis, which is then the eigenaxis turn with a quintic profile.
    """
    phi0 = log(to.R_ref.T @ now.R_ref)
    A = exp(phi0)
    dphi0 = np.asarray(np.linalg.solve(_jacobian(phi0), now.Omega_ref - A.T @ to.Omega_ref), np.float64)
    angle, rate = norm(phi0), norm(dphi0)
    turn, stop = PEAK_CHANGE * norm(J @ phi0), PEAK_CHANGE_OF_RATE * norm(J @ dphi0)
    by_torque = (stop + math.sqrt(stop * stop + 4.0 * torque_max * turn)) / (2.0 * torque_max)
    by_rate = PEAK_RATE * angle / max(rate_max - rate, RATE_LEFT * rate_max)
    return Slew(max(by_torque, by_rate), phi0, dphi0)


def at(slew: Slew, s: float, to: Reference) -> Reference:
    """The reference s after the start, to the destination as it is then; the destination itself from T on.

    R = R_to A, A = exp(phi^), w = (I - a phi^ + b phi^^2) dphi/dt:
    Omega = A^T Omega_to + w, dOmega/dt = A^T dOmega_to/dt + A^T Omega_to x w + dw/dt.
    """
    T = slew.duration
    if s >= T:
        return to
    x = s / T
    f = 1.0 + x * x * x * (-10.0 + x * (15.0 - 6.0 * x))
    df = 30.0 * x * x * (-1.0 + x * (2.0 - x)) / T
    ddf = 60.0 * x * (-1.0 + x * (3.0 - 2.0 * x)) / (T * T)
    g = x * (1.0 + x * x * (-6.0 + x * (8.0 - 3.0 * x))) * T
    dg = 1.0 + x * x * (-18.0 + x * (32.0 - 15.0 * x))
    ddg = 12.0 * x * (-3.0 + x * (8.0 - 5.0 * x)) / T
    phi, dphi, ddphi = (f0 * slew.phi0 + g0 * slew.dphi0 for f0, g0 in ((f, g), (df, dg), (ddf, ddg)))
    A = exp(phi)
    jacobian, w = _jacobian(phi), _jacobian(phi) @ dphi
    dw = jacobian @ ddphi + _jacobian_change(phi, dphi)
    Omega = A.T @ to.Omega_ref
    return Reference(to.R_ref @ A, Omega + w, A.T @ to.dOmega_ref + np.cross(Omega, w) + dw)


def _jacobian(phi: Array) -> Array:
    """I - a phi^ + b phi^^2 (3,3): d exp(phi^)/dt = exp(phi^) (jacobian dphi/dt)^."""
    a, b, _, _ = coefficients(norm(phi))
    skew = hat(phi)
    return np.eye(3) - a * skew + b * (skew @ skew)


def _jacobian_change(phi: Array, dphi: Array) -> Array:
    """d(jacobian)/dt dphi/dt (3,), rad/s2; zero for a turn about one axis."""
    _, b, da, db = coefficients(norm(phi))
    across = np.cross(phi, dphi)
    along = float(phi @ dphi)
    return -da * along * across + db * along * np.cross(phi, across) + b * np.cross(dphi, across)
