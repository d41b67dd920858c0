"""`orchestrate convert` on a run of the project's own blocks, and what it refuses."""

import json
import os
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from formats import aem
from formats.convert import convert as write
from formats.recorded import Recorded, recorded
from inflight.orbit import read_elements
from orchestration import InputError, run
from orchestration.cli import main as orchestrate

GROUP = "orchestrate.commands"


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """The commands that pyproject.toml adds, whenever this copy was installed."""
    named = tomllib.loads(Path("pyproject.toml").read_text("utf-8"))["project"]["entry-points"][GROUP]
    points = {name: EntryPoint(name, place, GROUP) for name, place in named.items()}
    monkeypatch.setattr(orchestrate, "outside", lambda: points)


@pytest.fixture(scope="module")
def result():
    return run("scenarios/paper_no_singularity.yaml", duration="5 s")


def convert(*arguments):
    return CliRunner().invoke(orchestrate.main, ["convert", *map(str, arguments)])


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_a_folder_has_the_signals_of_its_result(result, tmp_path, form):
    found = recorded(result.save(tmp_path, form))
    assert list(found.signals) == list(result)
    assert found.time.tolist() == result.time.tolist()
    for name, values in result.items():
        assert np.array_equal(found.signals[name], values), name
    assert found.units["plant.h_w"] == "N.m.s"
    assert found.parameters["plant"]["epoch"] == "2009-08-10T00:00:00Z"


@pytest.mark.parametrize("to", ["aem", "oem", "mcap", "ck", "hdf5"])
def test_the_files_stand_in_the_folder_of_the_run(result, tmp_path, to):
    folder = result.save(tmp_path / "out")
    before = set(folder.iterdir())
    done = convert(folder, "--to", to)
    assert done.exit_code == 0, done.output
    (new,) = set(folder.iterdir()) - before
    assert str(new) in done.stdout
    assert new.is_dir() == (to == "ck")


def test_an_attitude_is_compared_with_an_ephemeris_and_a_tolerance(result, tmp_path):
    folder = result.save(tmp_path / "out")
    assert convert(folder, "--to", "aem", "--out", tmp_path / "a.xml", "--frame", "GCRF").exit_code == 0
    done = convert(folder, "--compare", tmp_path / "a.xml", "--tolerance", "1e-9 rad")
    assert (done.exit_code, done.stdout.split(":")[0]) == (0, "attitude at 51 instants")
    apart = convert(
        folder, "--compare", tmp_path / "a.xml", "--tolerance", "1e-9 rad", "--epoch", "2009-08-10T00:00:01Z"
    )
    assert apart.exit_code == 1


