"""The controller as a block: parameters, ports, memory and step.

Requirement: CT-3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from . import gains, law, morse, so3
from .errors import Errors, errors
from .reference import Reference, inertial, lvlh, rate, relative
from .so3 import Array, project

REFERENCES = ("lvlh", "inertial", "rate")
ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of the input R_NB: a single-precision plant stays well below it."""
REFERENCE_TOLERANCE = 1e-3
"""max |R^T R - I| of R_d0, which may be typed from four printed decimals."""
ABSENT = 1e9
"""The start of an optional input."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""


@dataclass(frozen=True)
class Parameters:
    """J_B, L0, R_d0 (3, 3), K0, Omega_d0 (3,). Units, frames and limits are those of
    fmus/interfaces/controller.toml."""

    J_B: Array
    K0: Array
    L0: Array
    phi: str
    phi_scale: float
    compensate_gravity: bool
    gravitational_parameter: float
    gain_schedule: str
    kappa0: float
    lambda0: float
    a1: float
    a2: float
    c1: float
    c2: float
    reference: str
    R_d0: Array
    Omega_d0: Array

    @cached_property
    def desired_attitude_0(self) -> Array:
        """R_d0 projected onto SO(3)."""
        return project(self.R_d0)


@dataclass(frozen=True)
class Inputs:
    """Measured motion; and, optional, a given reference, whose matrix of zeros means that there is none now."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    R_ref: Array = field(default_factory=lambda: np.full((3, 3), ABSENT))
    Omega_ref: Array = field(default_factory=lambda: np.full(3, ABSENT))
    dOmega_ref: Array = field(default_factory=lambda: np.full(3, ABSENT))

    @cached_property
    def has_reference(self) -> bool:
        """Returns whether the reference is given by the inputs. Raises ValueError for inputs that do not fit."""
        reference = self.R_ref.ravel().tolist(), self.Omega_ref.tolist(), self.dOmega_ref.tolist()
        if not math.isfinite(sum(map(sum, (self.omega_B.tolist(), self.r_N.tolist(), self.v_N.tolist(), *reference)))):
            self._refuse_not_finite()
        connected = [min(value) > -ABSENT_MIN and max(value) < ABSENT_MIN for value in reference]
        if any(connected) and not all(connected):
            missing = ("R_ref", "Omega_ref", "dOmega_ref")[connected.index(False)]
            raise ValueError(
                f"{missing}: expected to be connected: connect R_ref, Omega_ref and dOmega_ref, or none of them, "
                f"found {ABSENT_MIN:g} or more"
            )
        return connected[0]

    @cached_property
    def has_attitude(self) -> bool:
        """Returns whether R_NB is none of the matrices of zeros that simple masters give before the first value."""
        return any(map(any, self.R_NB.tolist()))

    def _refuse_not_finite(self) -> None:
        for name in ("omega_B", "r_N", "v_N", "R_ref", "Omega_ref", "dOmega_ref"):
            if not np.isfinite(value := getattr(self, name)).all():
                raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")


@dataclass(frozen=True)
class State:
    """The errors that the gains [10] have latched, and whether the controller has flown with an attitude."""

    t: float
    attitude_error_0: float
    """|zeta(0)| of [10], rad, latched at the start."""
    rate_error_0: float
    """|omega(0)| of [10], rad/s, latched at the start."""
    latched: bool = True
    """Whether the two are latched; they wait for the first attitude with a reference, and anew after a time without."""
    flown: bool = False
    """Whether a step has had an attitude; from then on a matrix of zeros is refused where no reference is connected."""


