"""Each measurement against its prediction; the first attitude; what is beyond the gate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .filter import ATTITUDE, BIAS, RATE, Innovation, corrected
from .parameters import Parameters
from .so3 import Array, cross, exp, hat, log, norm
from .start import triad
from .state import NO_MATRIX, Estimate, Measured, start_covariance

FIELD, SUN, TRACKER = range(3)
"""Numbers of the sensors that are gated."""
IN_A_ROW = 50
"""So many measurements of one sensor above the gate, one after the other, end the filter: it starts again."""
START_FACTOR = 10.0
"""Of the first attitude's standard deviation: the covariance at the start, next to which the first measurements count alone."""


def started(
    x: Estimate,
    new: Measured,
    sun_B: Array | None,
    b_B: Array | None,
    sun_N: Array,
    field_N: Array,
    sigma: float,
    p: Parameters,
) -> Estimate:
    """With the first attitude, where the measurements give one: of the star tracker, or of Sun and field; `sigma`, T, of the field."""
    if new.R_NB is not None:
        R, spread = new.R_NB, p.attitude_noise_boresight + p.attitude_noise
    elif sun_B is not None and b_B is not None:
        off = sigma / norm(field_N)
        first, second = ((b_B, field_N), (sun_B, sun_N)) if off < p.sun_noise else ((sun_B, sun_N), (b_B, field_N))
        attitude = triad(first[0], second[0], first[1], second[1])
        if attitude is None:
            return x
        R, spread = attitude, (off + p.sun_noise) / norm(cross(field_N, sun_N)) * norm(field_N)
    else:
        return x
    P = start_covariance(START_FACTOR * spread, p)
    return replace(x, R=R, P=P, known=True, tracking=True, in_a_row=(0, 0, 0))


def by_tracker(x: Estimate, R_NB: Array, p: Parameters) -> Estimate:
    axes, across, about = p.tracker_axes, p.attitude_noise**2, p.attitude_noise_boresight**2
    y = axes @ log(x.R.T @ R_NB)
    return _taken(x, TRACKER, Innovation(y, axes, NO_MATRIX, np.array((across, across, about))), p)


def by_sun(x: Estimate, sun_B: Array, sun_N: Array, p: Parameters) -> Estimate:
    s = x.R.T @ sun_N
    error = sun_B - s
    y = error - float(s @ error) * s
    return _taken(x, SUN, Innovation(y, hat(s), NO_MATRIX, np.full(3, p.sun_noise**2)), p)


def by_field(x: Estimate, b_B: Array, field_N: Array, variance: float, p: Parameters) -> Estimate:
    b = x.R.T @ field_N
    return _taken(x, FIELD, Innovation(b_B - b - x.field_bias, hat(b), np.eye(3), np.full(3, variance)), p)


def _taken(x: Estimate, sensor: int, innovation: Innovation, p: Parameters) -> Estimate:
    """With a measurement, unless it is beyond the gate."""
    if not x.tracking:
        return x
    error, P, value = corrected(x.P, innovation)
    nis = np.where(np.arange(3) == sensor, value, x.nis)
    if not value <= p.gate:
        in_a_row = _changed(x.in_a_row, sensor, x.in_a_row[sensor] + 1)
        rejected = _changed(x.rejected, sensor, x.rejected[sensor] + 1)
        tracking = in_a_row[sensor] < IN_A_ROW
        return replace(x, nis=nis, rejected=rejected, in_a_row=in_a_row, tracking=tracking)
    gyro = p.rate_source == "gyro"
    return replace(
        x,
        R=x.R @ exp(error[ATTITUDE]),
        rate=x.rate if gyro else x.rate + error[RATE],
        rate_bias=x.rate_bias + error[RATE] if gyro else x.rate_bias,
        field_bias=x.field_bias + error[BIAS],
        P=P,
        nis=nis,
        in_a_row=_changed(x.in_a_row, sensor, 0),
    )


def _changed(values: tuple[int, ...], index: int, value: int) -> tuple[int, ...]:
    return (*values[:index], value, *values[index + 1 :])
