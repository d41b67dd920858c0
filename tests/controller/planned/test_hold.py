"""Holds that are hard to keep, judged by the plant's truth."""

import json

import numpy as np

import orchestration
from studies.flight.schemes import change
from studies.satellites.classes import tumbles


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


def test_a_hold_near_the_equator_is_not_given_up_where_the_wheel_comes_near_its_limit():
    """At 11.5 deg of inclination; where the angle counts as much as ever, the hold is left again and again, with errors to 23 deg."""
    time, error, wheel, phase = flown(
        "50 kg, wheel along (1, 2, 2)/3", 62, False, 20000.0, ["plant.h_w", "controller.phase"]
    )
    assert np.abs(wheel[time > 2000.0]).max() > 0.8667 * 0.03
    assert (phase[time > 2000.0] == 3).all()
    assert error[time > 3500.0].max() < 8.0
