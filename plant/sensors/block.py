"""The sensors as a block: bias, white noise and sampling of what the plant puts out.

Departures from the paper, whose law knows the true state: # not in the paper: all of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .noise import Array, normals

SNAP = 1e-6
"""Of sample_period: a measurement this little ahead is taken, so that rounding delays none."""
PERIODS_MAX = 1e9
"""In one communication step."""
PERIOD_MIN = 1e-6
"""s."""

ATTITUDE, RATE, FIELD, WHEEL, POSITION, VELOCITY = range(6)
"""Numbers of the sensors, which keep their noise apart."""


@dataclass(frozen=True)
class Parameters:
    """Units, frames and limits are those of fmus/interfaces/plant_sensors.toml."""

    attitude_noise: float
    attitude_bias_B: Array
    rate_noise: float
    rate_bias_B: Array
    field_noise: float
    field_bias_B: Array
    wheel_momentum_noise: float
    position_noise: float
    velocity_noise: float
    sample_period: float
    seed: int


@dataclass(frozen=True)
class Inputs:
    """The truth."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array
    h_w: float


@dataclass(frozen=True)
class Outputs:
    """The measurements, in the units and frames of the truth."""

    R_NB_measured: Array
    omega_B_measured: Array
    r_N_measured: Array
    v_N_measured: Array
    b_B_measured: Array
    h_w_measured: float


@dataclass(frozen=True)
class State:
    """The number of the last measurement, the time since it was due, s, and what it found."""

    sample: int
    since: float
    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array
    h_w: float


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected."""
    for name in ("attitude_bias_B", "rate_bias_B", "field_bias_B"):
        if not np.isfinite(value := getattr(p, name)).all():
            raise ValueError(f"{name} is {value.tolist()}; expected finite numbers")
    for name in ("attitude", "rate", "field", "wheel_momentum", "position", "velocity"):
        if not 0.0 <= (sigma := getattr(p, f"{name}_noise")) < math.inf:
            raise ValueError(f"{name}_noise is {sigma}; expected a finite number, at least 0")
    if not (p.sample_period == 0.0 or PERIOD_MIN <= p.sample_period < math.inf):
        raise ValueError(f"sample_period is {p.sample_period} s; expected 0 (every step) or at least {PERIOD_MIN:g} s")
    if not 0 <= p.seed < 2**31:
        raise ValueError(f"seed is {p.seed}; expected 0 to {2**31 - 1}")


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0: measurement 0 is taken."""
    return _take(0, 0.0, u, p)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The measurements that hold: those of the last sample, or, without a sample_period, of the inputs as they stand."""
    if p.sample_period == 0.0:
        x = _take(x.sample, 0.0, u, p)
    return Outputs(x.R_NB, x.omega_B, x.r_N, x.v_N, x.b_B, x.h_w)


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u is the truth at t + h."""
    T = p.sample_period
    # The time since a sample was due rather than the time itself, whose rounding grows with each step.
    since = x.since + h
    if T == 0.0:
        x = _take(x.sample + 1, 0.0, u, p)
    elif not since / T <= PERIODS_MAX:
        raise ValueError(f"sample_period is {T} s; expected at least {1.0 / PERIODS_MAX:g} of the step, {h} s")
    elif (periods := math.floor(since / T + SNAP)) > 0:
        x = _take(x.sample + periods, since - periods * T, u, p)
    else:
        x = State(x.sample, since, x.R_NB, x.omega_B, x.r_N, x.v_N, x.b_B, x.h_w)
    return x, outputs(x, u, p)


def _take(sample: int, since: float, u: Inputs, p: Parameters) -> State:
    """Measurement number `sample` of the truth u."""

    def noise(sensor: int, sigma: float, n: int = 3) -> Array:
        return sigma * normals(p.seed, sample, sensor, n) if sigma > 0.0 else np.zeros(n)

    turn = p.attitude_bias_B + noise(ATTITUDE, p.attitude_noise)
    return State(
        sample=sample,
        since=since,
        R_NB=u.R_NB @ rotation(turn),
        omega_B=u.omega_B + p.rate_bias_B + noise(RATE, p.rate_noise),
        r_N=u.r_N + noise(POSITION, p.position_noise),
        v_N=u.v_N + noise(VELOCITY, p.velocity_noise),
        b_B=u.b_B + p.field_bias_B + noise(FIELD, p.field_noise),
        h_w=u.h_w + float(noise(WHEEL, p.wheel_momentum_noise, 1)[0]),
    )


def rotation(turn: Array) -> Array:
    """exp(turn^) (3,3), the rotation about `turn` (3,), rad, by its length: by way of its unit quaternion."""
    angle = math.sqrt(turn @ turn)
    w = math.cos(0.5 * angle)
    x, y, z = ((math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5) * turn).tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
