"""The bounded allocator as a block, for one wheel or for a set of them: ports, memory and step."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .allocation import Actuators, allocate, null_space_motion, rod_matrix, spin_torque, wheel_limits
from .box import Array
from .parameters import OfWheels, Parameters
from .watch import Watch

FIELD_MIN = 1e-12
"""T. A field below a thousandth of a nanotesla counts as none, and then nothing is asked of the rods."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""
FRACTION_CAP = 1e6
"""Largest demand_fraction that is reported."""


@dataclass(frozen=True)
class Inputs:
    """Vectors (3,), in body axes but for those along the rods. Units and frames are those of
    fmus/interfaces/allocator_bounded.toml."""

    tau_cmd_B: Array
    b_B: Array
    omega_B: Array
    h_w: OfWheels
    dipole_ff: Array
    wheel_torque_ff: OfWheels
    rod_gains: Array
    wheel_gains: OfWheels = 1e9


@dataclass(frozen=True)
class State:
    """Of one wheel nothing is remembered but the time."""

    t: float
    watch: Array | None = None
    """(7, 4) of a set, the rows of its `Watch`: what its wheels have given of their commands."""


@dataclass(frozen=True)
class Outputs:
    """dipole_cmd (3,) along the rods, tau_residual_B (3,) in body axes. Units and frames are those of
    fmus/interfaces/allocator_bounded.toml."""

    dipole_cmd: Array
    wheel_torque_cmd: OfWheels
    holding: bool
    demand_fraction: float
    tau_residual_B: Array
    b_wheel: OfWheels
    wheel_failed: OfWheels = False
    wheel_reversed: OfWheels = False
    h_w_failed: OfWheels = False
    """Never: this flavour believes h_w."""
    h_w_estimate: OfWheels = 0.0


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0; the first command is that of the inputs u."""
    first = outputs(State(0.0), u, p)
    return State(0.0, Watch.begun(u.h_w, first.wheel_torque_cmd, p).rows() if p.is_set else None)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The commands that serve the demand best within the limits; of x only the wheels that have failed count."""
    _require_finite(u)
    B = math.hypot(*u.b_B.tolist())
    with_field = B >= FIELD_MIN
    gains = u.rod_gains if connected(u.rod_gains) else np.ones(3)
    by_rods = rod_matrix(u.b_B, p.U) * gains[: p.rods] if with_field else np.zeros((3, p.rods))
    watch = Watch(*x.watch) if x.watch is not None else None
    failed = watch.failed(p) if watch is not None else np.zeros(len(np.atleast_2d(p.wheel_axis)), bool)
    actuators = _actuators(u, p, by_rods, with_field, watch)
    spin = spin_torque(u.omega_B, p.of_wheels(u.h_w), p.axes)
    if watch is not None and not connected(u.wheel_gains):
        spin = spin - watch.by_trial(u.h_w, p) @ p.axes
    commands, fraction = allocate(u.tau_cmd_B - spin, actuators)
    if not math.isfinite(sum(commands.tolist())):  # inputs so large that their products overflow
        commands, fraction = np.zeros(len(commands)), math.inf
    dipole = np.zeros(3)
    dipole[: p.rods] = commands[: p.rods]
    return Outputs(
        dipole_cmd=dipole,
        wheel_torque_cmd=_to_port(commands[p.rods :], p),
        holding=False,
        demand_fraction=fraction if fraction < FRACTION_CAP else FRACTION_CAP,
        tau_residual_B=u.tau_cmd_B - (actuators.torque @ commands + spin),
        b_wheel=_to_port(p.axes @ u.b_B / B if with_field else np.zeros(p.wheels), p),
        wheel_failed=failed if p.is_set else False,
        wheel_reversed=watch.reversed(p) if watch is not None else np.zeros_like(failed) if p.is_set else False,
        h_w_failed=np.zeros_like(failed) if p.is_set else False,
        h_w_estimate=watch.expected if watch is not None else 0.0,
    )


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u are the inputs at t + h."""
    if x.watch is None:
        return State(x.t + h), outputs(x, u, p)
    watch = Watch(*x.watch).after(u.h_w, h, p)
    y = outputs(State(x.t, watch.rows()), u, p)
    kept = watch.keeping(u.h_w, y.wheel_torque_cmd, _gains(u, p, watch), p)
    return State(x.t + h, kept.rows()), replace(y, h_w_estimate=kept.expected)


def _gains(u: Inputs, p: Parameters, watch: Watch | None) -> Array:
    """What the wheels (4,) give of their commands: told by wheel_gains, else 0 of those that have failed, -1 of those
    that are reversed."""
    if connected(u.wheel_gains):
        return np.asarray(u.wheel_gains, np.float64)
    none = np.ones(len(np.atleast_2d(p.wheel_axis)))
    return none if watch is None else np.where(watch.failed(p), 0.0, watch.sign(p))


def connected(value: OfWheels) -> bool:
    """Returns whether an optional input is connected, by its value."""
    return not (np.abs(value) >= ABSENT_MIN).any()


def _to_port(values: Array, p: Parameters) -> OfWheels:
    """A port of the wheels: a scalar of one wheel; of a set with zeros for those that are not there."""
    return np.concatenate((values, np.zeros(len(p.wheel_axis) - len(values)))) if p.is_set else float(values[0])


def _actuators(u: Inputs, p: Parameters, by_rods: Array, with_field: bool, watch: Watch | None) -> Actuators:
    """Feed-forward is preferred where it is connected; else no dipole, and each wheel on its way to its target. No
    dipole is without a field. by_rods (3,rods): the rods' torques per A m2."""
    gains = p.of_wheels(_gains(u, p, watch))
    h_w, torque_max, momentum_max = map(p.of_wheels, (u.h_w, p.wheel_torque_max, p.wheel_momentum_max))
    rods_ff = with_field and connected(u.dipole_ff)
    wheel_ff = connected(u.wheel_torque_ff)
    to_target = -(h_w - p.wheel_momentum_target[: p.wheels] if p.is_set else h_w) / p.desaturation_time
    wheel_torque = p.of_wheels(u.wheel_torque_ff) if wheel_ff else to_target
    if p.null_space_momentum > 0.0 and p.null_space is not None and gains.all():
        motion = null_space_motion(h_w, p.null_space, p.null_space_momentum, momentum_max) / p.desaturation_time
        wheel_torque = wheel_torque + (motion - p.null_space @ wheel_torque) * p.null_space
    if watch is not None and not connected(u.wheel_gains):
        wheel_torque = watch.probing(wheel_torque, u.h_w, p)
    low, high = wheel_limits(h_w, p.command_period, torque_max, momentum_max)
    low, high = np.where(gains < 0.0, -high, low), np.where(gains < 0.0, -low, high)
    if watch is not None and not connected(u.wheel_gains):
        low, high = np.where(watch.is_tried(p), -torque_max, low), np.where(watch.is_tried(p), torque_max, high)
    of_rods = p.dipole_max * p.rod_limits[: p.rods]
    weights = (np.full(p.rods, p.rod_weight), np.full(p.wheels, p.wheel_weight_ff if wheel_ff else p.wheel_weight))
    return Actuators(
        torque=np.hstack((by_rods, -(p.axes * gains[:, None]).T)),
        limit=np.concatenate((of_rods, torque_max)),
        low=np.concatenate((-of_rods, low)),
        high=np.concatenate((of_rods, high)),
        preferred=np.concatenate((u.dipole_ff[: p.rods] if rods_ff else np.zeros(p.rods), wheel_torque)),
        weight=np.concatenate(weights),
    )


def _require_finite(u: Inputs) -> None:
    for name in ("tau_cmd_B", "b_B", "omega_B", "dipole_ff", "rod_gains"):
        if not math.isfinite(sum((value := getattr(u, name)).tolist())):
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    for name in ("h_w", "wheel_torque_ff", "wheel_gains"):
        if not np.isfinite(value := getattr(u, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {value!r}")
