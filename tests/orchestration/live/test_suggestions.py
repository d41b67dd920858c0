"""What a live page offers where the scenario names nothing: the suggestions of the interfaces that fit its loop."""

from __future__ import annotations

import math

import pytest

from fmus.interface import load as interface
from orchestration.fmu.interfaces import own, pages
from orchestration.live.suggestions import with_suggestions
from orchestration.live.system import checked
from orchestration.session.open import open_scenario
from orchestration.session.read import load


def with_suggested(**start):
    block = {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0, **start}}
    scenario = load({"name": "tumble", "step": 1.0, "duration": 10.0, "blocks": {"body": block}})
    return with_suggestions(scenario, open_scenario(scenario).plan)


def test_every_suggestion_names_a_variable_of_its_interface():
    for block in own():
        for entries in pages()[block].values():
            for entry in entries:
                keys = ("start", "set", "freeze", "cut", "of", "axis", "count", "rate", "latitude", "longitude")
                names = [entry[key].partition(" ")[0].partition("[")[0] for key in keys if key in entry]
                assert names
                assert set(names) <= set(interface(block).variables), (block, entry)


@pytest.mark.compile
def test_a_loop_without_live_has_the_sliders_and_faults_that_fit_it():
    scenario = with_suggested(omega_B0=[0.03, -0.02, 0.01], Q0={"axis": [2, -1, 2], "angle": "60 deg"})
    assert scenario.live is not None
    assert [slider.start for slider in scenario.live.sliders] == ["body.omega_B0", "body.Q0", "body.rod_gain[1]"]
    assert [fault.name for fault in scenario.live.faults] == ["rod 1 dead"]
    _, _, controls, _ = checked(scenario)
    assert controls[0].value == pytest.approx(math.degrees(math.hypot(0.03, 0.02, 0.01)))
    assert controls[1].value == pytest.approx(60.0)  # about the axis that the scenario has


@pytest.mark.compile
def test_what_is_zero_or_beyond_its_ends_in_the_scenario_has_no_slider():
    scenario = with_suggested(omega_B0=[0.3, 0.0, 0.0])  # 17 deg/s
    assert scenario.live is not None
    assert [slider.start for slider in scenario.live.sliders] == ["body.rod_gain[1]"]
