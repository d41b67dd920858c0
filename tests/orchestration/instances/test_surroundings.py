"""What an FMU in the run's own process changes for others is restored and told, and one that ends the process is no
success."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from orchestration import run as run_scenario
from orchestration.instances.guest import Trace

from .. import broken, fmus

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes and signals of Linux")
ROOT = Path(__file__).parents[3]
SCENARIO = """\
name: run
step: 0.1 s
duration: 2 s
isolation: none
blocks:
  vendor: {fmu: vendor.fmu}
  other: {fmu: other.fmu}
connections: [vendor.y -> vendor.x, vendor.y -> other.x]
"""


@pytest.fixture(scope="module")
def library() -> bytes:
    return fmus.library("broken")


@pytest.fixture
def run(tmp_path, library):
    def run(guid: str, *options: str, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
        for name, own in (("vendor", guid), ("other", "none-none")):
            xml = broken.XML.format(guid=own).replace('"broken"', f'"{name}"')
            broken_write(tmp_path / f"{name}.fmu", xml, library)
        text = SCENARIO
        (tmp_path / "run.yaml").write_text(text)
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_COLOR": "1", "COLUMNS": "400"}
        command = [sys.executable, "-m", "orchestration", "run.yaml", *options]
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=timeout, check=False
        )

    return run


def broken_write(path: Path, xml: str, library: bytes) -> None:
    import zipfile

    import fmpy

    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr(f"binaries/{fmpy.platform}/{path.stem}{fmpy.sharedLibraryExtension}", library)


@pytest.mark.parametrize(
    ("guid", "loop", "words"),
    [
        ("step-round", "compiled", "vendor: fmi2DoStep changed the rounding mode; it was restored"),
        ("step-round", "python", "vendor: fmi2DoStep changed the rounding mode; it was restored"),
        ("step-limit", "compiled", "vendor or other: the run changed the limit of open files; it was restored"),
        ("step-flush", "compiled", "vendor or other: the run changed the arithmetic, which took the smallest numbers "),
        ("step-move", "compiled", "vendor or other: the run changed the working folder; it was restored"),
        ("step-signal", "compiled", "vendor or other: the run changed the handler of SIGCHLD; it was restored"),
        ("enter-round", "compiled", "vendor: fmi2EnterInitializationMode changed the rounding mode; it was restored"),
        ("enter-move", "compiled", "vendor: fmi2EnterInitializationMode changed the working folder; it was restored"),
        ("enter-deafen", "compiled", "vendor: fmi2EnterInitializationMode changed the handler of SIGINT; it was rest"),
        ("none-none", "compiled", ""),
    ],
)
def test_a_change_for_all_is_restored_and_told_with_the_fmu_and_results_are_written(guid, loop, words, run, tmp_path):
    done = run(guid, "--loop", loop)
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "results" / "run" / "signals.csv").read_text().splitlines()) == 22
    assert words in done.stdout + done.stderr
    assert (done.stdout + done.stderr).count(" changed ") == (1 if words else 0)


@pytest.mark.parametrize(
    ("guid", "loop", "words"),
    [
        ("step-vanish", "compiled", "vendor: fmi2DoStep at 1 s: ended the run with exit status 0; nothing of this run"),
        ("step-vanish", "python", "vendor: fmi2DoStep at 1 s: ended the run with exit status 0; nothing of this run"),
        ("input-vanish", "compiled", "vendor: fmi2Set at 1 s: ended the run with exit status 0"),
        ("enter-vanish", "compiled", "vendor: fmi2EnterInitializationMode: ended the run with exit status 0"),
        ("step-segfault", "compiled", "vendor: fmi2DoStep at 1 s: crashed with SIGSEGV"),
        ("step-real", "compiled", "vendor: fmi2DoStep at 1 s: crashed with signal 40"),
        ("terminate-vanish", "compiled", "vendor: fmi2FreeInstance: ended the run with exit status 0"),
    ],
)
def test_an_fmu_that_ends_the_process_is_a_failure_with_its_place_and_earlier_results_are_kept(
    guid, loop, words, run, tmp_path
):
    (tmp_path / "results" / "run").mkdir(parents=True)
    earlier = tmp_path / "results" / "run" / "manifest.json"
    earlier.write_text('{"scenario": {}}')
    done = run(guid, "--loop", loop, "--quiet")
    assert done.returncode == 3, done.stderr
    assert words in done.stderr
    assert earlier.read_text() == '{"scenario": {}}'


@pytest.mark.parametrize(
    ("guid", "words"),
    [
        ("step-silence", "changed the file 1 (output), which it closed; it was restored"),
        ("step-rid", "open files of this program, which it closed"),
    ],
)
def test_an_fmu_that_closes_files_of_the_program_loses_no_results_and_the_run_says_so(guid, words, run, tmp_path):
    done = run(guid)
    assert done.returncode == 0, done.stderr
    assert words in done.stdout + done.stderr
    assert len((tmp_path / "results" / "run" / "signals.csv").read_text().splitlines()) == 22


def test_a_run_that_is_killed_says_so_and_ends_by_the_same_signal(run, tmp_path):
    done = run("step-kill")
    assert done.returncode == -signal.SIGKILL
    assert "vendor: fmi2DoStep at 1 s: the run was killed (SIGKILL, as the system does for want of mem" in done.stderr


def test_values_of_others_are_those_of_a_run_without_the_change(run, tmp_path):
    tables = []
    for guid in ("none-none", "step-round"):
        assert run(guid, "--quiet").returncode == 0
        tables.append(np.genfromtxt(tmp_path / "results" / "run" / "signals.csv", delimiter=",", skip_header=1))
    np.testing.assert_array_equal(*tables)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_a_signal_to_the_command_ends_the_run_with_it(number, run, tmp_path):
    run("none-none", "--quiet")
    text = (tmp_path / "run.yaml").read_text().replace("duration: 2 s", "duration: 600 s")
    (tmp_path / "run.yaml").write_text(text)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-m", "orchestration", "run.yaml", "--quiet", "--realtime"],
        cwd=tmp_path,
        env=environment,
        start_new_session=True,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    for _ in range(400):
        if child := children.read_text().split():
            break
        signal.sigtimedwait([], 0.05)
    signal.sigtimedwait([], 1.5)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does
    else:
        process.send_signal(number)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number), errors
    for _ in range(100):
        if not Path(f"/proc/{child[0]}").exists():
            return
        signal.sigtimedwait([], 0.05)
    pytest.fail("the run goes on")


def test_the_same_call_twice_is_another_one_and_none_runs_between():
    """Else one that returns at once, and is made again and again, would be taken for one that hangs."""
    trace = Trace()
    trace.at("a", "fmi2Reset")
    first = trace.running
    trace.rest()
    assert trace.running is None
    assert trace.text == "a: fmi2Reset"
    trace.at("a", "fmi2Reset")
    assert first is not None
    assert trace.running == (first[0] + 1, "a: fmi2Reset")
    trace.renew()
    assert trace.running is None


def test_flights_with_fmus_of_others_leave_no_file_open(tmp_path, library):
    for name in ("vendor", "other"):
        broken_write(
            tmp_path / f"{name}.fmu", broken.XML.format(guid="none-none").replace('"broken"', f'"{name}"'), library
        )
    (tmp_path / "run.yaml").write_text(SCENARIO)
    run_scenario(tmp_path / "run.yaml")
    before = len(os.listdir("/dev/fd"))
    run_scenario(tmp_path / "run.yaml")
    assert len(os.listdir("/dev/fd")) == before
