"""Flights of a review are flown once, and again where something that decides them has changed."""

import pytest

from design.review import flights
from design.review.flights import Flight, fly
from orchestration import InputError, run
from orchestration.errors import BlockError
from orchestration.scenario.text import written

CHANGES = {"duration": "4 s", "blocks": {"plant": {"start": {"Q0": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}}}
SIGNALS = ("plant.R_NB", "judge.attitude_error")


def test_a_flight_is_the_run_of_the_scenario_that_stands_beside_it(satellite, tmp_path):
    flown = fly(satellite, [Flight("one", CHANGES, SIGNALS)], tmp_path, 0)["one"]
    result = run(tmp_path / "one.yaml")
    assert flown.time.tolist() == [0.0, 2.0, 4.0]
    assert (flown["plant.R_NB"] == result["plant.R_NB"]).all()
    assert flown.failure == ""


def test_what_has_been_flown_is_not_flown_again(satellite, tmp_path, monkeypatch):
    first = fly(satellite, [Flight("one", CHANGES, SIGNALS)], tmp_path, 0)["one"]
    with monkeypatch.context() as patched:
        patched.setattr(flights, "whole", lambda scenario: pytest.fail("it was flown again"))
        again = fly(satellite, [Flight("one", CHANGES, SIGNALS)], tmp_path, 0)["one"]
    assert (again["judge.attitude_error"] == first["judge.attitude_error"]).all()
    changed = {**CHANGES, "duration": "6 s"}
    assert len(fly(satellite, [Flight("one", changed, SIGNALS)], tmp_path, 0)["one"].time) == 4


def _in_the_middle(data):
    """Bytes of an array, which only its checksum tells."""
    at = data.index(b"NUMPY") + 140
    return data[:at] + bytes(255 - byte for byte in data[at : at + 8]) + data[at + 8 :]


@pytest.mark.parametrize(
    "damaged",
    [lambda data: b"nothing", lambda data: b"", lambda data: data[: len(data) // 2], _in_the_middle],
    ids=["other bytes", "empty", "cut", "bytes in the middle"],
)
def test_a_damaged_record_is_flown_again(satellite, tmp_path, damaged):
    whole = fly(satellite, [Flight("one", CHANGES, SIGNALS)], tmp_path, 0)["one"]
    record = tmp_path / "one.npz"
    record.write_bytes(damaged(record.read_bytes()))
    again = fly(satellite, [Flight("one", CHANGES, SIGNALS)], tmp_path, 0)["one"]
    assert all((again[name] == whole[name]).all() for name in SIGNALS)


def test_a_flight_that_fails_says_why(satellite, tmp_path):
    lost = {**CHANGES, "faults": [{"at": "2 s", "cut": "judge.R_NB"}]}
    flown = fly(satellite, [Flight("lost", lost, SIGNALS)], tmp_path, 0)["lost"]
    assert flown.failure.startswith("judge: ")
    assert len(flown.time) >= 1


def test_a_wrong_change_is_told_with_its_place(satellite, tmp_path):
    wrong = {"duration": "4 s", "blocks": {"plant": {"start": {"dipole": 1}}}}
    with pytest.raises(InputError, match=r"one\.yaml:\d+.*dipole"):
        fly(satellite, [Flight("one", wrong, SIGNALS)], tmp_path, 0)


@pytest.mark.parametrize(
    ("does", "told"),
    [("os._exit(0)", "ended its process, with exit status 0"), ("time.sleep(60)", "did not return within 1 s")],
    ids=["ends its process", "never returns"],
)
def test_a_law_that_takes_the_process_along_ends_its_own_flight_alone(satellite, tmp_path, does, told):
    """In the flight of the file as it stands it ends the review, and no other is flown."""
    (tmp_path / "law.py").write_text(
        f"import os, time\ndef step(i, p, t, h):\n    if t > 1: {does}\n    return {{'tau_cmd_B': [0.0] * 3}}\n"
    )
    own = {"name": "own", "extends": str(satellite), "blocks": {"controller": {"python": "law.py", "timeout": "1 s"}}}
    (tmp_path / "own.yaml").write_text(written(own))
    turned = Flight("one", CHANGES, SIGNALS)
    assert told in fly(tmp_path / "own.yaml", [turned], tmp_path / "out", 0)["one"].failure
    with pytest.raises(BlockError, match=told):
        flights.motion(tmp_path / "own.yaml", "4 s", tmp_path / "out")
