"""The estimator as a block: what it takes, what it gives, which measurements are new.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from . import onboard
from .banked import Banked
from .estimate import advanced
from .lasting import bound
from .parameters import Parameters, check
from .so3 import Array, norm, require_rotation
from .state import Estimate, Given, Measured, blank

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]

ATTITUDE_TOLERANCE = 1e-4
"""max |R^T R - I| of a measured attitude: single precision stays well below it."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""
FIELD_MAX = 1e-3
"""T; no orbit has more, so a larger field is in another unit."""
R_MIN = 1e6
"""m"""
STEP_MAX = 1000.0
"""s"""


@dataclass(frozen=True)
class Inputs:
    """Measurements, the numbers of the last of each, and what the actuators do."""

    omega_B_measured: Array
    b_B_measured: Array
    r_N_measured: Array
    v_N_measured: Array
    R_NB_measured: Array
    sun_B_measured: Array
    rate_sample: int
    field_sample: int
    attitude_sample: int
    orbit_sample: int
    sun_sample: int
    dipole: Array
    h_w: float | Array
    wheel_torque: float | Array
    """(4,) of a set of wheels."""
    sun_sensors: Array

    @property
    def counts(self) -> Array:
        """(5,) in the order of Measured."""
        return np.array((self.rate_sample, self.field_sample, self.orbit_sample, self.attitude_sample, self.sun_sample))


@dataclass(frozen=True)
class Outputs:
    """The estimate."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array
    rate_bias_B: Array
    field_bias_B: Array
    attitude_sigma_B: Array
    attitude_bound: float
    covariance: Array
    attitude_valid: bool
    attitude_doubtful: int
    ambiguity: float
    rate_scale_B: Array
    nis: Array
    rejected: Array
    health: Array
    sun_N: Array
    sunlight: float


@dataclass(frozen=True)
class State:
    """The estimate before the last step and after it, packed; of that step its length, s, and what doStep alone
    takes; the bank of filters after it, packed, empty without one."""

    before: Array
    now: Array
    h: float
    counts: Array
    fresh: Array
    actuators: Array
    banked: Array


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0, at which what is measured is new; a number of 0 says that nothing has been measured yet."""
    banked = Banked(None, u.omega_B_measured) if p.bank else None
    return _stepped(blank(u.omega_B_measured, p), banked, u, p, 0.0, u.counts != 0)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The step again with the measurements as they stand; with a bank that of the last step. Raises ValueError for an
    input that cannot be."""
    _actuators(u)
    if p.bank:
        _measured(u, x.fresh)
        return _given_out(Estimate.unpacked(x.now), p, _banked(x))
    now = advanced(Estimate.unpacked(x.before), _measured(u, x.fresh), _given(x.actuators, p), p, x.h)
    return _given_out(now, p)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the measurements at t + h."""
    if not 0.0 <= h <= STEP_MAX:
        raise ValueError(f"step: expected at least 0 and at most {STEP_MAX:g} s, found {h}")
    x = _stepped(Estimate.unpacked(x.now), _banked(x), u, p, h, (u.counts < 0) | (u.counts != x.counts))
    return x, _given_out(Estimate.unpacked(x.now), p, _banked(x))


def _stepped(before: Estimate, banked: Banked | None, u: Inputs, p: Parameters, h: float, fresh: Array) -> State:
    actuators = _actuators(u)
    now = advanced(before, _measured(u, fresh), _given(actuators, p), p, h, banked)
    return State(
        before.packed, now.packed, h, u.counts, fresh, actuators, np.empty(0) if banked is None else banked.packed
    )


def _banked(x: State) -> Banked | None:
    return Banked.unpacked(x.banked) if len(x.banked) else None


def _actuators(u: Inputs) -> Array:
    """Dipoles, dl/dt and wheel momenta (5,), (11,) of a set. Raises ValueError for an input that is not finite."""
    for name in ("dipole", "wheel_torque", "h_w"):
        _require_finite(name, getattr(u, name))
    return np.hstack((u.dipole if _connected(u.dipole) else np.zeros(3), u.wheel_torque, u.h_w))


