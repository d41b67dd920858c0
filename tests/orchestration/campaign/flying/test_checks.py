"""FMUs whose reset leaves something behind from their sixth flight on: no such row stays, and a replay shows one that
did.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.campaign import engine, sums
from orchestration.campaign.case import read_campaign
from orchestration.campaign.flying import checks, flights
from orchestration.campaign.flying.batches import Flown
from orchestration.campaign.flying.checks import Checks

from ... import fmus
from ..toy import SHRINKS, changed, command, fly, rows
from .test_cluster import scheduler  # noqa: F401  (a fixture)


@pytest.fixture
def drifting(toy):
    """The campaign with a motor that drifts from its sixth flight on; no run is longer than the others."""
    fmus.write(toy.with_name("motor.fmu"), fmus.description("motor"), fmus.library("probe", "-DDRIFT=6"))
    return changed(toy, ("runs: 60", "runs: 30"))


def sound(out="out"):
    return [row["final"] == pytest.approx(SHRINKS * row["motor.speed0"], rel=1e-12) for row in rows(out)]


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5])
def test_what_was_flown_since_the_last_sound_check_is_flown_again_on_fresh_instances(drifting, monkeypatch, share):
    monkeypatch.setattr(checks, "SHARE", share)
    monkeypatch.setattr("orchestration.campaign.flying.dataset._EVERY", 0.0)  # rows are on the disk before they fall
    monkeypatch.setattr("orchestration.campaign.flying.dataset._SHARE", 0.0)
    remarks: list[str] = []
    engine.fly(read_campaign(drifting), Path("out"), workers=0, remark=remarks.append)
    assert sound() == [True] * 30
    (told,) = remarks
    assert "on FMUs that were reset differs from the same run on fresh ones in final" in told
    record = sums.read(Path("out"))
    assert (record["fresh"], record["unchecked"], record["runs"]["flown"]) == (True, [], 30)
    sums.check(Path("out"))
    assert fly(drifting, runs=40).flown == 40
    assert sound() == [True] * 40


def test_flights_that_an_earlier_start_left_unchecked_are_checked_by_the_next(drifting):
    def stop(at):
        if at.flown >= 12:
            raise KeyboardInterrupt

    engine.fly(read_campaign(drifting), Path("out"), workers=0, tell=stop)
    assert not all(sound())
    assert len(sums.read(Path("out"))["unchecked"][0]) >= 12
    fly(drifting)
    assert sound() == [True] * 30


@pytest.mark.isolate
def test_a_cluster_checks_flights_as_one_process_does(drifting, scheduler):  # noqa: F811
    engine.fly(read_campaign(drifting), Path("out"), scheduler=scheduler)
    assert sound() == [True] * 30


def test_a_replay_that_is_not_as_its_row_fails_and_names_the_columns(drifting, monkeypatch):
    monkeypatch.setattr(checks, "SHARE", 0.0)
    monkeypatch.setattr(Checks, "last", lambda self: [])
    fly(drifting)
    assert not sound()[20]
    result = command(drifting, "--out", "out", "--replay", 20)
    assert result.exit_code == 3
    assert "run 20, flown again on fresh instances, is not as in out: final is 0.1" in result.stderr
    assert command(drifting, "--out", "out", "--replay", 0).exit_code in (0, 1)


def test_a_sound_check_covers_the_flights_of_its_pilot_before_it_and_no_others():
    some = Checks(1)
    some.took("a", [0, 1, 5])
    some.took("b", [2, 3, 4])
    some.sound(1)
    assert some.unchecked == [[5], [2, 3, 4]]
    assert some.last() == [5, 4]
    assert some.last() == []
    some.sound(4)
    assert (some.clear(), some.unchecked) == ([5], [])


class _Rows:
    """A dataset of four runs with one metric."""

    def __init__(self):
        self.done, self.failed, self.rows = np.zeros(4, bool), np.zeros(4, bool), {}

    def add(self, rows):
        for row in rows:
            assert row[0] not in self.rows, "each run has one row"
            self.rows[row[0]], self.done[row[0]] = row, True

    def row(self, index):
        return self.rows[index]

    def withdraw(self, indices):
        for index in indices:
            del self.rows[index]
            self.done[index] = False

    def flush(self):
        pass


class _TwoPilots:
    """Both have their batches before the first check shows that resets leave something behind."""

    slots, anew = 2, False

    def fly(self, batches):
        sent = [batches.next(), batches.next()]
        yield Flown(self._rows(sent[0], 0.5), sent[0], "a")
        check = batches.next()
        assert check.check
        yield Flown(self._rows(check, 0.0), check)
        assert self.anew
        yield Flown(self._rows(sent[1], 0.5), sent[1], "b")
        while (batch := batches.next()) is not None:
            yield Flown(self._rows(batch, 0.0), batch)

    def _rows(self, batch, off):
        return [[int(index), index + off] for index in batch.indices]


def test_what_had_been_sent_before_resets_were_seen_to_fail_is_flown_again_on_fresh_instances(monkeypatch):
    monkeypatch.setattr(checks, "SHARE", 1.0)
    monkeypatch.setattr(flights, "foreign", lambda job: True)
    job = SimpleNamespace(design=SimpleNamespace(seed=1, early=False), columns=[("index", ""), ("final", "")])
    data, remarks = _Rows(), []
    flown = flights.Flights(job, data, {}, _TwoPilots, remarks.append)
    flown.up_to(4, None)
    assert data.rows == {index: [index, float(index)] for index in range(4)}
    assert (len(remarks), flown.state) == (1, {"fresh": True, "unchecked": []})
