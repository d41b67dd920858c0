"""Folders of campaigns under what may befall them: flipped bits, parts that are cut, copied or foreign, pipes, links,
odd names, and manifests with other entries whose hash is right.

After each the campaign is gone on with, replayed or viewed. It ends with a message, or with the rows that it had:
nothing is doubled, lost or changed in silence.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import chdir, suppress
from pathlib import Path
from random import Random
from typing import Any

import click
import pyarrow as pa
import pyarrow.parquet as pq
from click.testing import CliRunner

from orchestration.campaign import sums
from orchestration.cli.main import main

from ..orchestration import fmus
from ..orchestration.campaign.toy import FILE, rows
from ..orchestration.wrong_inputs import SCENARIO

RUNS, SECONDS = 12, 60
Attack = Callable[[Random, Path, Path], None]


@click.command("folders")
@click.option("--count", default=300, show_default=True, help="Attacks.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Attack a campaign's folder, and go on with it, replay and view it."""
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="folders-") as name, chdir(name):
        fmus.write_pair(Path())
        Path("loop.yaml").write_text(SCENARIO + "isolation: none\n")
        Path("toy.yaml").write_text(FILE)
        Path("other.yaml").write_text(FILE.replace("seed: 4", "seed: 5"))
        for file, out, runs in (("toy", "good", 5), ("toy", "good", RUNS), ("other", "foreign", RUNS)):
            assert _orchestrate("campaign", f"{file}.yaml", "--runs", runs, "--workers", 0, "--out", out)[0] in (0, 1)
        good = rows("good")
        for number in range(count):
            _trial(Random(f"{seed}.{number}"), good, counts, number)
    for text, n in sorted(counts.items()):
        click.echo(f"{n:6} {text}")
    sys.exit(any(text.startswith("ERROR") for text in counts))


def _trial(random: Random, good: list[dict], counts: Counter[str], number: int) -> None:
    attack = random.choice(ATTACKS)
    shutil.rmtree("hit", ignore_errors=True)
    shutil.copytree("good", "hit")
    attack(random, Path("hit"), Path("foreign"))
    more = random.choice(((), (), ("--replay", random.randrange(RUNS)), ("view",)))
    words = ("view", "hit") if more == ("view",) else ("campaign", "toy.yaml", "--runs", RUNS, "--workers", 0, *more)
    status, said = _orchestrate(*words, *(() if words[0] == "view" else ("--out", "hit")))
    name = attack.__name__.strip("_").replace("_", " ")
    if status in (2, 3, 4) and said.strip():
        counts[f"{name}: told"] += 1
    elif status in (0, 1) and (more or rows("hit") == good):
        counts[f"{name}: without effect"] += 1
    else:
        wrong = "the rows are others" if status in (0, 1) else f"status {status}: {said[-300:]}"
        counts[f"ERROR: {number}: {name}, {words[0]} {more}: {wrong}"] += 1


def _orchestrate(*words: object) -> tuple[int, str]:
    """Status and what was said; 124 after SECONDS."""

    def late(*_: object) -> None:
        raise TimeoutError("it did not end")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    try:
        done = CliRunner().invoke(main, [str(word) for word in words])
    except TimeoutError:
        return 124, "it did not end"
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    if isinstance(done.exception, TimeoutError):
        return 124, "it did not end"
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return 70, repr(done.exception)
    return done.exit_code, done.stderr


def _part(random: Random, folder: Path) -> Path:
    return random.choice(sorted((folder / "runs").glob("*.parquet")))


def _any_file(random: Random, folder: Path) -> Path:
    return random.choice([folder / sums.MANIFEST, _part(random, folder)])


def _a_flipped_bit(random: Random, folder: Path, foreign: Path) -> None:
    path = _any_file(random, folder)
    content = bytearray(path.read_bytes())
    content[random.randrange(len(content))] ^= 1 << random.randrange(8)
    path.write_bytes(content)


