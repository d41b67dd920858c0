"""The allocator as a block: parameters, ports, memory and step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from . import hold
from .allocation import FIELD_MIN, Singular, achieved, allocate, demand_fraction
from .hold import Commands
from .vector import Array, norm

UNIT_TOLERANCE = 1e-6
"""max ||u| - 1| of the axes of rods and wheel."""
INDEPENDENT_MIN = 1e-6
"""|det U| below which the rods count as lying in one plane."""


@dataclass(frozen=True)
class Parameters:
    """rod_axes (3, 3) by rows, wheel_axis (3,). Units, frames and limits are those of
    fmus/interfaces/allocator.toml."""

    rod_axes: Array
    dipole_max: float
    wheel_axis: Array
    wheel_torque_max: float
    wheel_momentum_max: float
    hold_fraction: float

    @cached_property
    def U(self) -> Array:
        """rod_axes with unit rows."""
        return self.rod_axes / np.linalg.norm(self.rod_axes, axis=1, keepdims=True)

    @cached_property
    def axis(self) -> Array:
        """wheel_axis of unit length: the paper's e1."""
        return self.wheel_axis / np.linalg.norm(self.wheel_axis)


@dataclass(frozen=True)
class Inputs:
    """Demand, field and rate (3,) in body axes, and the wheel's momentum. Units and frames are those of
    fmus/interfaces/allocator.toml."""

    tau_cmd_B: Array
    b_B: Array
    omega_B: Array
    h_w: float


@dataclass(frozen=True)
class State:
    """The commands that may be held."""

    t: float
    dipole: Array
    """Last commanded dipoles, A m2."""
    wheel_torque: float
    """Last commanded dl_w/dt, N m."""
    holding: bool
    """Whether the last step held."""


@dataclass  # not frozen, which takes three times as long
class Outputs:
    """dipole_cmd (3,) along the rods, tau_residual_B (3,) in body axes. Units and frames are those of
    fmus/interfaces/allocator.toml."""

    dipole_cmd: Array
    wheel_torque_cmd: float
    holding: bool
    demand_fraction: float
    tau_residual_B: Array
    b_wheel: float


def check(p: Parameters) -> None:
    """Raises ValueError for parameters that the allocation cannot work with."""
    _check_axes(p.rod_axes, p.wheel_axis)
    for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max"):
        if not 0.0 < (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")
    if not 0.0 < p.hold_fraction <= 1.0:
        raise ValueError(f"hold_fraction: expected a number above 0 and at most 1, found {p.hold_fraction!r}")


def _check_axes(rod_axes: Array, wheel_axis: Array) -> None:
    """Raises ValueError for axes that are not of unit length, or rods in one plane."""
    if not np.isfinite(rod_axes).all():
        raise ValueError(f"rod_axes: expected finite numbers, found {rod_axes.tolist()}")
    for i, length in enumerate(np.linalg.norm(rod_axes, axis=1).tolist(), start=1):
        if abs(length - 1.0) > UNIT_TOLERANCE:
            raise ValueError(
                f"rod_axes: expected rows of unit length to {UNIT_TOLERANCE:g}, "
                f"found |u{i}| = {length:.9g}: {rod_axes.tolist()}"
            )
    if not abs(volume := float(np.linalg.det(rod_axes))) > INDEPENDENT_MIN:
        raise ValueError(
            f"rod_axes: expected linearly independent axes, |det| above {INDEPENDENT_MIN:g}, "
            f"found {volume:.3g}: {rod_axes.tolist()}"
        )
    if not abs((length := float(np.linalg.norm(wheel_axis))) - 1.0) <= UNIT_TOLERANCE:
        raise ValueError(
            f"wheel_axis: expected a vector of unit length to {UNIT_TOLERANCE:g}, found {length:.9g}: "
            f"{wheel_axis.tolist()}"
        )


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0: the command of these inputs is remembered, zero where it would be held at once."""
    nothing_yet = State(0.0, hold.NONE.dipole, hold.NONE.wheel_torque, False)
    return _remember(0.0, outputs(nothing_yet, u, p))


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The allocation [14]-[24] of the demand, or what x remembers while it is held."""
    _require_finite(u)
    try:
        wanted = Commands(*allocate(u.tau_cmd_B, u.b_B, u.omega_B, u.h_w, p.U, p.axis))
        fraction = min(demand_fraction(*wanted, p.dipole_max, p.wheel_torque_max), hold.FRACTION_CAP)
    except Singular:
        wanted, fraction = hold.NONE, hold.FRACTION_CAP
    given, holding = hold.choose(fraction, p.hold_fraction, wanted, Commands(x.dipole, x.wheel_torque))
    tau_achieved = achieved(
        *given, u.b_B, u.omega_B, u.h_w, p.U, p.dipole_max, p.wheel_torque_max, p.wheel_momentum_max, p.axis
    )
    return Outputs(
        dipole_cmd=given.dipole,
        wheel_torque_cmd=given.wheel_torque,
        holding=holding,
        demand_fraction=fraction,
        tau_residual_B=u.tau_cmd_B - tau_achieved,
        b_wheel=_b_wheel(u.b_B, p.axis),
    )


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h, and the commands given then are remembered."""
    y = outputs(x, u, p)
    return _remember(x.t + h, y), y


def _remember(t: float, y: Outputs) -> State:
    return State(t, y.dipole_cmd, y.wheel_torque_cmd, y.holding)


def _b_wheel(b_B: Array, axis: Array) -> float:
    """The component of the field's unit vector along the wheel's axis (the paper's b1); 0 without a field."""
    B = norm(b_B)
    return float(b_B.dot(axis)) / B if B >= FIELD_MIN else 0.0


def _require_finite(u: Inputs) -> None:
    if math.isfinite(sum(u.tau_cmd_B.tolist() + u.b_B.tolist() + u.omega_B.tolist(), u.h_w)):
        return
    for name, value in (("tau_cmd_B", u.tau_cmd_B), ("b_B", u.b_B), ("omega_B", u.omega_B)):
        if not math.isfinite(sum(value.tolist())):
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    if not math.isfinite(u.h_w):
        raise ValueError(f"h_w: expected a finite number, found {u.h_w!r}")
