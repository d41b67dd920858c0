"""The hold of a satellite whose time T is much shorter than the orbit, judged by the plant's truth."""

import json

import numpy as np

import orchestration
from studies.flight.schemes import change
from studies.satellites.classes import tumbles


def test_a_1U_under_all_errors_keeps_its_hold_while_the_field_stands_across_the_wheel():
    """From 4850 s to 5700 s the field's part along the wheel's axis is small; with a horizon of 30 T alone it is lost there."""
    group = tumbles("1U", 9, errors=True)
    data = change(json.loads(json.dumps(group.scenario)), group.drawn()[8])
    signals = ["judge.attitude_error", "plant.b_B", "controller.phase"]
    flown = orchestration.run({**data, "duration": 5800.0, "record": {"interval": 2.0, "signals": signals}})
    held = flown.time > 1000.0
    error, field = np.degrees(flown["judge.attitude_error"][held]), flown["plant.b_B"][held]
    assert np.abs(field[:, 0] / np.linalg.norm(field, axis=1)).min() < 0.01
    assert (flown["controller.phase"][held] == 3).all()
    assert error.max() < 1.0
