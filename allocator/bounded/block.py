"""The bounded allocator as a block: parameters, ports, memory and step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .allocation import Allocated, Preference, allocate, limits, rod_matrix, spin_torque
from .box import Array

UNIT_TOLERANCE = 1e-6
"""max ||u| - 1| of the axes of rods and wheel."""
INDEPENDENT_MIN = 1e-6
"""|det U| below which the rods count as lying in one plane."""
FIELD_MIN = 1e-12
"""T. A field below a thousandth of a nanotesla counts as none, and then nothing is asked of the rods."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""
ROD_LIMIT_MIN = 0.01
ROD_WEIGHT_MIN = 1e-8
"""T. Below it the preference along the field would drown in rounding."""
FRACTION_CAP = 1e6
"""Largest demand_fraction that is reported."""


@dataclass(frozen=True)
class Parameters:
    """rod_axes (3, 3) by rows, wheel_axis (3,). Units, frames and limits are those of
    fmus/interfaces/allocator_bounded.toml."""

    rod_axes: Array
    dipole_max: float
    rod_limits: Array
    wheel_axis: Array
    wheel_torque_max: float
    wheel_momentum_max: float
    command_period: float
    desaturation_time: float
    rod_weight: float
    wheel_weight: float
    wheel_weight_ff: float

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
    """Vectors (3,), in body axes but for those along the rods. Units and frames are those of
    fmus/interfaces/allocator_bounded.toml."""

    tau_cmd_B: Array
    b_B: Array
    omega_B: Array
    h_w: float
    dipole_ff: Array
    wheel_torque_ff: float
    rod_gains: Array


@dataclass(frozen=True)
class State:
    """Nothing is remembered but the time."""

    t: float


@dataclass(frozen=True)
class Outputs:
    """dipole_cmd (3,) along the rods, tau_residual_B (3,) in body axes. Units and frames are those of
    fmus/interfaces/allocator_bounded.toml."""

    dipole_cmd: Array
    wheel_torque_cmd: float
    holding: bool
    demand_fraction: float
    tau_residual_B: Array
    b_wheel: float


def check(p: Parameters) -> None:
    """Raises ValueError for parameters that the allocation cannot work with."""
    _check_axes(p.rod_axes, p.wheel_axis)
    for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max", "command_period", "desaturation_time"):
        if not 0.0 < (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")
    if not ((p.rod_limits >= ROD_LIMIT_MIN) & (p.rod_limits <= 1.0)).all():
        raise ValueError(f"rod_limits: expected {ROD_LIMIT_MIN:g} to 1, found {p.rod_limits.tolist()}")
    for name, least in (("rod_weight", ROD_WEIGHT_MIN), ("wheel_weight", 0.0), ("wheel_weight_ff", 0.0)):
        if not least <= (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number of at least {least:g}, found {value!r}")


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
    """The state at t = 0; the first command is that of the inputs u."""
    _require_finite(u)
    return State(0.0)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The commands that serve the demand best within the limits; x has no say in them."""
    _require_finite(u)
    B = math.hypot(*u.b_B.tolist())
    gains = np.ones(3) if (np.abs(u.rod_gains) >= ABSENT_MIN).any() else u.rod_gains
    R = rod_matrix(u.b_B, p.U) * gains if B >= FIELD_MIN else np.zeros((3, 3))
    spin = spin_torque(u.omega_B, u.h_w, p.axis)
    limit = limits(u.h_w, p.command_period, p.dipole_max * p.rod_limits, p.wheel_torque_max, p.wheel_momentum_max)
    given = allocate(u.tau_cmd_B - spin, R, p.axis, limit, _preference(u, p, B >= FIELD_MIN))
    if not math.isfinite(sum(given.dipole.tolist()) + given.wheel_torque):
        given = Allocated(np.zeros(3), 0.0, math.inf)  # inputs so large that their products overflow
    return Outputs(
        dipole_cmd=given.dipole,
        wheel_torque_cmd=given.wheel_torque,
        holding=False,
        demand_fraction=given.fraction if given.fraction < FRACTION_CAP else FRACTION_CAP,
        tau_residual_B=u.tau_cmd_B - (R @ given.dipole + spin - given.wheel_torque * p.axis),
        b_wheel=float(u.b_B @ p.axis) / B if B >= FIELD_MIN else 0.0,
    )


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h."""
    return State(x.t + h), outputs(x, u, p)


def _preference(u: Inputs, p: Parameters, field: bool) -> Preference:
    """Feed-forward where it is connected; else no dipole, and the wheel on its way to rest. No dipole without a
    field."""
    rods = field and not (np.abs(u.dipole_ff) >= ABSENT_MIN).any()
    wheel = abs(u.wheel_torque_ff) < ABSENT_MIN
    return Preference(
        dipole=u.dipole_ff if rods else np.zeros(3),
        wheel_torque=u.wheel_torque_ff if wheel else -u.h_w / p.desaturation_time,
        rod_weight=p.rod_weight,
        wheel_weight=p.wheel_weight_ff if wheel else p.wheel_weight,
    )


def _require_finite(u: Inputs) -> None:
    for name in ("tau_cmd_B", "b_B", "omega_B", "dipole_ff", "rod_gains"):
        if not math.isfinite(sum((value := getattr(u, name)).tolist())):
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    for name in ("h_w", "wheel_torque_ff"):
        if not math.isfinite(value := getattr(u, name)):
            raise ValueError(f"{name}: expected a finite number, found {value!r}")
