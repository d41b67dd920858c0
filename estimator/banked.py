"""The estimate by the bank of filters: what `bank` puts in the place of the one filter.
Tests: tests/estimator/test_banked.py.

Requirement: ES-3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from . import bank as filters
from .bank import MARGIN, PRUNE_ANGLE, PRUNE_EVERY, PRUNE_MARGIN, STRAIN_MAX, UNIQUE, Bank, Faces, Noise
from .measurements import FIELD, IN_A_ROW, SUN, TRACKER
from .parameters import Parameters
from .so3 import Array
from .state import Estimate, Measured

CURRENT_LIGHT = 0.99
"""Of the Sun that must be seen for the currents of photodiodes to count."""
_HEADER = 8


@dataclass
class Banked:
    """The bank, None until the first field, and what is known beside it."""

    bank: Bank | None
    rate: Array
    """(3,) rad/s, of the gyro as measured"""
    taken: int = 0
    """Measurements of the field since filters were last taken out"""
    in_a_row: int = 0
    """Measurements of the field beyond the gate of the best filter, one after the other"""
    ambiguity: float = math.pi
    """rad, from the best attitude to the farthest that is not excluded"""
    strain: float = 0.0

    @property
    def doubtful(self) -> int:
        """1 where an attitude that is far from the best fits alike, 2 where the gyro's errors are not such as can be,
        else 0."""
        return 1 if not self.ambiguity < UNIQUE else 2 if not self.strain <= STRAIN_MAX else 0

    @property
    def packed(self) -> Array:
        """All of it as one array, in which an FMU keeps it."""
        header = np.array((*self.rate, self.taken, self.in_a_row, self.ambiguity, self.strain, 0.0))
        return header if self.bank is None else np.concatenate((header, self.bank.packed.ravel()))

    @classmethod
    def unpacked(cls, values: Array) -> Banked:
        """Returns what `packed` made the array of."""
        head, rows = values[:_HEADER], values[_HEADER:]
        bank = Bank.unpacked(rows.reshape(-1, 163)) if len(rows) else None
        return cls(bank, head[:3].copy(), int(head[3]), int(head[4]), float(head[5]), float(head[6]))

    @property
    def scale(self) -> Array:
        """(3,) of the gyro, by the best filter."""
        return np.zeros(3) if self.bank is None else self.bank.scale[self.bank.best]


@dataclass(frozen=True)
class Seen:
    """Directions that are usable at the end of a step, and those of the models."""

    b_B: Array | None
    field_variance: float
    sun_B: Array | None
    field_N: Array
    sun_N: Array
    sunlight: float


def by_bank(x: Estimate, all_: Banked, new: Measured, seen: Seen, p: Parameters, h: float) -> Estimate:
    """The estimate of the most likely filter, h s later, with what is measured then; `all_` is changed in place.

    Its attitude is given from the instant on at which no other one fits alike.
    """
    noise = Noise(
        field=math.sqrt(seen.field_variance),
        angle=p.angle_random_walk,
        bias_walk=p.rate_random_walk,
        bias=p.rate_bias_sigma,
        scale=p.rate_scale_sigma,
        light=p.sun_sensor_noise,
        field_bias=p.field_bias_sigma,
        field_walk=p.field_random_walk,
        gate=p.gate,
    )
    since, now = x.since_rate + h, all_.rate if new.omega_B is None else new.omega_B
    if all_.bank is not None:
        filters.propagate(all_.bank, all_.rate, now, h, noise, 0.0 if new.omega_B is None else since)
    elif seen.b_B is not None:
        all_.bank = filters.started(seen.b_B, seen.field_N, noise)
    all_.rate = now
    x = replace(x, since_rate=since if new.omega_B is None else 0.0)
    if (bank := all_.bank) is None:
        return replace(x, rate=now)
    x = _measured(x, bank, all_, new, seen, p, noise)
    best = bank.best
    all_.ambiguity, all_.strain = bank.ambiguity(MARGIN), bank.strain(noise)
    known = x.known or not all_.doubtful
    if all_.in_a_row >= IN_A_ROW:
        all_.bank, all_.taken, all_.in_a_row, all_.ambiguity, all_.strain = None, 0, 0, math.pi, 0.0
    bias = bank.bias[best]
    rate = (now - bias) / (1.0 + bank.scale[best]) + bias
    return replace(
        x,
        R=bank.R[best],
        rate=rate,
        rate_bias=bias,
        field_bias=bank.field_bias[best],
        P=bank.P[best][:9, :9],
        known=known,
        tracking=known and all_.bank is not None,
    )


def _measured(
    x: Estimate, bank: Bank, all_: Banked, new: Measured, seen: Seen, p: Parameters, noise: Noise
) -> Estimate:
    """With star tracker, Sun, currents and field; nis and rejections are those of the filter that was the best."""
    best, nis, rejected = bank.best, x.nis.copy(), x.rejected.copy()

    def took(sensor: int, values: Array) -> None:
        nis[sensor] = values[best]
        rejected[sensor] += not values[best] <= p.gate

    if new.R_NB is not None:
        across, about = p.attitude_noise**2, p.attitude_noise_boresight**2
        took(TRACKER, filters.by_tracker(bank, new.R_NB, p.tracker_axes, np.array((across, across, about)), noise))
    if seen.sun_B is not None:
        took(SUN, filters.by_sun(bank, seen.sun_B, seen.sun_N, p.sun_noise, noise))
    if new.sun_sensors is not None and seen.sunlight > CURRENT_LIGHT:
        faces = Faces(p.sun_sensor_axes, np.ones(6), p.albedo)
        filters.by_light(bank, new.sun_sensors, faces, seen.sun_N, x.r_N, noise)
    if seen.b_B is not None:
        took(FIELD, filters.by_field(bank, seen.b_B, seen.field_N, noise))
        all_.in_a_row = 0 if nis[FIELD] <= p.gate else all_.in_a_row + 1
        all_.taken += 1
        if all_.taken == PRUNE_EVERY:
            bank.pruned(PRUNE_MARGIN, PRUNE_ANGLE)
            all_.taken = 0
    return replace(x, nis=nis, rejected=rejected)
