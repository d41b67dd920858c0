"""When a hold begins and is left; and holds that are hard to keep, judged by the plant's truth."""

import contextlib
import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import orchestration
from studies.flight.schemes import change
from studies.satellites.classes import tumbles
from tests.native.driver import Instance

from .block import (
    AS_MEASURED,
    BLOCK,
)


def flown(satellite, run, errors, duration, signals):
    """A tumble of docs/satellites.md: times, s, attitude error, deg, and more signals."""
    group = tumbles(satellite, run + 1, errors)
    data = change(json.loads(json.dumps(group.scenario)), group.drawn()[run])
    record = {"interval": 2.0, "signals": ["judge.attitude_error", *signals]}
    result = orchestration.run({**data, "duration": duration, "record": record})
    return result.time, np.degrees(result["judge.attitude_error"]), *(result[name] for name in signals)


def test_a_1U_under_all_errors_keeps_its_hold_while_the_field_stands_across_the_wheel():
    """From 4850 s to 5700 s the field's part along the wheel's axis is small; with a horizon of 30 T alone it is lost there."""
    time, error, field, phase = flown("1U", 8, True, 5800.0, ["plant.b_B", "controller.phase"])
    held = time > 1000.0
    assert np.abs(field[held, 0] / np.linalg.norm(field[held], axis=1)).min() < 0.01
    assert (phase[held] == 3).all()
    assert error[held].max() < 1.0


def turned(degrees):
    return Rotation.from_rotvec([0.0, math.radians(degrees), 0.0]).as_matrix()


@contextlib.contextmanager
def holding():
    """A controller at the target, from when its hold begins, and a function that steps it n times and returns its phases."""
    with Instance(BLOCK) as it:
        it.set("reference", "inertial")
        for name, value in AS_MEASURED.items():
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


@pytest.mark.parametrize(("degrees", "phase"), [(4.5, 3), (5.5, 2)])
def test_a_hold_is_left_beyond_five_degrees_and_not_before(degrees, phase):
    with holding() as (it, step):
        it.set("R_NB", turned(degrees))
        seen = step(40)
        assert np.degrees(it.get("attitude_error")) > 0.9 * degrees
    assert set(seen) == {3} if phase == 3 else 2 in seen
