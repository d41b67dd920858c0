"""Which of the parts that disagree is wrong: a sensor, the filter, or its gyro.

docs/how/health.md derives each limit. Tests: tests/estimator/test_health.py.

Requirement: ES-4.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import health
from .health import ATTITUDE, CALM, FIELD, RATE, SUN, averaged, weighed
from .lasting import DRIFT, without_rate
from .parameters import Parameters
from .rates import Torques
from .so3 import Array, cross, norm
from .state import Estimate

BACKED = 0.5
"""Of averages of sensors against each other that agree."""
RESTARTED = 600.0
"""s; a filter that starts again within it has a wrong gyro."""
RATE_UNKNOWN = 0.05
"""rad/s; deviation of the rate at a start without the gyro."""
RATE_LOST, STALE = 1e-3, 10.0
"""rad/s by which the rate changes over what the gyro takes to be frozen, and that time, s."""
TORQUE_OFF = 1.0
"""s^(1/2); the momentum's random walk where the gyro has failed, over the torques of turning and rods."""
LASTS, RADIAN = 6000.0, 1000.0
"""s for which the disturbance stays alike, an orbit; a radian of it."""
MISLED, MISLED_MOST = 5.0, 0.2
"""Offset that a magnetometer may have had before it is found: deviations of its noise, at most that of the field."""
CONSISTENT = 3.0
"""Deviations of the gyro from the equations of motion."""


def compared(
    x: Estimate,
    R_NB: Array | None,
    sun_B: Array | None,
    b_B: Array | None,
    sun_N: Array,
    field_N: Array,
    variance: float,
    p: Parameters,
) -> Estimate:
    """With the averages of what the sensors say of each other, whatever the attitude, in deviations."""
    deviation, sun = math.sqrt(variance), p.sun_noise * norm(field_N)
    trusted = x.watch[SUN].trusted
    if b_B is not None:
        b = b_B - x.field_bias
        angle = 0.0
        if sun_B is not None:
            angle = float(b @ sun_B - field_N @ sun_N) / math.sqrt(variance + sun * sun)
        off = np.array(((norm(b) - norm(field_N)) / deviation, angle, 0.0))
        alone = averaged(x.field_alone, off, x.watch[FIELD].since)
        small = (norm(alone) if trusted else abs(float(alone[0]))) < BACKED
        x = replace(x, field_alone=alone, field_calm=x.field_calm + x.watch[FIELD].since if small else 0.0)
        if R_NB is not None and x.watch[FIELD].trusted:
            off = (b - R_NB.T @ field_N) / deviation
            x = replace(x, field_by_tracker=averaged(x.field_by_tracker, off, x.watch[FIELD].since))
    if R_NB is not None and sun_B is not None and trusted:
        off = (sun_B - R_NB.T @ sun_N) / p.sun_noise
        x = replace(x, sun_by_tracker=averaged(x.sun_by_tracker, off, x.watch[SUN].since))
    return x


def backed(x: Estimate, sensor: int) -> bool:
    """Returns whether other sensors agree with one, whatever the filter says. None does with the Sun sensors."""
    if sensor == FIELD:
        return x.field_calm >= CALM
    return sensor == ATTITUDE and max(norm(x.field_by_tracker), norm(x.sun_by_tracker)) < BACKED


def suspected(x: Estimate, sensor: int, variance: float, p: Parameters) -> Estimate:
    """Without a sensor. What an offset of a magnetometer may have made of the estimate meanwhile is added to P."""
    w = x.watch[sensor]
    if sensor == FIELD and not w.suspect and p.lasting_field > 0.0:
        offset = min(MISLED * math.sqrt(variance), MISLED_MOST * norm(x.b_B))
        made = offset / p.lasting_field * x.S[:, DRIFT]
        x = replace(x, P=x.P + made @ made.T)
    return x.watched(sensor, replace(w, suspect=True))


