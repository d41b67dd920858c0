"""Flights of docs/evidence/satellites.md, and a controller in the hold that is shown any attitude: what tests of the
hold share."""

import contextlib
import json
import math

import numpy as np
from scipy.spatial.transform import Rotation

import orchestration
from evidence.flight.schemes import change
from evidence.satellites.classes import tumbles
from tests.native.driver import Instance

from .block import AS_MEASURED, BLOCK


def flown(satellite, run, errors, duration, signals):
    """A tumble of docs/evidence/satellites.md: times, s, attitude error, deg, and more signals."""
    return fly(tumbles(satellite, run + 1, errors), run, duration, signals)


def fly(group, run, duration, signals, **start):
    """A tumble of a group with other start values of the controller: times, s, attitude error, deg, and more
    signals."""
    data = change(json.loads(json.dumps(group.scenario)), group.drawn()[run])
    data = change(data, {f"controller.{name}": value for name, value in start.items()})
    record = {"interval": 2.0, "signals": ["judge.attitude_error", *signals]}
    result = orchestration.run({**data, "duration": duration, "record": record})
    return result.time, np.degrees(result["judge.attitude_error"]), *(result[name] for name in signals)


def turned(degrees):
    return Rotation.from_rotvec([0.0, math.radians(degrees), 0.0]).as_matrix()


@contextlib.contextmanager
def holding(**start):
    """A controller at the target, from when its hold begins, and a function that steps it n times and returns its
    phases."""
    with Instance(BLOCK) as it:
        it.set("reference", "inertial")
        for name, value in (AS_MEASURED | start).items():
            it.set(name, value)
        it.initialize()
        k = 0

        def step(n):
            nonlocal k
            seen = []
            for _ in range(n):
                it.step(0.5 * k, 0.5)
                k += 1
                seen.append(it.get("phase"))
            return seen

        assert 3 in step(400), "61 s at the target are a hold"
        yield it, step
