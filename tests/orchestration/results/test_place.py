"""A file that is written anew is there whole, the new one or the earlier one."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import pytest

from fmus import kit
from fmus.native.toolchain import CompilerError
from orchestration.results import whole
from tests.commands import orchestrate

from ...design.test_new_satellite import GIVEN
from ..campaign.toy import toy  # noqa: F401

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
    monkeypatch.setattr(whole, "sync", full)
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
@pytest.mark.thorough
def test_a_full_disk_is_told_of_the_place_that_was_to_be_written(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(whole, "sync", full)
    told = orchestrate(*arguments)
    assert told.exit_code == 4
    assert told.stderr.strip().endswith(message)
    assert not list(Path().glob("k/*"))


@pytest.mark.parametrize("folder", ["k", "a/b/c", "empty"])
def test_a_kit_on_a_full_disk_leaves_nothing_and_is_told_of_its_folder(folder, tmp_path, monkeypatch):
    (tmp_path / "empty").mkdir()

    def half(_interface: object, folder: Path, *_: object) -> None:
        (folder / "Makefile").write_text("all:")
        full(folder)

    monkeypatch.setattr(kit, "write", half)
    told = orchestrate("new", "allocator", str(tmp_path / folder))
    said = told.stderr.strip().splitlines()[-1]  # FMUs that are not built yet are told of first
    assert (told.exit_code, said) == (4, f"{tmp_path / folder} cannot be written: the disk is full")
    assert list(tmp_path.rglob("*")) == [tmp_path / "empty"]


@pytest.mark.parametrize("error", [CompilerError("no compiler"), KeyboardInterrupt()], ids=["compiler", "Ctrl-C"])
@pytest.mark.thorough
def test_a_kit_that_cannot_be_made_leaves_nothing_and_one_that_is_there_is_kept(error, tmp_path, monkeypatch):
    def fail(*_):
        raise error

    monkeypatch.setattr(kit, "write", fail)
    assert orchestrate("new", "allocator", str(tmp_path / "k")).exit_code in (2, 130)
    assert not list(tmp_path.iterdir())
    (tmp_path / "k").mkdir()
    (tmp_path / "k" / "mine.txt").write_text("kept")
    assert orchestrate("new", "allocator", str(tmp_path / "k")).exit_code in (2, 130)
    assert (tmp_path / "k" / "mine.txt").read_text() == "kept"


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="no such device")
def test_a_link_stays_and_a_device_is_no_file_to_be_replaced(tmp_path):
    file, link = tmp_path / "file", tmp_path / "link"
    link.symlink_to(file)
    for text in ("one", "two"):
        whole.put(link, text)
        assert (link.is_symlink(), file.read_text()) == (True, text)
    device = tmp_path / "device"
    device.symlink_to("/dev/null")
    whole.put(device, "lost")
    assert (Path("/dev/null").is_char_device(), device.is_symlink()) == (True, True)


def test_a_folder_of_results_in_which_something_is_a_link_is_refused_and_nothing_is_written_elsewhere(toy, tmp_path):  # noqa: F811
    """Of a run its figures; of a campaign, where it goes on, its runs, its page and what is replayed."""
    mine, run, flown = (tmp_path / name for name in ("mine", "run", "flown"))
    mine.mkdir()
    run.mkdir()
    campaign = ("campaign", str(toy), "--workers", "0", "--runs", "2")
    assert orchestrate(*campaign, "--out", str(flown)).exit_code in (0, 1)
    for words, out, name in (
        ((str(toy.with_name("loop.yaml")),), run, "figures"),
        (campaign, flown, "runs"),
        (campaign, flown, "campaign.html"),
        ((*campaign, "--replay", "0"), flown, "replay-0"),
    ):
        if (out / name).exists():
            (out / name).rename(tmp_path / "away")
        (out / name).symlink_to(mine)
        told = orchestrate(*words, "--out", str(out))
        message = f"{out / name} is a link; expected what lies in the folder itself; remedy: remove it, or another"
        assert (told.exit_code, message in told.stderr) == (2, True)
        (out / name).unlink()
        if (tmp_path / "away").exists():
            (tmp_path / "away").rename(out / name)
    assert not list(mine.iterdir())


@pytest.mark.parametrize("arguments", [("fmus", "--copy", "file"), ("build", "plant", "--out", "file")])
def test_a_place_for_fmus_that_is_a_file_is_refused_before_any_is_built(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("mine")
    for name in ("orchestration.cli.fmus.ensure_all", "orchestration.cli.build.build_fmus"):
        monkeypatch.setattr(name, lambda *_: pytest.fail("it builds"))
    told = orchestrate(*arguments)
    assert (told.exit_code, told.stderr.strip()) == (2, "the results cannot be written to file: file is a file")
    assert Path("file").read_text() == "mine"


def full(path: Path) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_or_a_device_among_results_is_refused_by_name_and_nobody_waits(toy, tmp_path):  # noqa: F811
    """Of a run the manifest and a signal, which new ones replace; of a campaign its page, and what is replayed."""
    run, flown = tmp_path / "run", tmp_path / "flown"
    run.mkdir()
    for name in ("manifest.json", "signals.csv"):
        os.mkfifo(run / name)
    (run / "expectations.json").symlink_to("/dev/zero")
    assert orchestrate(str(toy.with_name("loop.yaml")), "--out", str(run)).exit_code in (0, 1, 2)
    campaign = ("campaign", str(toy), "--workers", "0", "--runs", "2", "--out", str(flown))
    assert orchestrate(*campaign).exit_code in (0, 1)
    (flown / "campaign.html").unlink()
    os.mkfifo(flown / "campaign.html")
    told = orchestrate(*campaign)
    message = f"{flown / 'campaign.html'} is a device, a pipe or a socket; expected a regular file; remedy: remove it"
    assert (told.exit_code, message in told.stderr) == (2, True)
    (flown / "campaign.html").unlink()
    (flown / "replay-0").mkdir()
    os.mkfifo(flown / "replay-0" / "scenario.yaml")
    assert orchestrate(*campaign, "--replay", "0").exit_code in (2, 4)
    (flown / "replay-0" / "scenario.yaml").unlink()
    (flown / "campaign.html").mkdir()
    assert orchestrate(*campaign, "--replay", "0").exit_code in (0, 1)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_file_is_read_whole_unless_it_is_a_pipe_or_too_large_or_nested_too_deep(tmp_path):
    for name, text in (("good", '{"a": [1]}'), ("deep", "[" * 100_000), ("none", "{")):
        (tmp_path / name).write_text(text)
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "large").open("wb") as file:
        file.truncate(whole.BYTES_MAX + 1)
    assert whole.parsed(tmp_path / "good") == {"a": [1]}
    for name, words in (("deep", "nested too deep"), ("none", "Expecting"), ("pipe", "no regular"), ("large", "MB")):
        with pytest.raises(ValueError, match=words):
            whole.parsed(tmp_path / name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_written_where_somebody_reads_it_and_is_an_error_where_nobody_does(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="pipe"):
        whole.put(tmp_path / "pipe", "text")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    whole.put(tmp_path / "pipe", "text")
    assert os.read(reader, 10) == b"text"
    os.close(reader)


@pytest.mark.parametrize("name", ["signals.csv", "expectations.json", "report.html"])
@pytest.mark.parametrize("command", [("view",), ("convert", "--to", "hdf5", "-o", "run.h5"), ("review", "-o", "page")])
def test_a_file_of_a_run_that_was_changed_is_named_wherever_it_is_read(loop, name, command):
    assert orchestrate(str(loop), "--out", "out").exit_code in (0, 1)
    content = bytearray(Path("out", name).read_bytes())
    at = content.rindex(b"0") if name == "signals.csv" else len(content) // 2
    content[at] ^= 1
    Path("out", name).write_bytes(content)
    result = orchestrate(command[0], "out", *command[1:])
    told = f"out/{name} is damaged: its SHA-256 is not the one in manifest.json"
    assert (result.exit_code, told in result.stderr) == (2, True), result.output
