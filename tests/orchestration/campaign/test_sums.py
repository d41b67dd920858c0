"""A campaign's folder under flipped bits, copied parts and what is no part at all: each is named, wherever it is
read."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from orchestration.campaign import sums
from orchestration.campaign.case import read_campaign
from orchestration.campaign.flying.rows import Rows
from orchestration.campaign.replay import replay
from orchestration.cli.main import main
from orchestration.errors import InputError

from . import synthetic
from .toy import command, fly, rows


def flipped(path: Path, bit: int) -> None:
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


@pytest.mark.thorough
def test_each_flipped_bit_is_named_with_its_file(tmp_path):
    folder, choose = synthetic.write(tmp_path / "c", 40, analyses=False), random.Random(1)
    files = [folder / sums.MANIFEST, *(folder / "runs").iterdir()]
    sums.check(folder)
    for path in files:
        size = 8 * path.stat().st_size
        for bit in (*(choose.randrange(size) for _ in range(100)), *range(size - 160, size)):
            flipped(path, bit)
            with pytest.raises(InputError, match=f"^{path} is (damaged|no manifest)"):
                sums.check(folder)
            flipped(path, bit)


@pytest.mark.parametrize("name", ["campaign.json", "runs/part-000000.parquet"])
def test_a_changed_file_is_refused_at_resume_page_replay_and_view(toy, name):
    fly(toy, runs=5)
    flipped(Path("out", name), 8 * 200)
    case, out = read_campaign(toy, {"runs": 5}), Path("out")
    for read in (lambda: fly(toy, runs=5), lambda: Rows(out), lambda: replay(case, 1, out / "r", out)):
        with pytest.raises(InputError, match=f"^out/{name} is damaged: "):
            read()
    viewed = CliRunner().invoke(main, ["view", "out"])
    assert (viewed.exit_code, f"out/{name} is damaged" in viewed.stderr) == (2, True)


def test_a_damaged_part_that_is_removed_is_flown_again(toy):
    fly(toy, runs=5)
    whole, part = rows(), Path("out/runs/part-000000.parquet")
    part.unlink()
    with pytest.raises(InputError, match=r"part-000000.parquet is missing; remedy: the same command"):
        Rows(Path("out"))
    fly(toy, runs=5)
    assert rows() == whole


def _copied(runs: Path) -> Path:
    return Path(shutil.copy(runs / "part-000000.parquet", runs / "part-000001.parquet"))


def _odd(runs: Path) -> Path:
    return Path(shutil.copy(runs / "part-000000.parquet", runs / "part-one.parquet"))


def _fifo(runs: Path) -> Path:
    path = runs / "part-000000.parquet"
    path.unlink()
    os.mkfifo(path)
    return path


def _listed(runs: Path, change) -> Path:
    """A part with other rows that the manifest lists all the same."""
    path = runs / "part-000000.parquet"
    table = pq.read_table(path)
    pq.write_table(change(table).cast(table.schema), path)
    record = sums.read(runs.parent)
    record.pop("sha256")
    sums.write(runs.parent, {**record, "files": {path.name: sums.digest(path)}})
    return path


def _null(runs: Path) -> Path:
    return _listed(runs, lambda t: t.set_column(0, "index", pa.array([None, 1, 2, 3, 4], pa.int64())))


def _twice(runs: Path) -> Path:
    return _listed(runs, lambda t: pa.concat_tables([t, t]))


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (_copied, "is no part of this campaign: campaign.json does not list it; remedy: remove it"),
        (_odd, "is no part of this campaign"),
        pytest.param(_fifo, "is no regular file", marks=pytest.mark.skipif(os.name == "nt", reason="no FIFO")),
        (_null, "has a row without the index of its run"),
        (_twice, "holds a run that is there already"),
    ],
)
def test_what_is_no_part_of_the_campaign_is_refused_by_name_and_nothing_is_doubled(toy, spoil, told):
    fly(toy, runs=5)
    path = spoil(Path("out/runs"))
    result = command(toy, "--runs", 5, "--workers", 0, "--out", "out")
    assert (result.exit_code, f"{path} {told}" in result.stderr) == (2, True), result.stderr


@pytest.mark.skipif(os.name == "nt", reason="no FIFO")
def test_a_manifest_that_is_no_file_is_refused_at_once(toy):
    Path("out").mkdir()
    os.mkfifo("out/campaign.json")
    result = command(toy, "--workers", 0, "--out", "out")
    assert (result.exit_code, "out/campaign.json is a device, a pipe or a socket" in result.stderr) == (2, True)


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("announced", {"runs": None, "early": False}),
        ("announced", {"runs": 10**30, "early": False}),
        ("runs", {"wanted": "x", "flown": 5, "failed": 0}),
        ("files", ["part-000000.parquet"]),
        ("withdrawn", None),
        ("unchecked", [["a"]]),
        ("wall_time", float("nan")),
    ],
)
def test_a_manifest_of_another_form_is_refused_though_its_hash_is_right(toy, entry, value):
    fly(toy, runs=5)
    record = sums.read(Path("out"))
    record.pop("sha256")
    sums.write(Path("out"), {**record, entry: value})
    for more in ([], ["--replay", 1]):
        result = command(toy, "--runs", 5, "--workers", 0, "--out", "out", *more)
        told = f"out/campaign.json is no manifest of a campaign: {entry}"
        assert (result.exit_code, told in result.stderr) == (2, True), result.stderr