def test_an_ephemeris_becomes_the_goal_of_a_supervisor(tmp_path):
    """Two pointings in GCRF, 6 s apart: each is the reference from the step after its instant on, in N."""
    scenario = Path("scenarios/track_ground_station.yaml").resolve()
    R = Rotation.random(2, random_state=3).as_matrix()
    plan = Recorded("plan", np.array([0.0, 6.0]), {"plant.R_NB": R}, {}, {"plant": {"epoch": "2009-08-10T00:00:00Z"}})
    write(plan, "aem", tmp_path / "plan.aem", frame="GCRF")
    done = convert(
        *(tmp_path / "plan.aem", "--to", "timeline", "--scenario", scenario, "--out", tmp_path / "planned.yaml")
    )
    assert done.stdout == f"2 entries in {tmp_path / 'planned.yaml'}\n"
    assert "- at: 0 s\n" in (tmp_path / "planned.yaml").read_text("utf-8")
    flown = run(tmp_path / "planned.yaml", duration="10 s")
    assert (flown.scenario.name, flown.outcomes) == ("planned", [])
    for t, goal in ((5.0, R[0]), (10.0, R[1])):
        reference = flown["supervisor.R_ref"][flown.time == t][0]
        assert reference == pytest.approx(goal, abs=1e-9), t


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        ("superviser.R_goal", "--goal: expected BLOCK.INPUT, a block of"),
        ("supervisor.R_gaol", "--goal: supervisor has no input 'R_gaol'; did you mean 'R_goal'?"),
        ("supervisor.command", "--goal: expected an input that is a real [3, 3], found supervisor.command, input"),
        ("supervisor.R_ref", "--goal: expected an input that is a real [3, 3], found supervisor.R_ref, output"),
    ],
)
def test_a_goal_that_takes_no_attitude_is_refused(tmp_path, goal, message):
    (tmp_path / "plan.aem").write_text("CCSDS_AEM_VERS = 1.0\n")
    scenario = "scenarios/track_ground_station.yaml"
    more = ("--scenario", scenario, "--out", tmp_path / "planned.yaml", "--goal", goal)
    done = convert(tmp_path / "plan.aem", "--to", "timeline", *more)
    assert (done.exit_code, message in done.stderr) == (2, True), done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing", "--to", "aem"], "nothing: expected the folder of a run"),
        (["nothing"], "expected --to FORMAT or --compare FILE.aem, found neither"),
        (["FOLDER", "--to", "aem", "--attitude", "plant.R_BN"], "--attitude: plant.R_BN was not recorded"),
        (["FOLDER", "--to", "aem", "--attitude", "plant.omega_B"], "expected a matrix (3, 3) or a quaternion (4,)"),
        (["FOLDER", "--to", "aem", "--epoch", "2009-02-30T00:00:00"], "--epoch: expected a date of the calendar"),
        (
            ["FOLDER", "--to", "timeline"],
            "expected FILE.aem --to timeline or reference --scenario SCENARIO --out FILE.yaml",
        ),
    ],
)
def test_wrong_input_is_told_without_a_traceback(result, tmp_path, arguments, message):
    result.save(tmp_path / "out")
    done = convert(*(str(tmp_path / "out") if a == "FOLDER" else a for a in arguments))
    assert done.exit_code == 2
    assert message in done.stderr


def unsealed(folder):
    """Takes the hashes of a run's files out of its manifest: else they tell first."""
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps({**manifest, "files": {}}))


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [("manifest.json", "[]", "a manifest.json that is none"), ("signals.csv", "time,a\n", "no rows in signals.csv")],
)
def test_a_folder_whose_files_are_damaged_is_told_without_warnings_of_libraries(result, tmp_path, name, text, found):
    folder = result.save(tmp_path / "out")
    unsealed(folder)
    (folder / name).write_text(text)
    done = convert(str(tmp_path / "out"), "--to", "aem")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert f"found {found}; remedy: " in done.stderr


def test_what_is_not_finite_or_has_another_unit_is_refused_and_the_runs_own_files_stay(result, tmp_path):
    folder = result.save(tmp_path / "out")
    told = convert(folder, "--to", "aem", "--rate", "plant.r_N")
    assert (told.exit_code, "expected the unit rad/s, found m" in told.stderr) == (2, True)
    told = convert(folder, "--to", "hdf5", "--out", folder / "manifest.json")
    assert (told.exit_code, "none of a run's own" in told.stderr) == (2, True)
    lines = (folder / "signals.csv").read_text().splitlines()
    column = lines[0].split(",").index("plant.R_NB[1][1]")
    row = lines[3].split(",")
    row[column] = "nan"
    (folder / "signals.csv").write_text("\n".join([*lines[:3], ",".join(row), *lines[4:]]) + "\n")
    unsealed(folder)
    told = convert(folder, "--to", "aem", "--out", tmp_path / "a.aem")
    assert told.exit_code == 2
    assert "plant.R_NB" in told.stderr
    assert f"at {float(row[0]):.10g} s" in told.stderr
    assert not (tmp_path / "a.aem").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_device_or_a_pipe_is_no_ephemeris_and_nobody_waits(tmp_path):
    os.mkfifo(tmp_path / "pipe.aem")
    for path in ("/dev/zero", tmp_path / "pipe.aem"):
        assert not aem.is_aem(Path(path))
        with pytest.raises(InputError, match=r"expected a CCSDS AEM, found .* is no regular file"):
            aem.read(Path(path))
        with pytest.raises(InputError, match="is no regular file"):
            read_elements(Path(path))
