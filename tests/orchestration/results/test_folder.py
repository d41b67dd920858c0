"""The folder of a run: earlier results stand until new ones do, one run at a time writes, names come back from every
format.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import random
import re
import signal
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from orchestration import InputError, run
from orchestration.errors import ResultsError
from orchestration.fmu.model import Element
from orchestration.fmu.names import escaped, field, unescaped
from orchestration.interrupt import Stopped, stoppable
from orchestration.results import formats, place
from tests.commands import orchestrate

from ..mocks import Mock, model, real
from ..mocks import run as run_mocks
from .test_endings import POSIX, contents

WHOLE = ["expectations.json", "manifest.json", "report.html", "signals.csv"]


def result(value=0.0, name="x", **scenario):
    """A run that records a.x, which is `value` throughout."""

    def evaluate(block):
        block[name] = value

    block = Mock("a", model("a", real(name, "output")), evaluate)
    return run_mocks([block], {"step": 0.1, "duration": 1, **scenario})


def assert_whole(folder, value):
    """The folder holds one run's files, the manifest has their hashes, and the signal has this value."""
    files = json.loads(Path(folder, "manifest.json").read_text())["files"]
    assert sorted([*files, "manifest.json"]) == contents(folder)
    for name, digest in files.items():
        assert hashlib.sha256(Path(folder, name).read_bytes()).hexdigest() == digest, name
    assert Path(folder, "signals.csv").read_text().splitlines()[-1] == f"1.0,{value}"


# ---------------------------------------------------------------- earlier results stand until the new ones do


@pytest.mark.parametrize("number", [0, 4], ids=["errno unknown", "full"])
@pytest.mark.parametrize("function", ["write", "digests", "_finish"])
def test_earlier_results_stand_where_new_ones_cannot_be_written(tmp_path, monkeypatch, number, function):
    result(1.0).save(tmp_path / "out")

    def full(*arguments):
        raise OSError(number, "No space left on device", str(tmp_path / "out" / ".orchestrate-part-1" / "signals.csv"))

    whole = getattr(formats if function == "write" else place, function)
    monkeypatch.setattr(formats if function == "write" else place, function, full)
    with pytest.raises(ResultsError, match=re.escape(f"{tmp_path / 'out' / 'signals.csv'}: No space")) as info:
        result(2.0).save(tmp_path / "out")
    assert len(info.value.result.time) == 11, "what was computed is not lost"
    monkeypatch.setattr(formats if function == "write" else place, function, whole)
    if function == "_finish":
        with place.reserved(tmp_path / "out"):  # all was ready: the next run completes it
            assert_whole(tmp_path / "out", 2.0)
    else:
        assert_whole(tmp_path / "out", 1.0)


def test_a_full_disk_is_told_by_the_command_and_loses_nothing(loop, monkeypatch):
    orchestrate(loop.name, "--quiet")
    before = Path("results/loop/signals.csv").read_bytes()

    def full(result, path):
        path.write_bytes(b"time,mot")
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setitem(formats.FORMATS, "csv", (full, ""))
    told = orchestrate(loop.name, "--set", "motor.speed0=3")
    assert told.exit_code == 4
    assert "loop: ran 2 s" in told.stdout, "the summary comes before the folder is written"
    assert f"the results cannot be written: {Path('results/loop/signals.csv')}: the disk is full" in told.stderr
    assert contents("results/loop") == WHOLE
    assert Path("results/loop/signals.csv").read_bytes() == before


def test_text_that_is_no_unicode_is_refused_in_a_file_and_written_where_it_comes_from_a_program(loop, tmp_path):
    loop.write_text('description: "\\uD800"\n' + loop.read_text())
    told = orchestrate(loop.name)
    assert told.exit_code == 2
    assert told.stderr == "loop.yaml:1: description: expected text, found half a character (a surrogate) in '\\ud800'\n"
    odd = result(3.0)
    odd.manifest["scenario"] = {"description": "\ud800"}
    assert_whole(odd.save(tmp_path / "out"), 3.0)
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["scenario"]["description"] == "\ud800"


def test_an_error_that_is_none_of_the_disk_leaves_the_earlier_results(tmp_path, monkeypatch):
    result(1.0).save(tmp_path / "out")
    monkeypatch.setattr(formats, "write", lambda *a: b"\xff".decode("utf-8"))
    with pytest.raises(ResultsError, match="cannot be written: .*can't decode"):
        result(2.0).save(tmp_path / "out")
    assert_whole(tmp_path / "out", 1.0)


