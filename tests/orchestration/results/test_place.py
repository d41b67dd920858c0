"""A file that is written anew is there whole, the new one or the earlier one."""

from __future__ import annotations

import errno
import json
from pathlib import Path

import pytest

from fmus import kit
from orchestration.results import place
from tests.commands import orchestrate

from ..cli.test_new_satellite import GIVEN

SETS = [part for name, value in GIVEN.items() for part in ("--set", f"{name}={json.dumps(value)}")]


@pytest.mark.parametrize(
    "arguments",
    [("export", "loop.yaml", "--ssp", "a.ssp"), ("export", "loop.yaml", "--container", "a.fmu")],
    ids=["ssp", "container"],
)
def test_an_export_that_fails_leaves_the_earlier_file(loop, arguments, monkeypatch):
    assert orchestrate(*arguments).exit_code == 0
    earlier, there = Path(arguments[-1]).read_bytes(), sorted(Path().iterdir())
    loop.write_text(loop.read_text().replace("duration: 2 s", "duration: 3 s"))
    monkeypatch.setattr(place, "_sync", full)
    told = orchestrate(*arguments)
    assert (told.exit_code, told.stderr.splitlines()[-1]) == (4, f"{arguments[-1]} cannot be written: the disk is full")
    assert Path(arguments[-1]).read_bytes() == earlier
    assert sorted(Path().iterdir()) == there


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("new", "satellite", "k", *SETS), f"{Path('k', 'satellite.yaml')} cannot be written: the disk is full"),
        (("fmus", "--copy", "k"), f"{Path('k', 'plant.fmu')} cannot be written: the disk is full"),
    ],
)
def test_a_full_disk_is_told_of_the_place_that_was_to_be_written(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(place, "_sync", full)
    told = orchestrate(*arguments)
    assert told.exit_code == 4
    assert told.stderr.strip().endswith(message)
    assert not list(Path().glob("k/*"))


def test_a_kit_on_a_full_disk_leaves_nothing_and_is_told_of_its_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(kit, "write", lambda _interface, folder, _language: full(folder))
    told = orchestrate("new", "allocator", str(tmp_path / "k"))
    assert (told.exit_code, told.stderr.strip()) == (
        4,
        f"{tmp_path / 'k'} cannot be written: the disk is full",
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="no such device")
def test_a_link_stays_and_a_device_is_no_file_to_be_replaced(tmp_path):
    file, link = tmp_path / "file", tmp_path / "link"
    link.symlink_to(file)
    for text in ("one", "two"):
        place.put(link, text)
        assert (link.is_symlink(), file.read_text()) == (True, text)
    device = tmp_path / "device"
    device.symlink_to("/dev/null")
    place.put(device, "lost")
    assert (Path("/dev/null").is_char_device(), device.is_symlink()) == (True, True)


def full(path: Path) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")
