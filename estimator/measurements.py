"""Each measurement against its prediction; the first attitude; what is beyond the gate.
Tests: tests/estimator/test_estimator.py.

Requirement: ES-1.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import health, lasting
from .filter import ATTITUDE, BIAS, RATE, Innovation, corrected
from .health import weighed
from .isolation import backed, gyro_lost, restarted, start_sigmas, suspected
from .parameters import Parameters
from .so3 import Array, exp, hat, log, norm
from .start import sine, triad
from .state import NO_MATRIX, Estimate, Measured, start_covariance

FIELD, SUN, TRACKER = range(3)
"""Numbers of the sensors that are gated."""
SENSOR = (health.FIELD, health.SUN, health.ATTITUDE)
"""Those of health.py."""
IN_A_ROW = 50.0
"""So many measurements of one sensor more above the gate than within it are a failure."""
ALIGNED = 4.4e-3
"""rad; what a star tracker may be off for long."""
START_FACTOR, ANCHOR_FACTOR = 10.0, 2.0
"""Of the first attitude's standard deviation, for that of the covariance at the start; less where an
earlier field gives it."""
START_ANGLE, ANCHOR_ANGLE = math.radians(10.0), math.radians(20.0)
"""Least angle between Sun and field, and between two fields, from which an attitude is made."""
ANCHOR_AGE = 900.0
"""s; a field that is older is no longer turned on by the gyro."""


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
    """With the first attitude, where there is one: of the star tracker, of Sun and field, of the field and an earlier
    one.

    `sigma`, T, is that of the field. What is measured now is taken once more, by the filter, so it counts little here.
    """
    off = sigma / norm(field_N)
    field = p.lasting_field / norm(field_N) + p.lasting_field_scale
    R, spread, lasts = None, math.pi, p.lasting_attitude
    sun_B = sun_B if x.watch[health.SUN].trusted else None
    b_B = b_B if x.watch[health.FIELD].trusted else None
    if new.R_NB is not None and x.watch[health.ATTITUDE].trusted:
        R, spread = new.R_NB, START_FACTOR * (p.attitude_noise_boresight + p.attitude_noise)
    elif sun_B is not None and b_B is not None:
        first, second = ((b_B, field_N), (sun_B, sun_N)) if off < p.sun_noise else ((sun_B, sun_N), (b_B, field_N))
        R = triad(first[0], second[0], first[1], second[1], START_ANGLE)
        spread = START_FACTOR * (off + p.sun_noise) / sine(field_N, sun_N)
        lasts = (field + p.lasting_sun) / sine(field_N, sun_N)
    elif x.anchored and x.by_gyro and b_B is not None:
        R = triad(b_B, x.anchor_B, field_N, x.anchor_N, ANCHOR_ANGLE)
        spread = ANCHOR_FACTOR * (2.0 * off + p.rate_bias_sigma * x.anchor_age) / sine(field_N, x.anchor_N)
        lasts = 2.0 * field / sine(field_N, x.anchor_N)
    if R is not None:
        x = replace(x, P=start_covariance(spread, *start_sigmas(x, p)), S=lasting.begun(lasts), since_start=0.0)
        return replace(x, R=R, known=True, tracking=True, anchored=False, in_a_row=np.zeros(3))
    if b_B is not None and x.by_gyro and (not x.anchored or x.anchor_age > ANCHOR_AGE):
        return replace(x, anchored=True, anchor_B=b_B, anchor_N=field_N, anchor_age=0.0)
    return x


def by_tracker(x: Estimate, R_NB: Array, p: Parameters) -> Estimate:
    axes, across, about = p.tracker_axes, p.attitude_noise**2, p.attitude_noise_boresight**2
    y = axes @ log(x.R.T @ R_NB)
    return _taken(x, TRACKER, Innovation(y, axes, NO_MATRIX, np.array((across, across, about)), ALIGNED), p)


def by_sun(x: Estimate, sun_B: Array, sun_N: Array, p: Parameters) -> Estimate:
    s = x.R.T @ sun_N
    error = sun_B - s
    y = error - float(s @ error) * s
    return _taken(x, SUN, Innovation(y, hat(s), NO_MATRIX, np.full(3, p.sun_noise**2)), p)


def by_field(x: Estimate, b_B: Array, field_N: Array, variance: float, p: Parameters) -> Estimate:
    b = x.R.T @ field_N
    biased = NO_MATRIX if gyro_lost(x, p) else np.eye(3)
    return _taken(x, FIELD, Innovation(b_B - b - x.field_bias, hat(b), biased, np.full(3, variance)), p)


def _taken(x: Estimate, sensor: int, innovation: Innovation, p: Parameters) -> Estimate:
    """With a measurement, unless it is beyond the gate or its sensor is not trusted."""
    if not x.tracking:
        return x
    error, P, value, scaled, gains = corrected(x.P, innovation)
    this = np.arange(3) == sensor
    w, within = x.watch[SENSOR[sensor]], value <= p.gate
    before = 0.0 if w.frozen else float(x.in_a_row[sensor])
    in_a_row = max(before - 1.0, 0.0) if within else min(before + 1.0, IN_A_ROW)
    well = backed(x, SENSOR[sensor])
    w, wrong = weighed(w, scaled, within and (well or sensor != FIELD))
    x = replace(
        x.watched(SENSOR[sensor], w),
        nis=np.where(this, value, x.nis),
        rejected=x.rejected + (this & (not within)),
        in_a_row=np.where(this, in_a_row, x.in_a_row),
    )
    if (wrong or in_a_row == IN_A_ROW) and not (w.frozen or w.repeats):
        x = restarted(x) if well else suspected(x, SENSOR[sensor], float(innovation.r[0]), p)
    if not (within and x.watch[SENSOR[sensor]].trusted and x.tracking):
        return x
    lost = gyro_lost(x, p)
    return replace(
        x,
        R=x.R @ exp(error[ATTITUDE]),
        rate=x.rate if x.by_gyro else x.rate + error[RATE],
        rate_bias=x.rate_bias + error[RATE] if x.by_gyro else x.rate_bias,
        field_bias=x.field_bias if lost else x.field_bias + error[BIAS],
        disturbance_B=x.disturbance_B + error[BIAS] if lost else x.disturbance_B,
        P=P,
        S=lasting.corrected(x.S, gains, innovation, lasting.lasting(sensor, innovation, p)),
    )