@dataclass  # not frozen, which takes three times as long
class Outputs:
    """tau_cmd_B, rate_error_B (3,) in body axes. Units and frames are those of fmus/interfaces/controller.toml."""

    tau_cmd_B: Array
    attitude_error: float
    rate_error_B: Array
    lyapunov: float
    gain_k: float
    gain_l: float
    no_attitude: bool


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0, with |zeta(0)| and |omega(0)| of the inputs as they stand."""
    x = State(t=0.0, attitude_error_0=0.0, rate_error_0=0.0, latched=False)
    return x if _damps_only(x, u) else _latched(x, u, p)


def _latched(x: State, u: Inputs, p: Parameters) -> State:
    """With the errors of the inputs at x.t, where none are latched."""
    if x.latched:
        return x
    e = _errors(x.t, u, p)
    return State(x.t, e.angle, so3.norm(e.omega), True, x.flown)


def _no_attitude(x: State, u: Inputs) -> bool:
    """Returns whether there is none. Once flown, only where a reference is connected: who gives it knows of an
    attitude that is lost."""
    return not u.has_attitude and (not x.flown or u.has_reference)


def _damps_only(x: State, u: Inputs) -> bool:
    """Returns whether attitude or reference is missing. Raises ValueError for inputs that do not fit."""
    return (u.has_reference and not u.R_ref.any()) or _no_attitude(x, u)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The law [8] at the time x.t; damping of the rate alone where there is no attitude or no reference."""
    if _damps_only(x, u):
        return _damping(u, p, _no_attitude(x, u))
    x = _latched(x, u, p)
    e = _errors(x.t, u, p)
    k, l = _gains(x, e, p)  # noqa: E741 the paper's letter
    K = k * p.K0
    L = l * p.L0
    phi_value, phi_slope = morse.phi(p.phi, p.phi_scale, morse.trace(K, e.Q))
    M_g = law.NO_MOMENT
    if p.compensate_gravity:
        M_g = law.gravity_gradient(p.gravitational_parameter, p.J_B, u.R_NB, u.r_N)
    return Outputs(
        tau_cmd_B=law.torque(p.J_B, K, L, phi_slope, e, M_g),
        attitude_error=e.angle,
        rate_error_B=e.omega,
        lyapunov=law.lyapunov(p.J_B, phi_value, e.omega),
        gain_k=k,
        gain_l=l,
        no_attitude=False,
    )


def _damping(u: Inputs, p: Parameters, no_attitude: bool) -> Outputs:
    """tau = -L omega with |omega(0)| = |omega| in [10]; the error of attitude is unknown, and given as the largest.

    omega (3,) rad/s is the rate, less the one that is asked for where only the attitude of the reference is missing.
    """
    omega = u.omega_B if u.R_ref.any() else u.omega_B - u.Omega_ref
    rate = so3.norm(omega)
    scheduled = p.gain_schedule == "error"
    l = gains.rate_scale(p.lambda0, p.c1, p.c2, rate, rate) if scheduled else p.lambda0  # noqa: E741 the paper's letter
    return Outputs(
        tau_cmd_B=-l * (p.L0 @ omega),
        attitude_error=math.pi,
        rate_error_B=omega,
        lyapunov=law.lyapunov(p.J_B, 0.0, omega),
        gain_k=0.0,
        gain_l=l,
        no_attitude=no_attitude,
    )


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h, and so is the torque."""
    if _damps_only(x, u):
        x = State(x.t + h, 0.0, 0.0, latched=False, flown=not _no_attitude(x, u))
    else:
        x = _latched(State(x.t + h, x.attitude_error_0, x.rate_error_0, x.latched, flown=True), u, p)
    return x, outputs(x, u, p)


def _errors(t: float, u: Inputs, p: Parameters) -> Errors:
    so3.require_rotation("R_NB", u.R_NB, ATTITUDE_TOLERANCE)
    return errors(u.R_NB, u.omega_B, _reference(t, u, p))


def _reference(t: float, u: Inputs, p: Parameters) -> Reference:
    if u.has_reference:
        so3.require_rotation("R_ref", u.R_ref, ATTITUDE_TOLERANCE)
        return Reference(u.R_ref, u.Omega_ref, u.dOmega_ref)
    if p.reference == "lvlh":
        return relative(lvlh(u.r_N, u.v_N), p.desired_attitude_0)
    if p.reference == "inertial":
        return inertial(p.desired_attitude_0)
    return rate(p.desired_attitude_0, p.Omega_d0, t)


def _gains(x: State, e: Errors, p: Parameters) -> tuple[float, float]:
    if p.gain_schedule == "constant":
        return p.kappa0, p.lambda0
    return (
        gains.attitude_scale(p.kappa0, p.a1, p.a2, e.angle, x.attitude_error_0),
        gains.rate_scale(p.lambda0, p.c1, p.c2, so3.norm(e.omega), x.rate_error_0),
    )