@POSIX
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("function", ["digests", "_finish"])
def test_a_signal_while_results_are_written_waits_until_they_stand(tmp_path, monkeypatch, name, function):
    result(1.0).save(tmp_path / "out")
    number, original = getattr(signal, name), getattr(place, function)

    def signalled(folder):
        if function == "digests" or (folder / ".orchestrate-ready").exists():
            os.kill(os.getpid(), number)
        return original(folder)

    monkeypatch.setattr(place, function, signalled)
    with pytest.raises(KeyboardInterrupt) as info, stoppable():
        result(2.0).save(tmp_path / "out")
    assert name == "SIGINT" or (isinstance(info.value, Stopped) and info.value.number == number)
    assert_whole(tmp_path / "out", 2.0)


@POSIX
def test_a_second_signal_ends_the_writing_and_the_earlier_results_stand(tmp_path, monkeypatch):
    result(1.0).save(tmp_path / "out")

    def signalled(result, folder, format):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(formats, "write", signalled)
    with pytest.raises(KeyboardInterrupt):
        result(2.0).save(tmp_path / "out")
    assert_whole(tmp_path / "out", 1.0)


@POSIX
def test_a_signal_while_the_temporary_folder_is_removed_leaves_nothing_of_it(loop, tmp_path, monkeypatch):
    temporary, original = tmp_path / "temporary", os.rmdir
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))

    def signalled(*arguments, **options):
        monkeypatch.setattr(os, "rmdir", original)
        os.kill(os.getpid(), signal.SIGINT)
        return original(*arguments, **options)

    monkeypatch.setattr(os, "rmdir", signalled)
    with pytest.raises(KeyboardInterrupt):
        run(loop)
    assert os.rmdir is original, "it was called"
    assert contents(temporary) == []


def test_what_a_killed_run_left_is_removed_or_completed_by_the_next(tmp_path):
    out = result(1.0).save(tmp_path / "out")
    ready = result(2.0).save(tmp_path / "other")
    (out / ".orchestrate-part-x").mkdir()
    (out / ".orchestrate-part-x" / "signals.csv").write_text("time")
    (out / "signals.mat").write_text("of a run before")
    os.replace(ready / "signals.csv", out / "signals.csv")  # it was killed after the first file
    ready.rename(out / ".orchestrate-ready")
    with place.reserved(out):
        assert_whole(out, 2.0)


@pytest.mark.parametrize("manifest", ["{", "[]", "{}", '{"files": 1}', '{"files": null}'])
def test_what_is_ready_with_a_damaged_manifest_is_removed(tmp_path, manifest):
    out = result(1.0).save(tmp_path / "out")
    ready = result(2.0).save(tmp_path / "other")
    ready.rename(out / ".orchestrate-ready")
    (out / ".orchestrate-ready" / "manifest.json").write_text(manifest)
    with place.reserved(out):
        assert_whole(out, 1.0)


