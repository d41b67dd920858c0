"""Campaigns on a Dask cluster of real processes on the loopback: a scheduler, and a worker with its nanny.

`python -m tests.torture campaigns` has more workers, and kills more of them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from time import monotonic, sleep
from types import SimpleNamespace

import numpy as np
import pytest
from distributed.comm import CommClosedError

from orchestration.campaign import engine
from orchestration.campaign.case import read_campaign
from orchestration.campaign.flying import cluster
from orchestration.campaign.flying.batches import Batch, Flown
from orchestration.campaign.flying.cluster import each
from orchestration.errors import InputError

from ..toy import changed, command, rows

pytestmark = pytest.mark.isolate

ROOT = Path(__file__).parents[4]
KILLER = """\
import os, signal
from pathlib import Path

def deadly(time, signals):
    speed, mark = signals['motor.speed'][0], Path({mark!r})
    if speed > {always}:
        os.kill(os.getpid(), signal.SIGKILL)
    if speed > {once} and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return speed
"""


def started(*arguments: str, until: str, home: Path) -> tuple[subprocess.Popen, str]:
    """A process of Dask's command, and the line of its log that matches."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    log = (home / f"{arguments[0]}.log").open("w+")
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments], stderr=log, stdout=log, cwd=home, env=environment
    )
    end = monotonic() + 60.0
    while monotonic() < end and process.poll() is None:
        if match := re.search(until, (home / f"{arguments[0]}.log").read_text()):
            return process, match[1] if match.groups() else match[0]
        sleep(0.05)
    process.kill()
    pytest.fail((home / f"{arguments[0]}.log").read_text())


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a scheduler that has a worker."""
    home = tmp_path_factory.mktemp("dask")
    local = ("--host", "127.0.0.1", "--no-dashboard")
    first, address = started(
        "scheduler", *local, "--port", "0", until=r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)", home=home
    )
    workers = ("--nworkers", "1", "--nthreads", "1", "--local-directory", str(home))
    second, _ = started("worker", address, *local, *workers, until="Registered to", home=home)
    yield address
    for process in (second, first):
        process.terminate()
        process.wait(20)


def test_calls_by_a_clusters_workers_come_back_with_the_places_of_their_items(scheduler):
    assert dict(each(abs, [-3, 1, -2], scheduler)) == {0: 3, 1: 1, 2: 2}
    with pytest.raises(TypeError):
        dict(each(abs, [1, "one"], scheduler))


def fly(path: Path, out: str, scheduler: str | None = None, **overrides: object) -> engine.Finished:
    return engine.fly(read_campaign(path, overrides), Path(out), workers=0, scheduler=scheduler)


@pytest.mark.parametrize("address", ["bogus", "tcp://bogus", "http://host:80", "tcp://host:port", "tcp://host:99999"])
def test_what_is_no_address_of_a_scheduler_is_refused_at_once(toy, address, monkeypatch):
    monkeypatch.setattr(cluster, "Client", lambda *a, **more: pytest.fail("it was looked for"))
    with pytest.raises(InputError, match=f"^--scheduler {address}: expected tcp://HOST:PORT$"):
        fly(toy, "out", address)


@pytest.mark.thorough
def test_a_cluster_gives_the_bits_of_one_process_also_where_a_worker_dies(toy, scheduler, tmp_path):
    code = KILLER.format(mark=str(tmp_path / "killed"), always=9.0, once=1.8)
    Path("deadly.py").write_text(code, "utf-8")
    more = "  - {name: start, python: 'deadly:deadly', signals: [motor.speed]}\n"
    more += "  - {name: count, signal: motor.steps, statistic: final}"
    changed(toy, ("metrics:", f"metrics:\n{more}"))
    finished = fly(toy, "many", scheduler)
    assert (tmp_path / "killed").exists()
    assert (finished.flown, finished.failed) == (60, 0)
    assert {row["count"] for row in rows("many")} == {20.0}, "the reset that resets nothing is seen in a worker, too"
    assert fly(toy, "one").flown == 60
    assert rows("many") == rows("one")


class Dying:
    """A `LocalCluster` whose workers die while they start, so many times."""

    def __init__(self, times: int) -> None:
        self.times, self.made = times, 0

    def __call__(self, **options: object) -> nullcontext[str]:
        self.made += 1
        if self.made <= self.times:
            raise RuntimeError("Nanny failed to start.")
        return nullcontext("started")


@pytest.mark.parametrize("times", [1, 2, 3])
def test_workers_that_die_while_they_start_are_started_again_and_at_last_are_lost(toy, times, monkeypatch):
    dying = Dying(times)
    monkeypatch.setattr(cluster, "LocalCluster", dying)
    if times < 3:
        with cluster.local(1) as started_at_last:
            assert (started_at_last, dying.made) == ("started", times + 1)
        return
    result = command(toy, "--workers", 1, "--out", "out")
    told = "the workers are lost: Nanny failed to start.; the same command goes on from what is written"
    assert (result.exit_code, told in result.stderr) == (3, True)


def test_a_connection_that_breaks_off_while_a_worker_takes_in_the_campaign_is_tried_again(toy, scheduler, monkeypatch):
    register, tries = cluster.Client.register_plugin, []

    def broken(self, *arguments, **more):
        tries.append(1)
        if len(tries) == 1:
            raise CommClosedError("broke off")
        return register(self, *arguments, **more)

    monkeypatch.setattr(cluster.Client, "register_plugin", broken)
    assert fly(toy, "out", scheduler, runs=5).flown == 5
    assert len(tries) == 2


def test_workers_import_nothing_from_the_working_folder_and_leave_the_environment_as_it_was(tmp_path):
    (tmp_path / "signal.py").write_text("open('imported', 'w')\n")
    (tmp_path / "locale.py").write_text("open('imported', 'w')\n")
    program = (
        "import os\nfrom orchestration.campaign.flying.cluster import local\n"
        "if __name__ == '__main__':\n before = dict(os.environ)\n with local(1): pass\n assert os.environ == before"
    )
    script = tmp_path / "elsewhere" / "start.py"
    script.parent.mkdir()
    script.write_text(program)
    ended = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True
    )
    assert ended.returncode == 0, ended.stderr
    assert not (tmp_path / "imported").exists()


def test_runs_of_a_batch_whose_worker_dies_keep_their_own_points_of_a_hypercube(monkeypatch):
    """Flown run by run; the second dies each time, and its row has its point, too."""
    indices, points = np.array([4, 7, 9]), np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]])
    crew = cluster.Cluster(None, "", None)
    monkeypatch.setattr(crew, "_sent", lambda batch: batch)
    monkeypatch.setattr(cluster, "lost", lambda job, index, point, reason: (index, *point))

    def flown(future, batch):
        dies = len(batch.indices) > 1 or batch.indices[0] == 7
        rows = [(int(i), *point) for i, point in zip(batch.indices, batch.points, strict=True)]
        return ValueError("it died") if dies else Flown(rows, batch)

    monkeypatch.setattr(crew, "_flown", flown)
    rows = [row for part in crew._alone(Batch(indices, points)) for row in part.rows]
    assert rows == [(4, 0.1, 0.2), (7, 0.3, 0.4), (9, 0.5, 0.6)]


def test_a_check_whose_worker_dies_shows_nothing_and_adds_no_row(monkeypatch):
    crew = cluster.Cluster(None, "", None)
    monkeypatch.setattr(crew, "_sent", lambda batch: batch)
    monkeypatch.setattr(crew, "_flown", lambda future, batch: ValueError("it died"))
    assert list(crew._alone(Batch(np.array([4, 7]), None, check=True))) == []


@pytest.mark.parametrize(
    ("port", "told"),
    [(0, "expected tcp"), (65536, "expected tcp"), (1, "cannot be reached"), (65535, "cannot be reached")],
)
def test_the_port_of_a_scheduler_is_one_of_65535(monkeypatch, port, told):
    monkeypatch.setattr(cluster, "_PATIENCE", 0.3)
    with pytest.raises(InputError, match=told), cluster._client(None, f"tcp://127.0.0.1:{port}", False):
        pass


def test_a_cluster_flies_one_run_on_each_thread_and_one_at_a_time_while_it_has_none():
    for threads, slots in (({}, 1), ({"a": 2, "b": 1}, 3)):
        flying = cluster.Cluster(SimpleNamespace(nthreads=lambda threads=threads: threads), "key", None)
        assert flying.slots == slots
        assert flying.anew is False
