"""A recorded run is played again: by the command, by the program alone, on another FMU, and after a crash.

Shows RC-1.
"""

from __future__ import annotations

import os
import re
import shutil
import struct
import subprocess
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from orchestration.cli.main import main
from orchestration.errors import InputError
from orchestration.instances.record import recorder
from orchestration.instances.record.play import play

from ... import as_fmi3, broken, fmus

pytestmark = [pytest.mark.compile, pytest.mark.isolate]
LIBRARY = "binaries/linux64/probe.so"


def orchestrate(*words: str) -> Result:
    return CliRunner().invoke(main, words)


def recorded(loop: Path, *more: str) -> Path:
    """The record of the regulator in a run of both FMUs."""
    result = orchestrate("run", str(loop), "--record-calls", "regulator", "-o", str(loop.parent / "out"), *more)
    assert "orchestrate replay-calls" in result.output, result.output
    return loop.parent / "out" / "calls" / "regulator" / "calls.bin"


@pytest.mark.parametrize("isolation", ["none", "process"])
@pytest.mark.parametrize("which", ["compiled", "python"])
def test_the_same_fmu_gives_the_recorded_answers(loop: Path, isolation: str, which: str):
    loop.write_text(loop.read_text().replace("isolation: none", f"isolation: {isolation}"))
    played = play(recorded(loop, "--loop", which))
    assert played.same
    calls = int(re.fullmatch(r"(\d+) calls, all answers as recorded", played.lines[-1])[1])
    assert calls > 3 * 10  # Set, DoStep and Get of each step, and what comes before


@pytest.mark.parametrize("which", ["compiled", "python"])
def test_windows_that_are_filled_many_times_over_lose_no_call_and_take_none_twice(
    loop: Path, which: str, monkeypatch: pytest.MonkeyPatch
):
    whole = play(recorded(loop, "--loop", which)).lines[-1]
    size = (loop.parent / "out/calls/regulator/calls.bin").stat().st_size
    monkeypatch.setattr(recorder, "_WINDOW", 64)
    record = recorded(loop, "--loop", which)
    assert record.stat().st_size == size > 3 * recorder._WINDOWS * 64
    assert play(record).lines[-1] == whole


def test_a_run_that_is_recorded_has_the_same_signals(loop: Path):
    orchestrate("run", str(loop), "-o", "plain", "-q")
    record = recorded(loop)
    assert (record.parents[2] / "signals.csv").read_bytes() == Path("plain/signals.csv").read_bytes()


def test_another_fmu_differs_in_the_first_call_that_reads_its_output(loop: Path):
    record = recorded(loop)
    other = loop.parent / "other.fmu"
    binary = fmus.library("probe", "-DDIRECT(x)=((x)[3]*(x)[2]+0.25)")
    fmus.write(other, fmus.description("regulator"), binary)
    played = play(record, other)
    assert not played.same
    assert re.match(r"call \d+, fmi2GetReal at 0 s: voltage is (\S+), recorded (\S+)", played.lines[0])
    now, was = (float(x) for x in re.findall(r"(?:is|recorded) ([^\s,]+)", played.lines[0]))
    assert now - was == pytest.approx(0.25)
    assert play(record, other, tolerance=10.0).same


def test_value_references_are_those_of_the_fmu_that_is_played(loop: Path):
    record = recorded(loop)
    other = loop.parent / "other.fmu"
    xml = fmus.description("regulator").replace(
        'name="voltage" valueReference="1"', 'name="voltage" valueReference="7"'
    )
    fmus.write(other, xml, fmus.library("probe", "-DDIRECT(x)=((x)[7]=(x)[3]*(x)[2])"))
    assert play(record, other).same