def test_a_later_run_replaces_the_files_of_an_earlier_one_and_no_others(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    result().save(tmp_path, "csv")
    result().save(tmp_path, "mat")
    assert contents(tmp_path) == ["expectations.json", "manifest.json", "notes.txt", "report.html", "signals.mat"]


# ---------------------------------------------------------------- two runs into one folder


def _write_often(folder, value):
    for _ in range(30):
        with suppress(InputError):  # another run writes there
            result(value).save(folder)


@POSIX
def test_runs_that_write_into_one_folder_do_not_tear_it(tmp_path):
    context = multiprocessing.get_context("fork")
    processes = [context.Process(target=_write_often, args=(tmp_path / "out", float(i))) for i in range(4)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(120)
        assert process.exitcode == 0
    last = float((tmp_path / "out" / "signals.csv").read_text().split(",")[-1])
    assert_whole(tmp_path / "out", last)


@POSIX
def test_a_second_run_into_a_folder_is_refused_before_it_runs(loop, monkeypatch):
    begun, end = multiprocessing.Event(), multiprocessing.Event()

    def keep():
        with place.reserved(Path("results/loop")):
            begun.set()
            end.wait(60)

    other = multiprocessing.get_context("fork").Process(target=keep)
    other.start()
    assert begun.wait(30)
    with monkeypatch.context() as patch:
        patch.setattr("orchestration.session.run.execute", lambda *a: pytest.fail("it was run"))
        told = orchestrate(loop.name)
        with pytest.raises(InputError, match="another run writes there"):
            run(loop, out="results/loop")
    end.set()
    other.join(30)
    assert told.exit_code == 2
    assert told.stderr == (
        f"the results cannot be written to {Path('results/loop')}: another run writes there; "
        "remedy: wait for it, or another folder (--out)\n"
    )
    assert orchestrate(loop.name, "--quiet").exit_code == 0


def test_links_in_the_folder_are_replaced_and_not_followed(tmp_path):
    out, mine = tmp_path / "out", tmp_path / "mine"
    out.mkdir()
    mine.write_text("mine")
    for name in (*WHOLE, "signals.csv.part", ".orchestrate-ready", ".orchestrate-part-y", ".orchestrate.lock"):
        (out / name).symlink_to(mine)
    result(1.0).save(out)
    assert mine.read_text() == "mine"
    assert not any((out / name).is_symlink() for name in WHOLE)


# ---------------------------------------------------------------- names


def test_every_name_comes_back_from_what_a_format_makes_of_it():
    pieces = ["a", "_", "x", "0078", "_x002C", "x002C", ",", " ", "-", ">", "é", ".", "[1]", '"', "#", "1"]
    choose = random.Random(7)
    for _ in range(20_000):
        name = "".join(choose.choices(pieces, k=choose.randint(1, 7)))
        assert unescaped(escaped(name)) == unescaped(field(name)) == name
        assert not set(escaped(name)) & set(' ,"#;')
        assert re.fullmatch("[A-Za-z][A-Za-z0-9_]*", field(name))
    for plain in ("R_NB[1][2]", "omega_B", "der(x)", "a.b_c"):
        assert escaped(plain) == plain


def odd_names():
    """A run that records five variables whose names are nearly the same, or hold what CSV cannot."""
    names = ["a_b", "a.b", "a-b", "p, q", "time"]

    def evaluate(block):
        for number, name in enumerate(names):
            block[name] = float(number)

    block = Mock("time", model("time", *(real(name, "output") for name in names)), evaluate)
    return names, run_mocks([block], {"step": 0.1, "duration": 1, "record": {"signals": ["time.*"]}})


@pytest.mark.parametrize("format", ["csv", "mat", "parquet"])
def test_no_two_names_become_one_and_none_shifts_a_column(tmp_path, format):
    names, odd = odd_names()
    odd.save(tmp_path, format)
    if format == "csv":
        from fmpy.util import read_csv

        table = read_csv(tmp_path / "signals.csv")
        values = {name: table[f"time.{escaped(name)}"][0] for name in names}
    elif format == "parquet":
        from pyarrow.parquet import read_table

        table = read_table(tmp_path / "signals.parquet")
        values = {name: table[f"time.{escaped(name)}"][0].as_py() for name in names}
    else:
        from scipy.io import loadmat

        data = loadmat(tmp_path / "signals.mat", simplify_cells=True)
        assert data["time"].shape == (11,), "a block called time does not take its place"
        values = {name: data[field("time", ["time"])][field(name)][0] for name in names}
    assert values == {name: float(number) for number, name in enumerate(names)}


def test_a_name_with_a_comma_and_a_space_can_be_named_in_a_scenario_and_in_a_result():
    _, odd = odd_names()
    np.testing.assert_array_equal(odd["time.p_x002C__x0020_q"], np.full(11, 3.0))
    assert all(len(odd[name]) == 11 for name in odd), "its own names are its keys"


def test_an_element_of_an_incomplete_vector_can_be_named_by_its_index():
    block = Mock("a", model("a", real("v[2,3]", "output")), lambda block: None)
    block.values[Element("v[2,3]", 0)] = 5.0
    ran = run_mocks([block], {"step": 0.1, "duration": 1, "record": {"signals": ["a.v[2,3]"]}})
    assert ran["a.v[2,3]"][0] == ran["a.v[2][3]"][0] == 5.0


def test_a_name_too_long_for_matlab_is_refused_before_the_run(loop, monkeypatch, tmp_path):
    long = result(name="n" * 64)
    long.save(tmp_path / "out")
    with pytest.raises(
        InputError, match=r"--format mat: the name n+ of a\.n+ has 64 characters; MATLAB reads at most 63"
    ):
        long.save(tmp_path / "out", "mat")
    assert contents(tmp_path / "out") == WHOLE
    monkeypatch.setattr(formats, "_FIELD_MAX", 4)
    monkeypatch.setattr("orchestration.master.master.Master.run", lambda *a: pytest.fail("it was run"))
    told = orchestrate(loop.name, "--format", "mat")
    assert told.exit_code == 2
    assert "remedy: --format csv or parquet" in told.stderr
