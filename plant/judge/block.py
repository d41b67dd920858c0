"""The judge as a block: the tracking errors [4] of the true motion, to LVLH or to a given reference.

It stands outside the loop and shares no code with the controller, which it judges.
Tests: tests/plant/judge/test_judge.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .reference import Array, Reference, exp, lvlh, project, require_rotation

REFERENCES = ("lvlh", "inertial", "rate")
ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of the inputs R_NB and R_d: single precision stays well below it."""
REFERENCE_TOLERANCE = 1e-3
"""max |R^T R - I| of R_d0, which may be typed from four printed decimals."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""


@dataclass(frozen=True)
class Parameters:
    """Units, frames and limits are those of fmus/interfaces/plant_judge.toml."""

    reference: str
    R_d0: Array
    Omega_d0: Array

    @cached_property
    def desired_attitude_0(self) -> Array:
        """R_d0 projected onto SO(3)."""
        return project(self.R_d0)


@dataclass(frozen=True)
class Inputs:
    """The truth; and, optional, a reference that varies."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    R_d: Array
    Omega_d: Array


@dataclass(frozen=True)
class State:
    """The time, s, which the reference 'rate' needs, and whether a step has had an attitude."""

    t: float
    flown: bool = False


@dataclass(frozen=True)
class Outputs:
    """The errors: rad; rad/s in body axes."""

    attitude_error: float
    rate_error_B: Array
    no_attitude: bool


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected."""
    if p.reference not in REFERENCES:
        raise ValueError(f"reference: expected one of {', '.join(REFERENCES)}, found {p.reference!r}")
    _require_finite("Omega_d0", p.Omega_d0)
    require_rotation("R_d0", p.R_d0, REFERENCE_TOLERANCE)


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0."""
    return State(0.0)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """Q = R_d^T R = exp(zeta^), omega = Omega - Q^T Omega_d [4], at the time x.t.

    Raises ValueError for an input that is not finite, not a rotation, or connected without its partner.
    """
    for name in ("omega_B", "r_N", "v_N"):
        _require_finite(name, getattr(u, name))
    if _no_attitude(x, u):
        return Outputs(attitude_error=math.pi, rate_error_B=u.omega_B, no_attitude=True)
    require_rotation("R_NB", u.R_NB, ATTITUDE_TOLERANCE)
    if not u.R_d.any():
        return Outputs(attitude_error=math.pi, rate_error_B=u.omega_B, no_attitude=False)
    desired = _reference(x.t, u, p)
    Q = desired.R_d.T @ u.R_NB
    return Outputs(attitude_error=principal_angle(Q), rate_error_B=u.omega_B - Q.T @ desired.Omega_d, no_attitude=False)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u is the truth at t + h."""
    x = State(x.t + h, not _no_attitude(x, u))
    return x, outputs(x, u, p)


def _no_attitude(x: State, u: Inputs) -> bool:
    """Returns whether there is none yet: a matrix of zeros, as simple masters give before the first value."""
    return not x.flown and not u.R_NB.any()


def principal_angle(Q: Array) -> float:
    """|zeta| of Q (3,3) = exp(zeta^), rad in [0, pi].

    From sine and cosine together: the arc cosine of the trace alone has half the digits near 0 and near pi.
    """
    (q11, q12, q13), (q21, q22, q23), (q31, q32, q33) = Q.tolist()
    return math.atan2(0.5 * math.hypot(q32 - q23, q13 - q31, q21 - q12), 0.5 * (q11 + q22 + q33 - 1.0))


def _reference(t: float, u: Inputs, p: Parameters) -> Reference:
    attitude, rate = (not (np.abs(value) >= ABSENT_MIN).any() for value in (u.R_d, u.Omega_d))
    if attitude != rate:
        missing, present = ("Omega_d", "R_d") if attitude else ("R_d", "Omega_d")
        raise ValueError(
            f"{missing}: expected to be connected, since {present} is: connect both or neither, found "
            f"{ABSENT_MIN:g} or more"
        )
    if attitude:
        _require_finite("Omega_d", u.Omega_d)
        require_rotation("R_d", u.R_d, ATTITUDE_TOLERANCE)
        return Reference(u.R_d, u.Omega_d)
    if p.reference == "lvlh":
        frame = lvlh(u.r_N, u.v_N)
        return Reference(frame.R_d @ p.desired_attitude_0, frame.Omega_d @ p.desired_attitude_0)
    if p.reference == "inertial":
        return Reference(p.desired_attitude_0, np.zeros(3))
    return Reference(p.desired_attitude_0 @ exp(t * p.Omega_d0), p.Omega_d0)


def _require_finite(name: str, value: Array) -> None:
    if not np.isfinite(value).all():
        raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
