"""A scenario's `orbit: {tle: ...}`: as a record, as a plant's start, and what is refused."""

import numpy as np
import pytest
from sgp4.api import Satrec

import orchestration
from orchestration.errors import InputError
from orchestration.scenario.load import load
from tests.inflight.test_orbit import TLE

START = "2023-09-04T14:48:23Z"


@pytest.fixture
def here(tmp_path, monkeypatch):
    (tmp_path / "elements.txt").write_text(TLE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scenario(**block):
    return {"name": "s", "step": 1.0, "duration": 20.0, "blocks": {"gnss": block}}


def test_position_and_velocity_are_those_of_sgp4_at_each_row(here):
    result = orchestration.run(scenario(orbit={"tle": str(here / "elements.txt"), "start": START}))
    satellite = Satrec.twoline2rv(*TLE.splitlines())
    for i in (0, 7, 20):
        _, r, v = satellite.sgp4(2460191.5, (14.0 + 48.0 / 60.0 + (23.0 + i) / 3600.0) / 24.0)
        assert result["gnss.r_N"][i] == pytest.approx(1e3 * np.array(r), abs=0.2)  # m, of a day in double precision
        assert result["gnss.v_N"][i] == pytest.approx(1e3 * np.array(v), abs=1e-3)


def test_a_plant_follows_sgp4_and_keeps_what_is_given(here):
    block = {"fmu": "plant", "orbit": {"tle": str(here / "elements.txt"), "start": START}}
    block["start"] = {"omega_B0": [0.0, 0.01, 0.0]}
    entry = load(scenario(**block)).blocks["gnss"]
    assert entry.orbit is None
    assert entry.start["orbit_start"] == "position_velocity"
    assert entry.start["epoch"] == START
    assert entry.start["omega_B0"] == [0.0, 0.01, 0.0]
    assert 6.7e6 < np.linalg.norm(entry.start["r_N0"]) < 7.0e6
    given = {**block, "start": {"j2_node_drift": False, "r_N0": [7e6, 0, 0]}}
    start = load(scenario(**given)).blocks["gnss"].start
    assert (start["j2_node_drift"], start["r_N0"]) == (False, [7e6, 0, 0])
    assert load(scenario(**given)).source.notes == ()


def test_a_run_flies_a_plant_and_its_field_along_sgp4_and_says_how_near(here):
    orbit = {"tle": str(here / "elements.txt"), "start": START}
    plant = {"fmu": "plant", "orbit": orbit, "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}}
    flown = {**scenario(orbit=orbit), "step": 10.0, "duration": 6000.0}
    flown["blocks"]["plant"] = plant
    result = orchestration.run(flown)
    off = np.linalg.norm(result["plant.r_N"] - result["gnss.r_N"], axis=1).max() / 1e3
    (note,) = [note for note in result.manifest["notes"] if "SGP4" in note]
    assert note.startswith("plant: its orbit follows that of SGP4 within ")
    assert note.endswith(" km over 6000 s")
    assert float(note.split()[-5]) == pytest.approx(off, abs=0.1)
    assert off < 4.0


@pytest.mark.parametrize(
    ("orbit", "message"),
    [
        ({"tle": "elements.txt", "start": "yesterday"}, "start: "),
        ({"tle": "nowhere.txt", "start": START}, "nowhere.txt"),
        ({"tle": "elements.txt", "start": "2024-09-04T14:48:23Z"}, "the nearest element set is 36"),
        ({"tle": "elements.txt"}, "start"),
        ({"tle": "elements.txt", "start": START, "step": 1e-6}, "expected at most 2000000 rows"),
    ],
)
def test_an_orbit_that_cannot_be_is_refused_at_its_place(here, orbit, message):
    with pytest.raises(InputError, match="blocks.gnss.orbit") as refused:
        load(scenario(orbit=orbit))
    assert message in str(refused.value)


def test_an_orbit_is_no_second_source_beside_a_record(here):
    telemetry = {"file": "x.csv", "time": {"column": "t", "scale": "elapsed"}, "columns": {"x": {"of": "x"}}}
    with pytest.raises(InputError, match="expected 'telemetry' alone, found 'orbit', too"):
        load(scenario(telemetry=telemetry, orbit={"tle": "elements.txt", "start": START}))
