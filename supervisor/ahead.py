"""The reference to come, on the two-body orbit through position and velocity."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .modes import destination, reference_now
from .ports import AHEAD, SAFE, SLEW, Inputs, Parameters, State
from .so3 import Array, log, norm

PERIOD = 10.0
"""s, after which it is given anew."""
EVEN = 6.0
"""The k-th time is as k (k + EVEN): the further ahead, the wider apart."""
ECCENTRICITY_MAX = 0.8


def looked(x: State, u: Inputs, p: Parameters) -> State:
    """With the reference of the present mode at AHEAD times; none in the mode safe, nor on an orbit that is no ellipse
    or nearly none."""
    t, turn, Omega = np.zeros(AHEAD), np.zeros((AHEAD, 3)), np.zeros((AHEAD, 3))
    if x.mode == SAFE or p.ahead_horizon <= 0.0 or not _eccentricity(u, p.gravitational_parameter) < ECCENTRICITY_MAX:
        return replace(x, ahead_next=0.0, t_ahead=t, turn_ahead=turn, Omega_ahead=Omega)
    later = x
    for k in range(AHEAD):
        t[k] = x.t + p.ahead_horizon * (k + 1) * (k + 1 + EVEN) / (AHEAD * (AHEAD + EVEN))
        r, v = two_body(u.r_N, u.v_N, p.gravitational_parameter, t[k] - x.t)
        then = replace(u, r_N=r, v_N=v)
        later = replace(later, t=float(t[k]))
        if later.mode == SLEW and later.t >= later.slew_start + later.slew_duration:
            later = replace(later, mode=later.destination)
        now = reference_now(later, then, p)
        later = replace(later, kept=destination(later, then, p).R_ref)
        turn[k], Omega[k] = log(now.R_ref), now.Omega_ref
    return replace(x, ahead_next=x.t + PERIOD, t_ahead=t, turn_ahead=turn, Omega_ahead=Omega)


def _eccentricity(u: Inputs, mu: float) -> float:
    """Returns the eccentricity of the two-body orbit; 1 where it is not closed."""
    r, v = u.r_N, u.v_N
    if not 2.0 / norm(r) > float(v @ v) / mu:
        return 1.0
    return norm(np.cross(v, np.cross(r, v)) / mu - r / norm(r))


def two_body(r: Array, v: Array, mu: float, dt: float) -> tuple[Array, Array]:
    """Position (3,) m and velocity (3,) m/s after dt, s, on an ellipse: Kepler's equation from perigee,
    in the orbit's plane."""
    size, h = norm(r), np.cross(r, v)
    a = 1.0 / (2.0 / size - float(v @ v) / mu)
    e = np.cross(v, h) / mu - r / size
    eccentricity = norm(e)
    x = e / eccentricity if eccentricity > 1e-12 else r / size  # on a circle any direction serves as that of perigee
    y = np.cross(h / norm(h), x)
    b = a * math.sqrt(1.0 - eccentricity * eccentricity)
    n = math.sqrt(mu / (a * a * a))
    E0 = math.atan2(float(r @ y) / b, float(r @ x) / a + eccentricity)
    M = E0 - eccentricity * math.sin(E0) + n * dt
    E = M
    for _ in range(50):
        change = (E - eccentricity * math.sin(E) - M) / (1.0 - eccentricity * math.cos(E))
        E -= change
        if abs(change) < 1e-14 * max(1.0, abs(E)):
            break
    c, s = math.cos(E), math.sin(E)
    rate = n / (1.0 - eccentricity * c)
    return a * (c - eccentricity) * x + b * s * y, rate * (b * c * y - a * s * x)
