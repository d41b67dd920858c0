"""The commands read a log and say what it shows; wrong files are refused by name."""

import csv
import json

import numpy as np
import pytest
import yaml

from evidence.flight_data.synthetic import angle, spinning
from inflight.records import read
from orchestration import run
from tests.commands import orchestrate

from .test_orbit import TLE


@pytest.fixture
def log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return written(tmp_path, spinning(3, 700, calibrated=False)[0])


def written(tmp_path, flight):
    """The file that describes a log of the flight."""
    (tmp_path / "tle.txt").write_text(TLE)
    with (tmp_path / "log.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["unix", "wx", "wy", "wz", "mx", "my", "mz"])
        table = np.column_stack((1693838903 + flight.t, np.degrees(flight.omega), 1e7 * flight.m))
        writer.writerows(table.tolist())
    columns = {
        "omega_B_measured": {"of": ["wx", "wy", "wz"], "unit": "deg/s"},
        "b_B_measured": {"of": ["mx", "my", "mz"], "unit": "mG"},
    }
    entry = {"file": "log.csv", "time": {"column": "unix", "scale": "UTC"}, "columns": columns}
    path = tmp_path / "log.yaml"
    path.write_text(yaml.safe_dump({"telemetry": entry, "orbit": {"tle": "tle.txt"}}))
    return path


def test_a_magnetometer_is_calibrated_and_its_result_is_taken_again(log):
    done = orchestrate("calibrate", "magnetometer", log, "--out", "m.json")
    assert "|B| rms 0." in done.output
    data = json.loads((log.parent / "m.json").read_text())
    assert set(data) >= {"matrix", "offset", "gain", "covariance", "verdict", "estimator"}
    again = orchestrate("calibrate", "magnetometer", log, "--known", "m.json", "--out", "again.json")
    assert again.exit_code == 0
    same = json.loads((log.parent / "again.json").read_text())
    np.testing.assert_allclose(same["matrix"], data["matrix"], atol=1e-9)
    assert same["rms"] < 1.1 * data["rms"]


def test_a_calibration_as_it_is_written_makes_the_size_of_the_column_that_of_the_field(log):
    orchestrate("calibrate", "magnetometer", log, "--out", "m.json")
    data = json.loads((log.parent / "m.json").read_text())
    entry = yaml.safe_load(log.read_text())
    entry["telemetry"]["columns"]["b_B_measured"] |= {key: data[key] for key in ("matrix", "offset", "gain", "unit")}
    log.write_text(yaml.safe_dump(entry))
    flight = read(log)
    size = np.linalg.norm(flight.orbit.field_N(), axis=1)
    assert np.std(np.linalg.norm(flight.m, axis=1) - size) < 5e-7
    model = (np.eye(3) + data["sensors"]["field_scale"]) @ np.array(data["matrix"])
    np.testing.assert_allclose(model, np.eye(3), atol=1e-12)


def test_records_that_nutate_are_forecast_with_the_inertia_of_the_others(log):
    done = orchestrate("identify", log, log, "--fit", "30 s")
    assert "with the inertia of the other records" in " ".join(done.output.split())


def test_a_gyro_is_calibrated_by_a_spin(log):
    done = orchestrate("calibrate", "gyro", log, "--out", "g.json")
    assert "along the spin" in done.output
    data = json.loads((log.parent / "g.json").read_text())
    assert data["verdict"]["bias across the spin and tilt of the magnetometer apart"] == "not shown"
    np.testing.assert_allclose(np.radians(data["offset"]), data["bias"], atol=1e-12)  # the log has deg/s
    assert data["unit"] == "deg/s"


def test_a_record_without_nutation_does_not_show_the_inertia(log):
    done = orchestrate("identify", log, "--fit", "30 s")
    assert done.exit_code == 1
    assert "not shown" in done.output


def test_an_ephemeris_is_a_record_for_a_scenario(log):
    arguments = ["tle.txt", "--start", "2023-09-04T14:48:23Z", "--duration", "60 s", "--out", "orbit.csv"]
    done = orchestrate("ephemeris", *arguments)
    assert 'orbit_start: "position_velocity"' in done.output
    assert (log.parent / "orbit.csv").read_text().startswith("t,r_N1 [m],r_N2 [m]")


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--start", "now", "--start now: epoch: expected UTC in ISO 8601"),
        ("--duration", "1x", "--duration 1x: unknown unit 'x'"),
        ("--duration", "-5 s", "--duration -5 s: expected a time above 0"),
        ("--duration", "1e12 s", "--duration 1e12 s: expected at most 10,000,000 steps of 10 s"),
        ("--step", "0", "--step 0: expected a time above 0"),
        ("--step", "70 s", "--step 70 s: expected at most --duration, 60 s"),
    ],
)
def test_a_wrong_option_of_an_ephemeris_is_named(log, option, value, message):
    given = {"--start": "2023-09-04T14:48:23Z", "--duration": "60 s", "--step": "10 s", option: value}
    arguments = ["tle.txt", "--out", "orbit.csv", *(part for pair in given.items() for part in pair)]
    done = orchestrate("ephemeris", *arguments)
    assert (done.exit_code, message in done.stderr) == (2, True)
    assert not (log.parent / "orbit.csv").exists()


