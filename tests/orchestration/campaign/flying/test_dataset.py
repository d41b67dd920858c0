"""The rows of a campaign as they come, in any order, and are taken back."""

from __future__ import annotations

from types import SimpleNamespace

import pyarrow.parquet as pq
import pytest

from orchestration.campaign.flying.dataset import Dataset
from orchestration.campaign.flying.job import FAILED, OK, differing
from orchestration.errors import InputError

KINDS = [("index", "int64"), ("status", "string"), ("reason", "string"), ("met: a", "bool")]


@pytest.fixture
def data(tmp_path):
    """Six runs with one requirement, of which nothing has been flown; each part is written when it is asked for."""
    job = SimpleNamespace(columns=KINDS, requirements=[SimpleNamespace(name="a")])
    return Dataset(tmp_path, job, 6, listed=lambda: None)


def test_the_reason_is_that_of_the_first_run_that_failed_whatever_fails_later(data):
    data.add([[0, OK, "", True]])
    data.add([[2, FAILED, "no room", False]])
    data.add([[1, FAILED, "too fast", False]])
    assert (data.reason, data.done.tolist(), data.failed.tolist()) == (
        "no room",
        [True, True, True, False, False, False],
        [False, True, True, False, False, False],
    )


@pytest.mark.parametrize("flushed", [False, True])
def test_a_row_that_is_taken_back_leaves_nothing_and_another_takes_its_place(data, flushed):
    data.add([[0, FAILED, "a", False], [1, OK, "", True], [2, FAILED, "b", False]])
    if flushed:
        data.flush()
    data.withdraw([0, 1])
    assert (data.done.sum(), data.failed.sum(), data.met["a"].sum()) == (1, 1, 0)
    data.flush()
    assert data.row(2) == [2, FAILED, "b", False]
    data.add([[0, OK, "", True], [1, OK, "", False]])
    data.flush()
    assert [data.row(i) for i in range(3)] == [[0, OK, "", True], [1, OK, "", False], [2, FAILED, "b", False]]
    assert (data.done.sum(), data.failed.sum(), data.met["a"].sum()) == (3, 1, 1)
    assert len(data.files) == len(list(data.folder.glob("*.parquet")))


def test_parts_are_written_every_two_seconds_at_first_and_each_fiftieth_of_a_long_campaign(tmp_path, monkeypatch):
    """So that a kill costs little, and a campaign of hours has no thousands of files."""
    begun = 1e6
    clock = iter([begun])
    monkeypatch.setattr("orchestration.campaign.flying.dataset.monotonic", lambda: next(clock))
    job = SimpleNamespace(columns=KINDS, requirements=[SimpleNamespace(name="a")])
    data = Dataset(tmp_path, job, 20, listed=lambda: None)
    written = []
    for index, at in enumerate((1.5, 2.5, 4.0, 5.0, 1000.0, 1010.0, 1021.0)):
        clock = iter([begun + at] * 2)  # of the row, and of a part that is written
        data.add([[index, OK, "", True]])
        written.append(len(list(data.folder.glob("*.parquet"))))
    assert written == [0, 1, 1, 2, 3, 3, 4]


def test_rows_in_a_part_are_taken_back_beside_one_that_waits(data):
    data.add([[0, OK, "", True], [1, OK, "", True]])
    data.flush()
    data.add([[2, OK, "", True]])
    data.withdraw([0, 2])
    data.flush()
    there = [index for path in data.folder.glob("*.parquet") for index in pq.read_table(path)["index"].to_pylist()]
    assert there == [1]


def test_a_run_beyond_those_that_are_wanted_is_refused(data):
    data.add([[5, OK, "", True]])
    data.flush()
    job, earlier = SimpleNamespace(columns=KINDS, requirements=[SimpleNamespace(name="a")]), {"files": data.files}
    assert Dataset(data.folder.parent, job, 6, earlier).done.tolist() == [False] * 5 + [True]
    with pytest.raises(InputError, match="holds 6 runs, more than the 5 that are wanted"):
        Dataset(data.folder.parent, job, 5, earlier)


def test_two_rows_of_a_run_differ_where_a_value_does_and_no_value_is_as_none_there():
    columns, nan = ["index", "a", "b", "wall", "reason"], float("nan")
    for other, told in (((2.0, nan), []), ((2.0, 1.0), ["b"]), ((nan, nan), ["a"]), ((3.0, 1.0), ["a", "b"])):
        assert differing(columns, [7, 2.0, nan, 0.1, "x"], [7, *other, 0.2, "y"]) == told
