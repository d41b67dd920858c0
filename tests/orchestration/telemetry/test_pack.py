"""A record is a block of a run: its rows are outputs at their own instants, in our loop and in another tool."""

import shutil

import fmpy
import numpy as np
import pytest

from fmus.build import ensure
from orchestration import load, run
from orchestration.errors import InputError
from orchestration.swap.option import swapped, swaps_of

LOG = "t,x,y,b\n0,1,2,10\n1,3,4,\n2.5,5,6,30\n4,7,8,40\n"
ENTRY = {
    "file": "log.csv",
    "time": {"column": "t", "scale": "elapsed"},
    "columns": {"w": {"of": ["x", "y"], "unit": "deg/s"}, "b": {"of": "b", "unit": "uT"}},
}


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_text(LOG, "utf-8")
    return {"name": "record", "step": 0.5, "duration": 5, "blocks": {"log": {"telemetry": dict(ENTRY)}}}


def column(result, name):
    return result.samples[:, result.labels.index(f"log.{name}")].tolist()


def test_control_characters_of_a_description_or_a_header_make_no_damaged_fmu(scenario, tmp_path):
    (tmp_path / "log.csv").write_text("t,\x1b[31mx,y\n0,1,2\n5,3,4\n", "utf-8")
    columns = {"w": {"of": ["\x1b[31mx", "y"], "unit": "deg/s", "description": "a\x07bell"}}
    scenario["blocks"]["log"]["telemetry"] |= {"columns": columns}
    assert column(run(scenario), "w[1]")[-1] == 3


def test_a_sample_is_valid_in_the_step_that_brings_it_and_is_held(scenario):
    result = run(scenario)
    assert column(result, "w[1]") == [1, 1, 3, 3, 3, 5, 5, 5, 7, 7, 7]
    assert column(result, "w_valid") == [1, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0]
    assert column(result, "b") == [10, 10, 10, 10, 10, 30, 30, 30, 40, 40, 40]
    assert column(result, "b_sample") == [1, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert column(result, "age")[-1] == 1.0
    assert column(result, "ended")[7:9] == [0, 1]


def test_a_matrix_is_a_port_of_its_shape_and_feeds_one(scenario):
    scenario["blocks"]["log"]["telemetry"]["columns"] = {"R": {"of": [["x", "y"], ["y", "x"]]}}
    result = run(scenario)
    assert result["log.R"].shape == (11, 2, 2)
    assert result["log.R"][5].tolist() == [[5, 6], [6, 5]]


def test_a_record_that_begins_after_the_run_is_told(scenario):
    scenario["blocks"]["log"]["telemetry"]["start"] = -20.0
    (note,) = run(scenario).manifest["notes"]
    assert "the first row is at 20 s, after the run" in note


def test_both_loops_and_a_second_run_give_the_same(scenario):
    wanted = run(scenario).samples
    np.testing.assert_array_equal(run(scenario, compiled=False).samples, wanted)
    np.testing.assert_array_equal(run(scenario).samples, wanted)


def test_hold_and_shift_are_parameters(scenario):
    scenario["blocks"]["log"]["start"] = {"hold": "0.5 s", "shift": "1 s"}
    result = run(scenario)
    assert column(result, "w_sample") == [0, 0, 1, 1, 2, 2, 2, 3, 3, 3, 4]
    assert column(result, "w_valid") == [0, 0, 1, 1, 1, 1, 0, 1, 1, 0, 1]


def test_connections_to_a_record_are_left_out_with_a_note(scenario):
    scenario["blocks"]["plant"] = {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}}
    scenario["connections"] = ["plant.R_NB -> log.R_NB"]
    result = run(scenario)
    assert any("a record takes no inputs; left out: log.R_NB" in warning for warning in result.warnings)


def test_an_entry_is_an_fmu_or_a_record(scenario):
    scenario["blocks"]["log"]["fmu"] = "plant"
    with pytest.raises(InputError, match="expected 'telemetry' alone, found 'fmu', too"):
        run(scenario)


def test_an_fmu_takes_the_place_of_a_record(scenario):
    scenario["blocks"]["log"]["start"] = {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}
    scenario["record"] = {"signals": ["log.energy"], "interval": 0.5}
    (swap,) = swaps_of([f"log={ensure('plant', 'native')}"], [])
    result = run(load(swapped(load(scenario).source, [swap])))
    assert len(column(result, "energy")) == 11


def test_an_error_of_the_file_names_its_line(scenario):
    with open("log.csv", "a") as file:
        file.write("5,six,6,1\n")
    with pytest.raises(InputError, match="log.csv:6: x: expected a number, found 'six'"):
        run(scenario)


def test_a_unit_that_ports_of_this_name_do_not_have_is_noted_at_its_line_though_nothing_reads_it(scenario):
    columns = {"omega_B_measured": {"of": ["x", "y", "b"], "unit": "furlong"}, "mine": {"of": "x", "unit": "furlong"}}
    scenario["blocks"]["log"]["telemetry"]["columns"] = columns
    (note,) = (note for note in run(scenario).manifest["notes"] if "furlong" in note)
    assert "columns.omega_B_measured.unit: 'furlong' does not fit 'rad/s', the unit that a port of this name" in note


def test_fmpy_plays_the_exported_record(scenario, tmp_path):
    from orchestration.session.open import open_fmus
    from orchestration.session.read import load

    fmu = tmp_path / "log.fmu"
    shutil.copy(open_fmus(load(scenario))["log"].path, fmu)
    played = fmpy.simulate_fmu(str(fmu), stop_time=5.0, output_interval=0.5, validate=True)
    np.testing.assert_array_equal(played["w[1]"], column(run(scenario), "w[1]"))
