"""Checked scenarios that are kept on disk between processes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from fmus import places
from orchestration.scenario.checked import checked_before, dumped
from orchestration.scenario.types import Model
from orchestration.session.read import load

SCENARIOS = sorted(places.shared("scenarios").glob("*.yaml"))


class Entry(Model):
    value: float


class Built(Model):
    value: float


def never() -> Entry:
    raise AssertionError("it was kept")


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(places, "work", lambda: tmp_path)
    monkeypatch.setattr("orchestration.scenario.checked._again", {})
    return tmp_path


@pytest.mark.usefixtures("work")
def test_the_same_data_are_checked_once_and_others_anew() -> None:
    first, second = Entry.model_construct(value=1.0), Entry.model_construct(value=2.0)
    assert checked_before(Entry, {"value": 1}, lambda: first) is first
    again = checked_before(Entry, {"value": 1}, never)
    assert again == first
    assert again is not first  # nor do two runs in a process share one
    for other in ({"value": "1"}, {"value": 1.0}, {"value": True}, {"other": 1}, {"value": [1]}):
        assert checked_before(Entry, other, lambda: second) is second


def test_nothing_is_kept_of_what_no_file_says(work: Path) -> None:
    for data in ({"value": (1,)}, {1: 1}, {"value": [Path("a")]}):
        checked_before(Entry, data, lambda: Entry.model_construct(value=1.0))
    assert not list(work.iterdir())


def test_nothing_is_kept_once_the_models_are_built(work: Path) -> None:
    Built(value=1.0)
    checked_before(Built, {"value": 1}, lambda: Built(value=1.0))
    assert not list(work.iterdir())


def test_the_next_process_builds_no_models_and_has_the_same_scenario(work: Path) -> None:
    program = (
        "import sys; from pathlib import Path; from fmus import places; places.work = lambda: Path(sys.argv[1])\n"
        "from orchestration.session.read import load; from orchestration.scenario.scenario import Scenario\n"
        "scenario = load(sys.argv[2]); print(Scenario.__pydantic_complete__, repr(scenario), scenario.source)"
    )
    command = [sys.executable, "-c", program, str(work), str(places.shared("scenarios") / "mission_day.yaml")]
    first, second = (subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2))
    assert first.startswith("True Scenario(")
    assert second == first.replace("True", "False", 1)


def test_what_is_dumped_is_what_pydantic_dumps() -> None:
    assert SCENARIOS
    for path in SCENARIOS:
        scenario = load(path)
        assert dumped(scenario) == scenario.model_dump(exclude_none=True), path
