"""What a run leaves behind."""

from __future__ import annotations

import json

import numpy as np
import pytest
from fmpy.util import read_csv

from orchestration import InputError, run

from ..mocks import Mock, model, real
from ..mocks import run as run_mocks


@pytest.fixture
def matrix():
    """A block with a matrix, a vector and a boolean, and values that are hard to print."""
    hard = [0.1, 1 / 3, 1e-300, -0.0, 5e-324, 1.7976931348623157e308, 123456789.123456789, 1e22, 2.0**-1074]

    def evaluate(block):
        for i, element in enumerate(block.model.variables["R"].elements):
            block.values[element] = hard[i] * (1 if block.state % 2 else -1)
        block["on"] = block.state > 2

    def advance(block, time, step):
        block.state += 1

    variables = real("R", "output", shape=(3, 3)), real("w", "output", shape=(2,)), real("on", "output", type="boolean")
    block = Mock("a", model("a", *variables), evaluate, advance, 0)
    return run_mocks([block], {"step": 0.1, "duration": 1})


def test_fmpy_reads_the_csv_and_every_bit_comes_back(matrix, tmp_path):
    matrix.save(tmp_path / "out")
    table = read_csv(tmp_path / "out" / "signals.csv")
    assert table.dtype.names == (
        "time",
        *[f"a.R[{i}][{j}]" for i in (1, 2, 3) for j in (1, 2, 3)],
        "a.w[1]",
        "a.w[2]",
        "a.on",
    )
    np.testing.assert_array_equal(table["time"], matrix.time)
    for i in range(3):
        for j in range(3):
            ours = matrix["a.R"][:, i, j]
            assert table[f"a.R[{i + 1}][{j + 1}]"].tobytes() == ours.tobytes()
    np.testing.assert_array_equal(table["a.on"], matrix["a.on"])


def test_csv_is_written_in_parts_without_a_seam(matrix, tmp_path, monkeypatch):
    matrix.save(tmp_path / "whole")
    monkeypatch.setattr("orchestration.results.formats._ROWS", 4)
    matrix.save(tmp_path / "parts")
    assert (tmp_path / "whole" / "signals.csv").read_bytes() == (tmp_path / "parts" / "signals.csv").read_bytes()


def test_mat_holds_a_struct_for_each_block(matrix, tmp_path):
    from scipy.io import loadmat

    matrix.save(tmp_path, "mat")
    data = loadmat(tmp_path / "signals.mat", simplify_cells=True)
    np.testing.assert_array_equal(data["a"]["R"], matrix["a.R"])
    np.testing.assert_array_equal(data["time"], matrix.time)


def test_parquet_holds_the_same_columns(matrix, tmp_path):
    from pyarrow import parquet

    matrix.save(tmp_path, "parquet")
    table = parquet.read_table(tmp_path / "signals.parquet")
    assert table.column_names == ["time", *matrix.labels]
    np.testing.assert_array_equal(table["a.R[2][3]"].to_numpy(), matrix["a.R"][:, 1, 2])


def test_a_missing_package_is_named_with_its_remedy(matrix, tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match="--format parquet needs the package pyarrow: pip install pyarrow"):
        matrix.save(tmp_path, "parquet")


def test_a_later_run_replaces_the_files_of_an_earlier_one_and_no_others(matrix, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    matrix.save(tmp_path, "csv")
    matrix.save(tmp_path, "mat")
    assert {path.name for path in tmp_path.iterdir()} >= {
        "notes.txt",
        "signals.mat",
        "manifest.json",
        "expectations.json",
    }
    assert not (tmp_path / "signals.csv").exists()


def test_the_manifest_says_what_was_run_and_runs_again(loop):
    first = run(loop, {"motor.speed0": "30 rpm", "motor.mode": "brake"}, out=loop.parent / "out")
    manifest = json.loads((loop.parent / "out" / "manifest.json").read_text())
    assert manifest["outcome"] == "completed"
    assert manifest["steps"] == 20
    assert manifest["order"] == ["motor", "regulator"]
    assert set(manifest["fmus"]["motor"]) == {"file", "sha256", "fmi", "guid", "model", "generation_tool", "isolation"}
    assert manifest["fmus"]["motor"]["guid"] == "probe"
    assert manifest["scenario"]["blocks"]["motor"]["start"]["mode"] == "brake"
    assert manifest["versions"]["fmpy"]
    again = run(manifest["scenario"])
    for name in first:
        np.testing.assert_array_equal(again[name], first[name])
