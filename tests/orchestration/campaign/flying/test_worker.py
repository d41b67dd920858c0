"""What a worker of a cluster does with the jobs that it is given, in this process and without a cluster."""

from __future__ import annotations

import gc
import signal
import threading
import weakref
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.campaign.case import read_campaign
from orchestration.campaign.flying import worker
from orchestration.campaign.flying.batches import Batch

BATCH = Batch(np.arange(2), None)


@pytest.fixture(autouse=True)
def signals():
    """A worker ignores Ctrl-C; the tests that follow in this process do not."""
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def place(tmp_path: Path) -> SimpleNamespace:
    """What `setup` looks at of a worker."""
    folder = tmp_path / "worker"
    folder.mkdir()
    return SimpleNamespace(local_directory=str(folder))


def given(path: Path, key: str, place: SimpleNamespace) -> worker.Setup:
    setup = worker.Setup(key, read_campaign(path).job)
    setup.setup(place)
    return setup


def states(key: str) -> list[object]:
    return [row[1] for row in worker.fly(key, BATCH, False)[0]]


def test_a_campaign_that_ends_leaves_the_fmus_of_another(toy, place):
    one, two = given(toy, "one", place), given(toy, "two", place)
    assert states("one") == states("two") == ["ok", "ok"]
    one.teardown(place)
    assert states("two") == ["ok", "ok"]
    two.teardown(place)
    with pytest.raises(RuntimeError, match="not been given the campaign"):
        worker.fly("two", BATCH, False)


def test_a_campaign_that_ends_while_a_batch_flies_lets_it_finish(toy, place, monkeypatch):
    setup, flying, ended, rows = given(toy, "slow", place), threading.Event(), threading.Event(), []

    def slow(pilot, batch, fly=worker.fly_batch):
        flying.set()
        assert ended.wait(20.0)
        return fly(pilot, batch)

    monkeypatch.setattr(worker, "fly_batch", slow)
    thread = threading.Thread(target=lambda: rows.extend(worker.fly("slow", BATCH, False)[0]))
    thread.start()
    assert flying.wait(20.0)
    setup.teardown(place)
    ended.set()
    thread.join()
    assert [row[1] for row in rows] == ["ok", "ok"]
    assert not list(Path(place.local_directory).iterdir())


def test_nothing_of_a_campaign_stays_in_its_worker(toy, place, monkeypatch):
    made = []

    class Pilot(worker.Pilot):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            made.append(weakref.ref(self))

    monkeypatch.setattr(worker, "Pilot", Pilot)
    setup = given(toy, "gone", place)
    states("gone")
    assert list(Path(place.local_directory).iterdir())
    setup.teardown(place)
    gc.collect()
    assert [pilot() for pilot in made] == [None]
    assert not list(Path(place.local_directory).iterdir())
