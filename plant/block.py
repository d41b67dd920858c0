"""The plant as a block: `state, outputs = step(state, inputs, parameters, h)`.

It owns the truth: whatever is commanded, rods and wheels stay within their physical limits here.
The command is held over the step; moments are those of the moving satellite in the moving field.
Tests: tests/plant/test_invariants.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import gravity_gradient, rods, sun
from .attitude import COMPOSITIONS, Moment, lgvi_step
from .parameters import OfWheels, Parameters
from .so3 import Array, to_quaternion
from .wheel import Part, momentum_saturated, net_torque, parts

INTERNAL_STEPS_MAX = 1e6
"""In one communication step."""


@dataclass(frozen=True)
class Inputs:
    """dipole_cmd (3,) A m2 along the rods, wheel_torque_cmd N m, (4,) for a set of wheels."""

    dipole_cmd: Array
    wheel_torque_cmd: OfWheels


@dataclass(frozen=True)
class State:
    """All that the plant remembers: time s, attitude (3,3), body momentum Pi (3,) [12] and the momentum of each
    wheel (n,), N m s.

    Pi rather than Omega, so that no change between the two adds rounding to what is conserved.
    """

    t: float
    R: Array
    Pi: Array
    l_w: Array
    angle: Array
    """Of each wheel (n,), rad; kept where one is not balanced."""
    dipole_mean: Array = field(default_factory=lambda: np.zeros(3))
    """Of the rods over the last step, A m2."""

    def Omega(self, p: Parameters) -> Array:
        """Body rate (3,), rad/s: J^-1 (Pi - sum l_i u_i), u_i the wheels' axes."""
        return p.body.J_inverse.dot(self.Pi - wheels_momentum(self.l_w, self.angle, p))


@dataclass  # not frozen, which takes three times as long
class Outputs:
    """Units and frames as in fmus/interfaces/plant.toml; those of a wheel are (4,) for a set."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array
    h_w: OfWheels
    q_NB: Array
    tau_gg_B: Array
    tau_drag_B: Array
    tau_mag_B: Array
    dipole: Array
    wheel_torque: OfWheels
    wheel_speed: OfWheels
    H_N: Array
    energy: float
    density: float
    dipole_saturated: bool
    wheel_torque_saturated: OfWheels
    wheel_momentum_saturated: OfWheels
    field_extrapolated: bool
    dipole_mean: Array
    sun_N: Array
    sunlight: float


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0."""
    l_w = np.array(p.of_wheels(p.h_w0))
    angle = np.zeros(len(l_w))
    return State(t=0.0, R=p.R_NB0, Pi=p.body.J @ p.omega_B0 + wheels_momentum(l_w, angle, p), l_w=l_w, angle=angle)


