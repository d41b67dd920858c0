"""The wheel, made from the source archive, installed where there are no sources, and used from an empty folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu

from fmus.build import FLAVOURS, blocks_of

ROOT = Path(__file__).parents[2]
_LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "dist", "results", "__pycache__", ".*_cache", "*.egg-info")


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Made by `python -m build`, from a copy, so that the repository stays as it is."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(ROOT, folder / "source", ignore=_LEFT_OUT)
    command = [
        sys.executable,
        "-m",
        "build",
        "--no-isolation",
        "--outdir",
        str(folder / "dist"),
        str(folder / "source"),
    ]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    assert len(list((folder / "dist").glob("*.tar.gz"))) == 1
    (found,) = (folder / "dist").glob("*.whl")
    return found


@pytest.fixture(scope="session")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel; what the wheel requires comes from the environment of the tests."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=os.name != "nt")
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "--no-index"]
    subprocess.run([*pip, str(wheel)], check=True)
    variables = {"base": str(folder), "platbase": str(folder)}
    # The path of a folder, unlike a site folder, does not bring the repository's editable install along.
    Path(sysconfig.get_path("purelib", vars=variables), "others.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder


def call(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`orchestrate` of the environment in a folder; no compiler can be found, and the home is the folder's own."""
    environment = {"HOME": str(folder / "home"), "PATH": str(folder)}
    environment |= {key: os.environ[key] for key in ("SYSTEMROOT", "TEMP") if key in os.environ}
    command = installed / ("Scripts/orchestrate.exe" if os.name == "nt" else "bin/orchestrate")
    return subprocess.run(
        [str(command), *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def test_a_wheel_brings_fmus_loops_scenarios_and_licence(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert {f"fmus/ready/{flavour}/{block}.fmu" for flavour in FLAVOURS for block in blocks_of(flavour)} <= names
    assert {f"fmus/ready/loop/{n}" for n in ("linux64.so", "win64.dll", "darwin64.dylib")} <= names
    assert {f"fmus/ready/scenarios/{p.name}" for p in (ROOT / "scenarios").glob("*.yaml")} <= names
    assert "fmus/ready/LICENSE" in names
    assert not any(name.startswith(("tests/", "docs/", "studies/", "examples/")) for name in names)
    assert wheel.name.endswith("-py3-none-any.whl")
    assert wheel.stat().st_size < 5_000_000


def test_from_an_empty_folder_a_user_gets_scenarios_runs_one_and_gets_the_fmus(installed: Path, tmp_path: Path) -> None:
    listed = call(installed, tmp_path, "scenarios", "--copy", "mine")
    assert listed.returncode == 0, listed.stderr
    assert "mine/paper_no_singularity.yaml" in listed.stdout.replace("\\", "/")
    done = call(installed, tmp_path, "mine/paper_no_singularity.yaml")
    assert done.returncode == 0, done.stdout + done.stderr
    manifest = json.loads((tmp_path / "results/paper_no_singularity/manifest.json").read_text())
    assert str(installed) in json.dumps(manifest)
    assert (tmp_path / "results/paper_no_singularity/report.html").is_file()
    handed = call(installed, tmp_path, "fmus", "--copy", "handed")
    assert handed.returncode == 0, handed.stderr
    for block in blocks_of("native"):
        assert validate_fmu(str(tmp_path / "handed" / f"{block}.fmu")) == []
    assert {p.name for p in tmp_path.iterdir()} <= {"mine", "results", "handed", "home"}
    assert not list((tmp_path / "home").rglob("*.fmu")), "nothing was built"


def test_scenarios_that_are_there_are_not_overwritten(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "minimal.yaml").write_text("mine")
    done = call(installed, tmp_path, "scenarios", "--copy", ".")
    assert done.returncode == 2
    assert "minimal.yaml is there already" in done.stderr
    assert (tmp_path / "minimal.yaml").read_text() == "mine"


def test_the_step_loop_is_the_compiled_one(installed: Path, tmp_path: Path) -> None:
    code = "from orchestration.master.compiled import _library; import fmus; print(_library()._name, fmus.__file__)"
    python = installed / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [str(python), "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert Path("ready", "loop").as_posix() in done.stdout.replace("\\", "/")
    assert str(installed) in done.stdout


def test_what_the_wheel_asks_of_a_user_holds_no_compiler(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        metadata = archive.read(next(n for n in archive.namelist() if n.endswith("/METADATA"))).decode()
    needed = [line for line in metadata.splitlines() if line.startswith("Requires-Dist:") and "extra ==" not in line]
    assert needed
    assert not any("ziglang" in line or "pythonfmu" in line for line in needed)