def rows_of(log, ports, **names):
    """A block that plays columns of the test's log, with corrections where there are some."""
    entry = yaml.safe_load(log.read_text())["telemetry"]
    columns = entry["columns"]
    return {"telemetry": entry | {"columns": {port: columns[port] | names.get(port, {}) for port in ports}}}


def test_what_the_calibrations_write_flies_and_brings_an_attitude_where_the_raw_log_gives_none(tmp_path, monkeypatch):
    """The raw log through the estimator, and the same with what both commands wrote, against the true attitude."""
    monkeypatch.chdir(tmp_path)
    flight, R, *_ = spinning(5, 1200, scale=0.005, bias=(0.01, 0.0, -0.008), calibrated=False)
    log = written(tmp_path, flight)
    orchestrate("calibrate", "magnetometer", log, "--out", "m.json")
    orchestrate("calibrate", "gyro", log, "--out", "g.json")
    field, rate = (json.loads((log.parent / name).read_text()) for name in ("m.json", "g.json"))
    corrections = {
        "b_B_measured": {key: field[key] for key in ("matrix", "offset", "gain", "unit")},
        "omega_B_measured": {key: rate[key] for key in ("matrix", "offset", "unit")},
    }
    off = {}
    for name, corrected, start in (("before", {}, {}), ("after", corrections, field["estimator"] | rate["estimator"])):
        result = run(
            {
                "name": name,
                "step": 1.0,
                "duration": 1199,
                "blocks": {
                    "sensors": rows_of(log, corrections, **corrected),
                    "gnss": {"orbit": {"tle": "tle.txt", "start": "2023-09-04T14:48:23Z"}},
                    "estimator": {
                        "fmu": "estimator",
                        "start": {"epoch": "2023-09-04T14:48:23Z", "bank": True, "field_degree": 13} | start,
                    },
                },
                "connections": [
                    *(f"sensors.{port} -> estimator.{port}" for port in corrections),
                    "sensors.omega_B_measured_sample -> estimator.rate_sample",
                    "sensors.b_B_measured_sample -> estimator.field_sample",
                    *(f"gnss.{port} -> estimator.{port}_measured" for port in ("r_N", "v_N")),
                    "gnss.r_N_sample -> estimator.orbit_sample",
                ],
                "record": {"signals": ["estimator.R_NB", "estimator.attitude_valid"]},
            }
        )
        valid = result["estimator.attitude_valid"].ravel() > 0.5
        off[name] = np.degrees(angle(R[valid], result["estimator.R_NB"][valid])) if valid.any() else np.zeros(0)
    assert not len(off["before"])
    assert len(off["after"]) > 600
    assert off["after"].max() < 10.0
    assert np.sqrt(np.mean(off["after"][-300:] ** 2)) < 3.0


def test_sensors_with_the_values_of_a_calibration_measure_what_the_log_has(log):
    """The true field through `plant_sensors`, as it is by default and with the values; the log's gain drifts by 2%."""
    flight, R, B, omega = spinning(3, 700, calibrated=False)
    orchestrate("calibrate", "magnetometer", log, "--out", "m.json")
    with (log.parent / "true.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("t", "b1", "b2", "b3"))
        writer.writerows(np.column_stack((flight.t, np.einsum("nji,nj->ni", R, B))).tolist())
    off = {}
    for name, start in (("before", {}), ("after", json.loads((log.parent / "m.json").read_text())["sensors"])):
        columns = {"b_B": {"of": ["b1", "b2", "b3"], "unit": "T"}}
        entry = {"file": "true.csv", "time": {"column": "t", "scale": "elapsed"}, "columns": columns}
        still = {"R_NB": np.eye(3).tolist(), "omega_B": omega.tolist(), "r_N": [6.8e6, 0, 0], "v_N": [0, 7600.0, 0]}
        result = run(
            {
                "name": name,
                "step": 1.0,
                "duration": 699,
                "blocks": {
                    "field": {"telemetry": entry},
                    "sensors": {
                        "fmu": "plant_sensors",
                        "start": still | {"h_w": 0.0, "sun_N": [1, 0, 0], "sunlight": 1.0} | start,
                    },
                },
                "connections": ["field.b_B -> sensors.b_B"],
                "record": {"signals": ["sensors.b_B_measured"]},
            }
        )
        off[name] = np.sqrt(np.mean((result["sensors.b_B_measured"] - flight.m) ** 2))
    assert off["after"] < 2e-6 < 2e-5 < off["before"]
