"""A file that is written anew is there whole, the new one or the earlier one."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from orchestration.results import place

from ..cli.test_cli import orchestrate


@pytest.mark.parametrize(
    "arguments",
    [("export", "loop.yaml", "--ssp", "a.ssp"), ("export", "loop.yaml", "--container", "a.fmu")],
    ids=["ssp", "container"],
)
def test_an_export_that_fails_leaves_the_earlier_file(loop, arguments, monkeypatch):
    if "--container" in arguments:
        pytest.importorskip("fmu_manipulation_toolbox")
    assert orchestrate(*arguments).exit_code == 0
    earlier, there = Path(arguments[-1]).read_bytes(), sorted(Path().iterdir())
    loop.write_text(loop.read_text().replace("duration: 2 s", "duration: 3 s"))
    monkeypatch.setattr(place, "_sync", full)
    told = orchestrate(*arguments)
    assert (told.exit_code, told.stderr.splitlines()[-1]) == (2, f"{arguments[-1]}: the disk is full")
    assert Path(arguments[-1]).read_bytes() == earlier
    assert sorted(Path().iterdir()) == there


def full(path: Path) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")