def restarted(x: Estimate) -> Estimate:
    """The filter starts again: the last resort. Where it has done so just before, its gyro is wrong."""
    watch = list(x.watch)
    again = x.by_gyro and x.restarted and x.since_start < RESTARTED
    watch[RATE] = replace(watch[RATE], suspect=watch[RATE].suspect or again, calm=0.0)
    for i in (FIELD, SUN, ATTITUDE):
        # Without its gyro the filter judged the others by a rate that was wrong, and needs them for an attitude.
        suspect = watch[i].suspect and watch[RATE].trusted and not backed(x, i)
        watch[i] = replace(watch[i], mean=np.zeros(3), suspect=suspect)
    return replace(x, tracking=False, restarted=True, watch=tuple(watch))


def gyro_weighed(x: Estimate, measured: Array, p: Parameters) -> Estimate:
    """With the gyro against the equations of motion by which the filter goes without it."""
    spread = np.sqrt(np.diag(x.P)[3:6] + p.rate_bias_sigma * p.rate_bias_sigma)
    off = (measured - x.rate) / spread
    return x.watched(RATE, weighed(x.watch[RATE], off, norm(off) < CONSISTENT)[0])


def rate_chosen(x: Estimate, p: Parameters) -> Estimate:
    """Goes on by the equations of motion where the gyro is not to be trusted, and by the gyro where it is again."""
    by_gyro = x.watch[RATE].trusted
    if p.rate_source != "gyro" or by_gyro == x.by_gyro:
        return x
    P = x.P.copy()
    P[6:9] = 0.0
    P[:, 6:9] = 0.0
    if by_gyro:
        P[3:6] = 0.0
        P[:, 3:6] = 0.0
        P[3:6, 3:6] = p.rate_bias_sigma * p.rate_bias_sigma * np.eye(3)
        P[6:9, 6:9] = p.field_bias_sigma * p.field_bias_sigma * np.eye(3)
        return without_rate(replace(x, P=P, by_gyro=True), 0.0)
    P[6:9, 6:9] = disturbance_sigma(p) ** 2 * np.eye(3)
    x = replace(x, disturbance_B=np.zeros(3))
    omega = norm(x.omega_B)
    frozen = x.watch[RATE].health == health.FROZEN
    rate = RATE_LOST + omega * omega * STALE if frozen else 10.0 * RATE_LOST + p.rate_bias_sigma
    P[3:6] *= -1.0  # the rate's error is minus that of the bias
    P[:, 3:6] *= -1.0
    P[:3, :3] += 0.25 * rate * rate * STALE * STALE * np.eye(3)
    P[3:6, 3:6] += rate * rate * np.eye(3)
    return without_rate(replace(x, P=P, by_gyro=False), -1.0)


def gyro_lost(x: Estimate, p: Parameters) -> bool:
    """Returns whether the filter goes without its gyro. It then estimates a disturbance in the place of the field's
    bias.
    """
    return p.rate_source == "gyro" and not x.by_gyro


def disturbance_sigma(p: Parameters) -> float:
    """N m, of a disturbance that stays alike for LASTS: the momentum's random walk over RADIAN, by that time."""
    return p.momentum_random_walk / math.sqrt(RADIAN)


def unknown_torque(omega_B: Array, R: Array, torques: Torques) -> float:
    """Random walk of the momentum, N m s for 1 s, beside the disturbance: neither inertia nor rods are exact."""
    turning = cross(omega_B, torques.J @ omega_B)
    return TORQUE_OFF * (norm(turning) + norm(cross(torques.dipole_B, R.T @ torques.field_N)))


def start_sigmas(x: Estimate, p: Parameters) -> tuple[float, float]:
    """Returns sigmas of a start: rad/s, of the rate or the bias; T or N m, of the field's bias or the disturbance."""
    return (RATE_UNKNOWN, disturbance_sigma(p)) if gyro_lost(x, p) else (p.rate_bias_sigma, p.field_bias_sigma)
