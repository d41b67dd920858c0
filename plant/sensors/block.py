"""The sensors as a block: when each measures, what it remembers, and what it puts out between its measurements.

Departures from the paper, whose law knows the true state: # not in the paper: all of it.
Tests: tests/plant/sensors/test_sensors.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import gnss, gyro, magnetometer, noise, star_tracker, sun_sensors, telemetry
from .noise import Array
from .parameters import Parameters
from .signal_loss import lost

SNAP = 1e-6
"""Of a period: a measurement this little ahead is taken, so that rounding delays none."""
PERIODS_MAX = 1e9
"""In one communication step."""
ABSENT_MIN = 0.999e9
"""An optional input that holds this or more is not connected; its start is 1e9, which a host may have rounded."""
COUNT_MAX = 2**31 - 1

ATTITUDE, RATE, FIELD, ORBIT, SUN, TELEMETRY = CLOCKS = range(6)
"""The sensors that have a period of their own."""
COUNTERS = ("attitude_sample", "rate_sample", "field_sample", "orbit_sample", "sun_sample")
"""Outputs that count their measurements; telemetry has none."""


@dataclass(frozen=True)
class Inputs:
    """The truth; the last three are optional."""

    R_NB: Array
    omega_B: Array
    r_N: Array
    v_N: Array
    b_B: Array
    h_w: float | Array
    """(4,) of a set of wheels, as h_w_measured is."""
    sun_N: Array
    sunlight: float
    dipole: Array


@dataclass(frozen=True)
class Outputs:
    """The measurements, in the units and frames of the truth, and how many there were up to now."""

    R_NB_measured: Array
    omega_B_measured: Array
    r_N_measured: Array
    v_N_measured: Array
    b_B_measured: Array
    h_w_measured: float | Array
    sun_sensors: Array
    sun_B_measured: Array
    dipole_measured: Array
    rate_sample: int
    field_sample: int
    attitude_sample: int
    orbit_sample: int
    sun_sample: int


@dataclass(frozen=True)
class State(Outputs):
    """The last measurements, and what the sensors remember beside them."""

    sample: NDArray[np.int64]
    """(6,) number of each clock's last measurement, lost ones included"""
    since: Array
    """(6,) s since it was due: the time itself would gather rounding with each step"""
    before: NDArray[np.int64]
    """(5,) COUNTERS before the last measurement"""
    rate_span: float
    """s from the gyro's measurement before to its last; 0 where there is none"""
    rate_walk: Array
    rate_markov: Array
    """(3,) rad/s"""
    attitude_lost: bool
    orbit_lost: bool


def start(p: Parameters, u: Inputs) -> State:
    """The state at t = 0: measurement 0 of each sensor is taken."""
    zeros = np.zeros(3)
    nothing = Outputs(
        np.zeros((3, 3)), zeros, zeros, zeros, zeros, 0.0 * u.h_w, np.zeros(6), zeros, zeros, 0, 0, 0, 0, 0
    )
    memory = {
        **vars(nothing),
        "sample": np.zeros(6, dtype=np.int64),
        "since": np.zeros(6),
        "before": np.zeros(5, dtype=np.int64),
        "rate_span": p.periods[RATE],
        "rate_walk": zeros,
        "rate_markov": gyro.correlated(zeros, p, 0, math.inf),
        "attitude_lost": False,
        "orbit_lost": False,
    }
    return _measured(memory, u, p, CLOCKS)


def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:
    """The measurements that hold: those of the last sample or, where there is no period, of the inputs as they
    stand."""
    return _measured(vars(x), u, p, [i for i in CLOCKS if p.periods[i] == 0.0])


