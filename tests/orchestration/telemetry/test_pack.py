"""A record is a block of a run: its rows are outputs at their own instants, in our loop and in another tool."""

import shutil

import fmpy
import numpy as np
import pytest
import yaml

from fmus.build import ensure
from orchestration import load, run
from orchestration.errors import InputError
from orchestration.swap.option import swapped, swaps_of
from tests.commands import orchestrate

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


def test_each_sample_is_held_as_long_as_the_others_whatever_the_rounding_of_its_time(scenario, tmp_path):
    """Rows at 0.1, 0.9, 1.7, ... s, held for 0.3 s: valid for four steps of 0.1 s each, and not for four."""
    times = [f"{0.1 + 0.8 * k:.1f}" for k in range(60)]
    (tmp_path / "log.csv").write_text("t,x,y,b\n" + "".join(f"{t},1,2,3\n" for t in times), "utf-8")
    scenario |= {"step": 0.1, "duration": 48}
    scenario["blocks"]["log"]["start"] = {"hold": 0.3}
    valid = column(run(scenario), "w_valid")
    assert valid[1:481] == [1, 1, 1, 1, 0, 0, 0, 0] * 60


def test_valid_does_not_flicker_where_times_jitter_and_falls_once_in_a_gap(scenario, tmp_path):
    rng = np.random.default_rng(1)
    times = [k + rng.uniform(-0.2, 0.2) for k in range(1, 60) if not 30 <= k < 36]
    (tmp_path / "log.csv").write_text("t,x,y,b\n" + "".join(f"{t:.6f},1,2,3\n" for t in times), "utf-8")
    scenario |= {"step": 0.25, "duration": 59}
    changes = {}
    for hold in (0.0, 1.5):
        scenario["blocks"]["log"]["start"] = {"hold": hold}
        result = run(scenario)
        changes[hold] = int(np.abs(np.diff(column(result, "w_valid"))).sum())
        assert column(result, "w_sample")[-1] == len(times)
    assert changes[1.5] == 3  # it rises, falls in the gap and rises behind it
    assert changes[0.0] > 50


def test_an_fmu_is_compared_with_ours_on_a_record(scenario, tmp_path):
    """The estimator on a record of gyro, field and orbit, beside itself and beside itself with another noise."""
    rng, turn = np.random.default_rng(2), 0.02
    rows = ["t,w,b1,b2,b3,r,v"]
    for t in (t for t in range(61) if not 20 <= t < 26):
        c, s = np.cos(turn * t), np.sin(turn * t)
        b = np.array((20.0 * c - 10.0 * s, -20.0 * s - 10.0 * c, 30.0)) + rng.normal(scale=0.1, size=3)
        rows.append(",".join(f"{x:.6g}" for x in (t, turn, *b, 6878.0, 7.6)))
    (tmp_path / "log.csv").write_text("\n".join([*rows, ""]), "utf-8")
    columns = {
        "omega_B_measured": {"of": "w", "unit": "rad/s", "matrix": [[0], [0], [1]]},
        "b_B_measured": {"of": ["b1", "b2", "b3"], "unit": "uT"},
        "r_N_measured": {"of": "r", "unit": "km", "matrix": [[1], [0], [0]]},
        "v_N_measured": {"of": "v", "unit": "km/s", "matrix": [[0], [0], [1]]},
    }
    samples = {"omega_B_measured": "rate", "b_B_measured": "field", "r_N_measured": "orbit"}
    scenario["blocks"] = {
        "log": {"telemetry": ENTRY | {"columns": columns}},
        "estimator": {"fmu": "estimator", "start": {"epoch": "2009-02-10T00:00:00Z"}},
    }
    scenario["connections"] = [f"log.{port} -> estimator.{port}" for port in columns]
    scenario["connections"] += [f"log.{port}_sample -> estimator.{name}_sample" for port, name in samples.items()]
    scenario |= {"step": 0.5, "duration": 60}
    (tmp_path / "replay.yaml").write_text(yaml.safe_dump(scenario), "utf-8")
    arguments = ("compare", "replay.yaml", "--swap", f"estimator={ensure('estimator', 'native')}", "-o", "out")
    done = orchestrate(*arguments)
    assert done.exit_code == 0, done.output
    assert "equivalent: 19 of 19 outputs within tolerance" in done.stdout
    assert (tmp_path / "out" / "comparison.html").exists()


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