def test_the_shortest_record_ends_with_the_call_that_fails(loop: Path):
    record, short = recorded(loop), loop.parent / "short.bin"
    other = loop.parent / "other.fmu"
    fmus.write(other, fmus.description("regulator"), fmus.library("probe", "-DDIRECT(x)=((x)[3]*(x)[2]*1.5)"))
    first = play(record, other, shortest=short).lines[0]
    count = int(re.match(r"call (\d+),", first)[1])
    again = play(short, other)
    assert again.lines == [first, f"1 of {count} calls differ"]
    assert play(record, other, until=count - 1).same


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_record_of_a_crash_is_complete_to_the_call_that_has_not_returned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fmi: int
):
    monkeypatch.chdir(tmp_path)
    case = next(case for case in broken.CASES if case.guid == "step-segfault")
    broken._write(broken.replace(case, fmi=fmi), tmp_path / "vendor.fmu")
    Path("run.yaml").write_text(
        "{name: crash, step: 0.1 s, duration: 2 s, blocks: {vendor: {fmu: vendor.fmu, start: {x: 3}}}}"
    )
    result = orchestrate("run", "run.yaml", "--record-calls", "vendor", "-o", "out")
    assert result.exit_code == 3, result.output
    record = Path("out/calls/vendor/calls.bin")
    replayed = orchestrate("replay-calls", str(record), "--shortest", "short.bin")
    assert replayed.exit_code == 3, replayed.output
    assert re.search(rf"call \d+, fmi{fmi}DoStep at 1 s: ends the process with signal 11", replayed.output)
    again = orchestrate("replay-calls", "short.bin", "--fmu", "vendor.fmu")
    assert again.output.splitlines()[0] == replayed.output.splitlines()[0]


def test_a_record_of_arrays_of_fmi_3_is_played(loop: Path):
    folder = loop.parent
    as_fmi3.write(folder / "three.fmu", folder / "regulator.fmu")
    loop.write_text(loop.read_text().replace("regulator.fmu", "three.fmu"))
    record = recorded(loop)
    assert play(record).same


@pytest.mark.skipif(not shutil.which("make") or not shutil.which("cc"), reason="the program of a vendor needs them")
def test_the_folder_plays_the_record_without_python(loop: Path, tmp_path: Path):
    folder = recorded(loop).parent
    moved = tmp_path / "at the vendor's"
    shutil.move(folder, moved)
    path = os.pathsep.join(part for part in os.environ["PATH"].split(os.pathsep) if "venv" not in part)
    done = subprocess.run(["make"], cwd=moved, capture_output=True, text=True, env={"PATH": path}, check=False)
    assert done.stdout.splitlines()[-1].endswith("all answers as recorded"), done.stdout + done.stderr
    other = tmp_path / "elsewhere" / "regulator.fmu"
    other.parent.mkdir()
    fmus.write(other, fmus.description("regulator"), fmus.library("probe", "-DDIRECT(x)=((x)[3]*(x)[2]*1.5)"))
    os.utime(other, (0, 0))  # older than what was unpacked before
    done = subprocess.run(
        ["make", f"FMU={other}"], cwd=moved, capture_output=True, text=True, env={"PATH": path}, check=False
    )
    assert "voltage is" in done.stdout, done.stdout + done.stderr


def test_what_cannot_be_recorded_or_played_is_refused(loop: Path):
    assert "did you mean 'motor'" in orchestrate("run", str(loop), "--record-calls", "moto").output
    Path("notes.bin").write_text("calls\n")
    with pytest.raises(InputError, match="expected a record of calls"):
        play(Path("notes.bin"))
    record = recorded(loop)
    with zipfile.ZipFile(record.with_name("regulator.fmu"), "a") as archive:
        archive.writestr("resources/more", "")
    with pytest.raises(InputError, match="has another hash"):
        play(record)


@pytest.mark.parametrize(
    ("tail", "words"),
    [(b"", ""), (b"\0" * 30, ""), (struct.pack("<Q", 2**62) + b"\0" * 24, "the record is damaged")],
)
def test_a_tail_that_a_kill_cut_short_is_left_out_and_a_damaged_one_is_told(loop: Path, tail: bytes, words: str):
    record = recorded(loop)
    size = record.stat().st_size
    record.with_suffix(".tail").write_bytes(tail * (4 if words else 1))
    if words:
        with pytest.raises(InputError, match=words):
            play(record)
    else:
        assert play(record).same
        assert not record.with_suffix(".tail").exists()
    assert record.stat().st_size == size