def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:
    """From t to t + h; u is the truth at t + h."""
    if p.has_rod_coupling and _connected(u.dipole) is None:
        raise ValueError(
            f"dipole: expected to be connected, since field_rod_coupling is not zero, found {ABSENT_MIN:g} or more"
        )
    if p.attitude_sun_exclusion > 0.0 and _connected(u.sun_N) is None:
        raise ValueError(
            f"sun_N: expected to be connected, since attitude_sun_exclusion is not zero, found {ABSENT_MIN:g} or more"
        )
    memory = vars(x).copy()
    sample, since, before, spans = x.sample.tolist(), x.since.tolist(), x.before.tolist(), {}
    for i, T in enumerate(p.periods):
        periods, passed = 1, h
        if T > 0.0:
            periods, since[i] = _due(since[i] + h, T, h, p.period_names[i])
            passed = periods * T
        if periods > 0:
            sample[i] += periods
            spans[i] = passed
            if i < len(COUNTERS):
                before[i] = memory[COUNTERS[i]]
    memory["sample"], memory["since"], memory["before"] = np.array(sample), np.array(since), np.array(before)
    if RATE in spans:
        memory["rate_span"] = spans[RATE]
        if p.has_drift:
            memory["rate_walk"] = gyro.walked(x.rate_walk, p, sample[RATE], spans[RATE])
            memory["rate_markov"] = gyro.correlated(x.rate_markov, p, sample[RATE], spans[RATE])
    if ATTITUDE in spans and p.attitude_outage_interval > 0.0:
        times = p.attitude_outage_interval, p.attitude_outage_duration, spans[ATTITUDE]
        memory["attitude_lost"] = lost(x.attitude_lost, *times, p.seed, sample[ATTITUDE], noise.ATTITUDE_LOSS)
    if ORBIT in spans and p.orbit_outage_interval > 0.0:
        times = p.orbit_outage_interval, p.orbit_outage_duration, spans[ORBIT]
        memory["orbit_lost"] = lost(x.orbit_lost, *times, p.seed, sample[ORBIT], noise.ORBIT_LOSS)
    following = _measured(memory, u, p, list(spans))
    return following, following


def _due(since: float, T: float, h: float, name: str) -> tuple[int, float]:
    """Returns how many measurements of the period T are due `since` s after the last one was, and s since the
    latest of them was."""
    if not since / T <= PERIODS_MAX:
        raise ValueError(f"{name}: expected at least {1.0 / PERIODS_MAX:g} of the step, {h} s, found {T} s")
    periods = math.floor(since / T + SNAP)
    return periods, since - periods * T


def _measured(memory: dict[str, Any], u: Inputs, p: Parameters, due: Sequence[int]) -> State:
    """The state `memory` with new measurements of the truth u by the sensors that are due, of the numbers in it."""
    y = memory.copy()
    sample, before = memory["sample"].tolist(), memory["before"].tolist()
    sun_N, dipole = _connected(u.sun_N), _connected(u.dipole)
    sunlight = u.sunlight if abs(u.sunlight) < ABSENT_MIN else 1.0
    for i in due:
        k, given = sample[i], True
        if i == ATTITUDE:
            given = not memory["attitude_lost"]
            given = given and star_tracker.sees(u.R_NB, u.omega_B, u.r_N, sun_N, sunlight, p)
            y["R_NB_measured"] = star_tracker.measured(u.R_NB, p, k) if given else np.zeros((3, 3))
        elif i == RATE:
            drift = memory["rate_walk"] + memory["rate_markov"] if p.has_drift else None
            y["omega_B_measured"] = gyro.measured(u.omega_B, drift, p, k, memory["rate_span"])
        elif i == FIELD:
            y["b_B_measured"] = magnetometer.measured(u.b_B, dipole, p, k)
        elif i == ORBIT:
            given = not memory["orbit_lost"]
            if given:
                y["r_N_measured"], y["v_N_measured"] = gnss.measured(u.r_N, u.v_N, p, k)
        elif i == SUN:
            given = sun_N is not None
            if sun_N is not None:
                s_B, r_B = u.R_NB.T @ sun_N, u.R_NB.T @ u.r_N
                y["sun_sensors"], y["sun_B_measured"] = sun_sensors.measured(s_B, sunlight, r_B, p, k)
                given = bool(y["sun_B_measured"].any())
        else:
            y["h_w_measured"], y["dipole_measured"] = telemetry.measured(u.h_w, dipole, p, k)
        if i < len(COUNTERS):
            y[COUNTERS[i]] = before[i] % COUNT_MAX + 1 if given else before[i]
    return State(**y)


def _connected(value: Array) -> Array | None:
    """An optional input, or None where it is not connected."""
    return value if max(map(abs, value.tolist())) < ABSENT_MIN else None
