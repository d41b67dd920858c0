"""A signal that ends a run ends also what the run was made for: no part of a run is taken for a whole one."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest

from orchestration.acceptance.playback import play_opened
from orchestration.acceptance.vector import record
from orchestration.cli import live
from orchestration.export.system import flat
from orchestration.interrupt import Stopped
from orchestration.master.master import Master
from orchestration.session.open import open_scenario
from orchestration.session.read import load
from orchestration.session.run import whole
from tests.commands import orchestrate

from ...design.test_new_satellite import made
from ..campaign.toy import changed, command, fly, toy  # noqa: F401  (a fixture)
from ..swapped import swapped

MINIMAL = Path(__file__).parents[3] / "scenarios" / "minimal.yaml"


@pytest.fixture
def stop(monkeypatch):
    """Makes each run that follows one that a signal ended at its last step."""

    def begin():
        run = Master.run

        def stopped(self, *arguments):
            recording = run(self, *arguments)
            recording.interrupted = signal.SIGTERM
            return recording

        monkeypatch.setattr(Master, "run", stopped)

    return begin


def test_a_run_that_is_wanted_whole_and_was_stopped_raises(loop, stop):
    assert whole(load(loop)).interrupted == 0
    stop()
    with pytest.raises(Stopped) as info:
        whole(load(loop))
    assert info.value.number == signal.SIGTERM


def test_no_test_vector_and_no_system_is_made_of_a_stopped_run(loop, tmp_path, stop):
    stop()
    with pytest.raises(Stopped):
        record(MINIMAL, "plant", tmp_path / "vector")
    assert not (tmp_path / "vector").exists()
    with pytest.raises(Stopped):
        flat(load(loop))


def test_a_playback_of_a_part_is_not_taken_for_a_whole_one(loop, stop):
    opened = open_scenario(load(loop))
    name = next(iter(opened.fmus))
    assert len(play_opened(opened, name, {}, opened.plan.clock)[0]) > 1
    stop()
    with pytest.raises(Stopped):
        play_opened(opened, name, {}, opened.plan.clock)


def test_a_live_page_is_not_written_from_a_stopped_run(loop, stop, monkeypatch):
    monkeypatch.setattr(live, "prepare", lambda chosen: type("Live", (), {"opened": open_scenario(chosen)}))
    stop()
    assert orchestrate("live", loop, "--out", "page.html").exit_code == 128 + signal.SIGTERM
    assert not Path("page.html").exists()


def test_a_comparison_of_a_stopped_run_has_no_verdict(tmp_path, monkeypatch, stop):
    swapped(tmp_path, monkeypatch)
    stop()
    result = orchestrate(
        "compare", "loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out"
    )
    assert result.exit_code == 128 + signal.SIGTERM
    assert not Path("out/comparison.json").exists()


def test_a_new_satellite_whose_first_sample_was_stopped_is_not_written(tmp_path, stop):
    stop()
    assert made(tmp_path / "cube").exit_code == 128 + signal.SIGTERM
    assert not (tmp_path / "cube").exists()


def test_a_kept_run_that_was_stopped_is_flown_again(toy, monkeypatch, stop):  # noqa: F811
    fly(toy, runs=3)
    changed(toy, ("runs: 60", "runs: 3\nkeep: {runs: [0]}"))
    stop()
    finished = fly(toy)
    assert (finished.state, finished.interrupted) == ("interrupted", signal.SIGTERM)
    assert not Path("out/kept/0/manifest.json").exists()
    monkeypatch.undo()
    monkeypatch.chdir(toy.parent)
    assert fly(toy).state == "completed"
    assert json.loads(Path("out/kept/0/manifest.json").read_text("utf-8"))["outcome"] == "completed"


def test_a_replayed_run_that_was_stopped_has_no_metrics(toy, stop):  # noqa: F811
    stop()
    result = command(toy, "--out", "out", "--replay", 1)
    assert result.exit_code == 128 + signal.SIGTERM
    assert "metric" not in result.stdout
