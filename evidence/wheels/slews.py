"""Slews from rest to rest with sets of wheels against the least time: docs/evidence/wheels_slews.csv.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestration import run

from .. import files
from ..crew import crew
from ..flight.schemes import change
from ..paper import ROOT, Array
from ..satellites.classes import CLASSES, FIELD, SHARES
from .cases import CONDITIONS, SEED, WHEELS, Flights, scenario

FILE = ROOT / "docs" / "evidence" / "wheels_slews.csv"
ANGLES = (10, 30, 90, 180)
"""deg"""
SETTLED, SAMPLE = math.radians(0.1), 0.5
"""rad, and s between samples."""
WITHIN = 1.2
"""Least times and two samples: the requirement."""


@dataclass(frozen=True)
class Slew:
    """Angle in deg, times in s; inf where it does not settle."""

    satellite: str
    angle: int
    run: int
    least: float
    settled: float

    @property
    def ratio(self) -> float:
        """Least times that it takes, without two samples."""
        return (self.settled - 2.0 * SAMPLE) / self.least


def reach(axes: Array, limits: Array, along: Array) -> float:
    """The largest factor with which a vector (3,) is a sum of wheels within their limits."""
    from scipy.optimize import linprog  # optional, for this command alone  # noqa: PLC0415

    n = len(axes)
    bounds = [*[(-limit, limit) for limit in limits.tolist()], (None, None)]
    found = linprog([0.0] * n + [-1.0], A_eq=np.column_stack((axes.T, -along)), b_eq=np.zeros(3), bounds=bounds)
    return float(-found.fun)


def least_time(satellite: str, axis: Array, angle: float) -> float:
    """Returns the least time, s, of a turn from rest to rest by an angle, rad, within torques and momenta of wheels."""
    it, axes = CLASSES[satellite], WHEELS[satellite]
    along, one = np.array(it.moments) * axis, np.ones(len(axes))
    a, rate = (reach(axes, limit * one, along) for limit in (it.wheel_torque_max, it.wheel_momentum_max))
    return 2.0 * math.sqrt(angle / a) if angle < rate * rate / a else angle / rate + rate / a


def drawn(degrees: int, number: int) -> tuple[Array, Array]:
    """Axis and direction of the disturbance, unit vectors (3,)."""
    found = np.random.default_rng([SEED, degrees, number]).normal(size=(2, 3))
    axis, push = found / np.linalg.norm(found, axis=1, keepdims=True)
    return axis, push


def slew(which: tuple[str, int, int]) -> Slew:
    """Flies one: satellite, angle in deg and number; nominal, with drag and gravity gradient, about rest in N."""
    satellite, degrees, number = which
    axis, push = drawn(degrees, number)
    half = math.radians(degrees) / 2.0
    least = least_time(satellite, axis, 2.0 * half)
    data = scenario(Flights(satellite, "nominal"), CONDITIONS["nominal"])
    starts = {
        "plant.initial_attitude": "q_NB0",
        "plant.q_NB0": [math.cos(half), *(math.sin(half) * axis).tolist()],
        "plant.omega_B0": [0.0, 0.0, 0.0],
        "plant.disturbance_torque_B": SHARES[False] * CLASSES[satellite].dipole_max * FIELD * push,
        "controller.reference": "inertial",
        "judge.reference": "inertial",
    }
    duration = SAMPLE * round((2.0 * least + 60.0) / SAMPLE)
    record = {"interval": SAMPLE, "signals": ["judge.attitude_error"]}
    result = run({**change(data, starts), "duration": duration, "record": record})
    settled = result.settling("judge.attitude_error", SETTLED).time
    return Slew(satellite, degrees, number, least, math.inf if settled is None else settled)


def make(cases: int, jobs: int) -> Iterator[str]:
    """Flies so many about random axes of each satellite and angle, and writes the file."""
    wanted = [(name, angle, i) for name in WHEELS for angle in ANGLES for i in range(cases)]
    with crew(jobs) as hands:
        found = hands.each("slews", slew, wanted)
    files.save(Slew, FILE, found)
    yield f"{sum(one.ratio <= WITHIN for one in found)} of {len(found)} slews within the requirement"


def load() -> list[Slew]:
    return files.load_if_any(Slew, FILE, "python -m evidence wheels --part slews")
