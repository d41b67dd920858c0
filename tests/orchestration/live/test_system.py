"""What no page can have is refused, with its place in the scenario."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestration.errors import InputError
from orchestration.live.sliders import controls
from orchestration.live.suggestions import with_suggestions
from orchestration.live.system import checked, prepare
from orchestration.session.open import open_scenario
from orchestration.session.read import load

pytestmark = pytest.mark.compile

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def minimal(**changes):
    data = {
        "name": "tumble",
        "step": 1.0,
        "duration": 10.0,
        "blocks": {"plant": {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}}},
    }
    return {**data, **changes}


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.yaml")), ids=lambda file: file.stem)
def test_what_each_scenario_says_of_its_page_fits_its_blocks(file):
    scenario = load(file)
    _, _, sliders, _ = checked(with_suggestions(scenario, open_scenario(scenario).plan))
    assert sliders


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blocks": {"plant": {"fmu": "other.fmu"}}}, "blocks.plant.fmu: other.fmu is an FMU in binaries"),
        ({"flavour": "python"}, "flavour: plant is of the Python flavour"),
        ({"isolation": "process"}, "isolation: plant runs in a process of its own"),
    ],
)
def test_what_no_page_can_have_is_refused_by_name(changes, message):
    with pytest.raises(InputError, match=message):
        prepare(load(minimal(**changes)))


@pytest.mark.parametrize(
    ("slider", "message"),
    [
        ({"start": "plan.omega_B0[1]"}, "there is no block 'plan'; did you mean 'plant'"),
        ({"start": "plant.omega_B0"}, "has 3 elements; remedy: one of them, or 'measure: norm'"),
        ({"start": "plant.epoch"}, "expected a number"),
        ({"start": "plant.disturbance_torque_B", "measure": "norm"}, "is zero in the scenario"),
        (
            {"start": "plant.Q0", "measure": "rotation", "axis": [1, 0, 0], "least": 1, "most": 2},
            "expected the scenario's own",
        ),
        ({"start": "plant.omega_B0[1]", "least": "1 m"}, "omega_B0"),
        ({"start": "plant.omega_B0[1]", "least": 2, "most": 1}, "expected 'least' below 'most'"),
        (
            {"start": "plant.omega_B0", "measure": "norm"},
            "expected zero or more, since a norm is never negative; found -",
        ),
        (
            {"start": "plant.Q0", "measure": "rotation", "axis": [1, 0, 0], "most": "9000 deg"},
            "expected angles within one turn, -360 deg to 360 deg; found -57.3 deg and 9000 deg",
        ),
        (
            {"start": "plant.inclination", "least": "10 deg", "most": "20 deg"},
            "expected the scenario's own value, 98 deg, between 10 deg and 20 deg",
        ),
        ({"start": "plant.altitude"}, "is worked out in Python"),
        ({"start": "friction"}, "no block takes such a shared value"),
    ],
)
def test_a_slider_that_can_move_nothing_is_refused_where_it_stands(slider, message):
    entry = {"least": -1, "most": 1, **slider}
    scenario = load(minimal(live={"sliders": [entry]}))
    with pytest.raises(InputError, match=message) as raised:
        controls(scenario, open_scenario(scenario).plan)
    assert "live.sliders[1]" in str(raised.value)


def test_faults_of_a_page_are_held_against_the_blocks_with_the_sliders_where_they_stand():
    faults = [{"name": "late", "set": "plant.rod_gain[1] = 0", "at": "20 s"}]
    sliders = [{"start": "plant.rod", "least": 0, "most": 1}]
    with pytest.raises(InputError) as raised:
        checked(load(minimal(live={"faults": faults, "sliders": sliders})))
    assert "live.faults[1]" in str(raised.value)
    assert "20 s lies after the end of the run, 10 s" in str(raised.value)
    assert "live.sliders[1]: plant.rod: " in str(raised.value)


def test_two_faults_with_one_name_are_refused():
    faults = [{"name": "dead", "set": f"plant.rod_gain[{i}] = 0", "at": "2 s"} for i in (1, 2)]
    with pytest.raises(InputError, match="live: faults: two have the name 'dead'"):
        load(minimal(live={"faults": faults}))
