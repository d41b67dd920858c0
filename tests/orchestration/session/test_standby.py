"""Runs whose instances stand by for the next run of the same scenario."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from orchestration import BlockError, run
from orchestration.instances.slave import Slave

SCENARIOS = Path(__file__).parents[3] / "scenarios"
MINIMAL, PAPER = SCENARIOS / "minimal.yaml", SCENARIOS / "paper_no_singularity.yaml"


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of all that are instantiated from now on."""
    monkeypatch.setattr("orchestration.fmu.archive._MOMENT", 0)  # FMUs that were built a moment ago may be kept, too
    names: list[str] = []
    original = Slave.__init__

    def init(self: Slave, name: str, *arguments: object, **options: object) -> None:
        names.append(name)
        original(self, name, *arguments, **options)

    monkeypatch.setattr(Slave, "__init__", init)
    return names


def test_the_next_run_of_a_scenario_has_the_instances_of_the_last_and_gives_the_same_bits(made: list[str]) -> None:
    first = run(PAPER, duration="20 s")
    made.clear()
    second = run(PAPER, duration="20 s")
    assert made == []
    other = run(MINIMAL, duration="20 s")
    assert made
    third, python = run(PAPER, duration="20 s"), run(PAPER, duration="20 s", compiled=False)
    assert first.sha256 == second.sha256 == third.sha256 == python.sha256 != other.sha256


def test_a_run_after_one_that_failed_has_instances_of_its_own(made: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    first = run(MINIMAL, duration="20 s")
    with monkeypatch.context() as patch:
        patch.setattr("orchestration.master.master.Master._leave", _fail)
        with pytest.raises(BlockError):
            run(MINIMAL, duration="20 s")
    made.clear()
    assert run(MINIMAL, duration="20 s").sha256 == first.sha256
    assert made


def _fail(*arguments: object) -> None:
    raise BlockError("plant", "fmi2GetReal", "gave status error")


def test_runs_of_one_scenario_in_several_threads_give_what_they_give_alone() -> None:
    alone = run(MINIMAL, duration="20 s")
    results = []
    threads = [
        threading.Thread(target=lambda: results.extend(run(MINIMAL, duration="20 s") for _ in range(3)))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 9
    assert all(np.array_equal(result.samples, alone.samples) for result in results)


def test_a_run_of_what_is_kept_imports_neither_fmpy_nor_lxml_and_ends_well() -> None:
    script = (
        "import sys, orchestration as o; [o.run(sys.argv[1], duration=d) for d in (0.1, 0.1, 0.2)]; "
        "print({'fmpy', 'lxml'} & {*sys.modules})"
    )
    command = [sys.executable, "-c", script, str(MINIMAL)]
    subprocess.run(command, capture_output=True, check=True)  # keeps what the next process reads
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "set()\n", "")