def wheels_momentum(l_w: Array, angle: Array, p: Parameters) -> Array:
    """Momentum (3,) of the wheels in body axes, N m s, of l_w (n,) and the angle (n,) of each."""
    sum_ = l_w.dot(p.wheel_axes)
    return sum_ if p.imbalances is None else sum_ + p.imbalances.momentum(angle, l_w)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h, h > 0, with the command u held over the step."""
    given = dipoles(u.dipole_cmd, p, True)
    dipoles_B = p.residual_dipole_B, p.rods_to_body.dot(given) + p.residual_dipole_B  # the rods off, and on
    dipole_B = dipoles_B[True]

    def moment(R: Array, t: float, Omega: Array) -> Array:
        """External moment (3,) N m in body axes."""
        around = p.environment.at(R, t)
        tau_mag_B = magnetic_moment(dipole_B, around.b_B)
        tau = tau_mag_B + p.disturbance_torque_B + around.tau_gg_B + around.tau_drag_B
        return tau if around.tau_solar_B is None else tau + around.tau_solar_B

    ratio = h / p.step_max * (1.0 - 1e-12)
    if not ratio <= INTERNAL_STEPS_MAX:
        raise ValueError(
            f"step_max: expected at least a millionth of the communication step, {h} s, found {p.step_max} s"
        )
    if p.rod_period > 0.0 and not h / p.rod_period <= INTERNAL_STEPS_MAX:
        raise ValueError(
            f"rod_period: expected at least a millionth of the communication step, {h} s, found {p.rod_period} s"
        )
    n = max(1, math.ceil(ratio))
    R, Pi, l_w, angle, on_time = x.R, x.Pi, x.l_w.tolist(), x.angle, 0.0
    commands = p.of_wheels(u.wheel_torque_cmd)
    for i in range(n):
        t = x.t + i * (h / n)
        for duration, on in p.rod_turns.parts(t, h / n):
            dipole_B = dipoles_B[on]
            on_time += duration if on else 0.0
            for part in parts(l_w, commands, duration, p.wheel_list):
                R, Pi = _advance(R, Pi, part, angle, moment, p, t)
                if p.imbalances is not None:
                    angle = p.imbalances.turned(part, angle, part.duration)
                t += part.duration
                l_w = part.ends()
    mean = min(on_time / h, 1.0) * given
    following = State(t=x.t + h, R=R, Pi=Pi, l_w=np.array(l_w), angle=angle, dipole_mean=mean)
    return following, outputs(following, u, p)


def _advance(
    R: Array, Pi: Array, part: Part, angle: Array, moment: Moment, p: Parameters, t: float
) -> tuple[Array, Array]:
    """The composed integrator over a part of a step in which the wheels move smoothly, from these angles (n,)."""
    s = 0.0
    tau = moment(R, t, p.body.J_inverse.dot(Pi - wheels_momentum(part.momentum(0.0), angle, p)))
    swing = np.zeros(3) if p.imbalances is None else p.imbalances.swing(angle)
    for share in COMPOSITIONS[p.integrator_order]:
        h = share * part.duration
        mean, end = part.mean(s, h).dot(p.wheel_axes), part.momentum(s + h).dot(p.wheel_axes)
        if p.imbalances is not None:
            turned, before = p.imbalances.turned(part, angle, s + h), swing
            swing = p.imbalances.swing(turned)
            mean, end = mean + (swing - before) / h, wheels_momentum(part.momentum(s + h), turned, p)
        R, Pi, tau = lgvi_step(R, Pi, tau, moment, p.body, t + s, h, mean, end)
        s += h
    return R, Pi


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """All outputs of a state and a command; commits nothing."""
    around = p.environment.at(x.R, x.t)
    r_N, v_N = around.r_N, around.v_N
    dipole = dipoles(u.dipole_cmd, p, p.rod_turns.on(x.t))
    Omega = x.Omega(p)
    energy = 0.5 * float(Omega.dot(p.body.J.dot(Omega)))
    H_N = x.R.dot(x.Pi)
    if p.gravity_gradient:
        h_x, h_y, h_z = _cross(r_N, v_N)
        H_x, H_y, H_z = H_N.tolist()
        energy += gravity_gradient.potential(around.r_hat_B, p.body.J, around.rate_squared)
        energy -= (h_x * H_x + h_y * H_y + h_z * H_z) / float(r_N.dot(r_N))
    each = list(zip(x.l_w.tolist(), p.of_wheels(u.wheel_torque_cmd), p.wheel_list, strict=True))

    def of_wheels(values: list[Any], unused: Any = 0.0) -> OfWheels:
        """A port of the wheels: a scalar where the block has one wheel, with zeros for those of a set that are not."""
        return np.array(values + [unused] * (len(p.wheel_axis) - len(values))) if p.is_set else values[0]

    sun_N, sunlight = sun.seen_from(r_N, p.sun.at(x.t))
    return Outputs(
        R_NB=x.R,
        omega_B=Omega,
        r_N=r_N,
        v_N=v_N,
        b_B=around.b_B,
        h_w=of_wheels(x.l_w.tolist()),
        q_NB=to_quaternion(x.R),
        tau_gg_B=around.tau_gg_B,
        tau_drag_B=around.tau_drag_B,
        tau_mag_B=magnetic_moment(p.rods_to_body.dot(dipole) + p.residual_dipole_B, around.b_B),
        dipole=dipole,
        wheel_torque=of_wheels([net_torque(*wheel) for wheel in each]),
        wheel_speed=of_wheels([l_w / wheel.inertia for l_w, _, wheel in each]),
        H_N=H_N,
        energy=energy,
        density=around.density,
        dipole_saturated=bool((np.abs(u.dipole_cmd) > p.dipole_limit).any()),
        wheel_torque_saturated=of_wheels([abs(command) > wheel.torque_max for _, command, wheel in each], False),
        wheel_momentum_saturated=of_wheels([momentum_saturated(*wheel) for wheel in each], False),
        field_extrapolated=p.field_extrapolated,
        dipole_mean=x.dipole_mean,
        sun_N=sun_N,
        sunlight=sunlight,
    )


def dipoles(dipole_cmd: Array, p: Parameters, on: bool) -> Array:
    """The dipoles (3,) A m2 that the rods give while they are on or off."""
    return rods.dipoles(dipole_cmd, p.dipole_limit, p.rod_gain, on)


def magnetic_moment(dipole_B: Array, b_B: Array) -> Array:
    """tau_MT = m x B [16], (3,) N m, of a dipole (3,) A m2 in a field (3,) T, all in body axes."""
    return np.array(_cross(dipole_B, b_B))


def _cross(x: Array, y: Array) -> tuple[float, float, float]:
    a, b, c = x.tolist()
    d, e, f = y.tolist()
    return (b * f - c * e, c * d - a * f, a * e - b * d)