def _given(actuators: Array, p: Parameters) -> Given:
    wheels = actuators[3:].reshape(2, -1)
    torque, momentum = (p.of_wheels(each) if _connected(each) else None for each in wheels)
    return Given(actuators[:3], torque, momentum)


def _measured(u: Inputs, fresh: Array) -> Measured:
    """Returns the measurements that are new. Raises ValueError for an input that cannot be."""
    for name in (
        "omega_B_measured",
        "b_B_measured",
        "r_N_measured",
        "v_N_measured",
        "sun_B_measured",
        "sun_sensors",
        "R_NB_measured",
    ):
        _require_finite(name, getattr(u, name))
    if (b := norm(u.b_B_measured)) > FIELD_MAX:
        raise ValueError(f"b_B_measured: expected a field in tesla, at most {FIELD_MAX:g}, found {b}")
    position = bool(u.r_N_measured.any())
    if position and not (r := norm(u.r_N_measured)) >= R_MIN:
        raise ValueError(f"r_N_measured: expected at least 1000 km from the Earth's centre, found {r}")
    tracker, sun = _connected(u.R_NB_measured), _connected(u.sun_B_measured)
    if tracker := tracker and bool(u.R_NB_measured.any()):
        require_rotation("R_NB_measured", u.R_NB_measured, ATTITUDE_TOLERANCE)
    rate, field, orbit, attitude, light = fresh
    seen = norm(u.sun_B_measured) if sun else 0.0
    return Measured(
        omega_B=u.omega_B_measured if rate else None,
        b_B=u.b_B_measured if field and u.b_B_measured.any() else None,
        orbit=(u.r_N_measured, u.v_N_measured) if orbit and position else None,
        R_NB=u.R_NB_measured if attitude and tracker else None,
        sun_B=u.sun_B_measured / seen if light and seen > 0.0 else None,
        sun_sensors=_currents(u) if light else None,
    )


def _currents(u: Inputs) -> Array:
    return np.where(np.abs(u.sun_sensors) >= ABSENT_MIN, np.nan, u.sun_sensors)


def _given_out(x: Estimate, p: Parameters, banked: Banked | None = None) -> Outputs:
    doubtful = 0 if banked is None else banked.doubtful
    sigma = np.sqrt(np.diag(x.P)[:3]) if x.tracking else np.full(3, math.pi)
    sun_N = onboard.sun_direction(p.days + x.t / 86400.0)
    return Outputs(
        R_NB=x.R if x.known else np.zeros((3, 3)),
        omega_B=x.omega_B,
        r_N=x.r_N,
        v_N=x.v_N,
        b_B=x.b_B,
        rate_bias_B=x.rate_bias,
        field_bias_B=x.field_bias,
        attitude_sigma_B=sigma,
        attitude_bound=bound(x, doubtful != 0, p),
        covariance=x.P[:6, :6],
        attitude_valid=x.tracking and bool((sigma < p.valid_sigma).all()) and not doubtful,
        attitude_doubtful=doubtful,
        ambiguity=0.0 if banked is None else banked.ambiguity,
        rate_scale_B=np.zeros(3) if banked is None else banked.scale,
        nis=x.nis,
        rejected=x.rejected.astype(np.int32),
        health=np.array([w.health for w in x.watch], dtype=np.int32),
        sun_N=sun_N,
        sunlight=onboard.sunlight(x.r_N, sun_N) if x.oriented else 0.0,
    )


def _connected(value: Array | float) -> bool:
    return not (np.abs(value) >= ABSENT_MIN).any()


def _require_finite(name: str, value: Array | float) -> None:
    if not np.isfinite(value).all():
        raise ValueError(f"{name}: expected finite numbers, found {np.asarray(value).tolist()}")