def _a_file_cut_or_longer(random: Random, folder: Path, foreign: Path) -> None:
    path = _any_file(random, folder)
    os.truncate(path, random.choice((0, 1, path.stat().st_size // 2, path.stat().st_size + 9, 10**10)))


def _a_part_copied(random: Random, folder: Path, foreign: Path) -> None:
    path = _part(random, folder)
    shutil.copy(path, path.with_name(random.choice(("part-000007.parquet", "copy.parquet", path.name + ".parquet"))))


def _a_foreign_part(random: Random, folder: Path, foreign: Path) -> None:
    shutil.copy(_part(random, foreign), random.choice((_part(random, folder), folder / "runs" / "part-000009.parquet")))


def _a_foreign_manifest(random: Random, folder: Path, foreign: Path) -> None:
    shutil.copy(foreign / sums.MANIFEST, folder)


def _something_else_in_a_files_place(random: Random, folder: Path, foreign: Path) -> None:
    path = random.choice([_any_file(random, folder), folder / "campaign.html", folder / "runs"])
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    random.choice((os.mkfifo, Path.mkdir, lambda p: p.symlink_to("/dev/zero"), lambda p: p.symlink_to(p.name)))(path)


def _an_odd_name(random: Random, folder: Path, foreign: Path) -> None:
    name = random.choice(
        (b"\xff\xfe.parquet", b"a\nb.parquet", b"x" * 240 + b".parquet", b"-.parquet", b"\x1b[31m.parquet")
    )
    Path(os.fsdecode(os.fsencode(folder / "runs") + b"/" + name)).write_bytes(b"PAR1")


def _something_removed(random: Random, folder: Path, foreign: Path) -> None:
    random.choice((_any_file(random, folder), folder / "campaign.html")).unlink()


def _sealed(folder: Path, **changes: Any) -> None:
    record = json.loads((folder / sums.MANIFEST).read_text())
    record.pop("sha256")
    with suppress(ValueError, OverflowError):  # what JSON does not hold
        sums.write(folder, {**record, **changes})


def _a_manifest_with_another_entry(random: Random, folder: Path, foreign: Path) -> None:
    record = json.loads((folder / sums.MANIFEST).read_text())
    entry = random.choice(sorted(set(record) - {"sha256"}))
    value = random.choice((None, 10**30, -1, float("nan"), [], {}, "x", [[1]], {"a": {}}, True))
    if isinstance(record[entry], dict) and record[entry] and random.random() < 0.5:
        value = record[entry] | {random.choice(sorted(record[entry])): value}
    _sealed(folder, **{entry: value})


def _a_part_of_other_rows_that_is_listed(random: Random, folder: Path, foreign: Path) -> None:
    """Indices that are null, doubled or far away, and other columns."""
    path = _part(random, folder)
    table = pq.read_table(path)
    n = len(table)
    changed = random.choice(
        (
            lambda: table.set_column(0, "index", pa.array([None] * n, pa.int64())),
            lambda: table.set_column(0, "index", pa.array([10**12] * n, pa.int64())),
            lambda: table.set_column(0, "index", pa.array([-1] * n, pa.int64())),
            lambda: pa.concat_tables([table, table]),
            lambda: table.drop_columns([table.column_names[-1]]),
            lambda: table.slice(0, 0),
        )
    )()
    pq.write_table(changed, path)
    files = json.loads((folder / sums.MANIFEST).read_text())["files"]
    _sealed(folder, files=files | {path.name: sums.digest(path)})


ATTACKS: tuple[Attack, ...] = (
    _a_flipped_bit,
    _a_file_cut_or_longer,
    _a_part_copied,
    _a_foreign_part,
    _a_foreign_manifest,
    _something_else_in_a_files_place,
    _an_odd_name,
    _something_removed,
    _a_manifest_with_another_entry,
    _a_part_of_other_rows_that_is_listed,
)
