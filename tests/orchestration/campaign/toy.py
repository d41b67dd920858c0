"""A campaign of a loop of two small FMUs whose answer is known: the speed after 20 steps of 0.1 s is 0.9^20 of that at
the start.
"""

from __future__ import annotations

from pathlib import Path

import pyarrow.dataset as ds
import pytest
from click.testing import CliRunner

from orchestration.campaign import engine
from orchestration.campaign.case import read_campaign
from orchestration.cli.main import main

ROOT = Path(__file__).parents[3]
SHRINKS = 0.9**20
FILE = """\
name: toy
scenario: loop.yaml
runs: 60
seed: 4
vary:
  motor.speed0: {uniform: [1 rad/s, 2 rad/s]}
metrics:
  - {name: final, signal: motor.speed, statistic: final}
  - {name: slow, signal: motor.speed, settles: {below: 0.5}}
requirements:
  - {name: at rest, metric: final, below: 0.2 rad/s, probability: 0.3}
"""


@pytest.fixture
def toy(loop):
    """The campaign above, beside the loop, in the current folder."""
    path = loop.with_name("toy.yaml")
    path.write_text(FILE, "utf-8")
    return path


def changed(path, *pairs):
    text = path.read_text("utf-8")
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, "utf-8")
    return path


def fly(path, out="out", **overrides):
    return engine.fly(read_campaign(path, overrides), Path(out), workers=0)


def rows(out="out"):
    """All rows, by index, without the time that they took."""
    table = ds.dataset(Path(out) / "runs", format="parquet").to_table().drop_columns(["wall"])
    return table.sort_by("index").to_pylist()


def command(*arguments):
    result = CliRunner().invoke(main, ["campaign", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result
