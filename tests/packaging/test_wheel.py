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

from fmus.build import FLAVOURS, blocks_of, ensure
from fmus.places import work
from hatch_build import BUILT, renamed
from tests.once import once

ROOT = Path(__file__).parents[2]
NAMES = {"attitude_cosim", "orchestration"}
_LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "out", "dist", "results", "__pycache__", ".*_cache", "*.egg-info")


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Made by `python -m build` in a copy of the repository, of the FMUs that the other tests use, too.

    Where what the source archive holds is not all that they are made of, they are built anew, and then fail.
    """
    for flavour in FLAVOURS:
        for block in blocks_of(flavour):
            ensure(block, flavour)

    def make(folder: Path) -> None:
        shutil.copytree(ROOT, folder / "source", ignore=_left_out)
        command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder / "dist")]
        environment = os.environ | {BUILT: str(work() / "fmus")}
        built = subprocess.run(
            command, cwd=folder / "source", env=environment, capture_output=True, text=True, check=False
        )
        assert built.returncode == 0, built.stdout + built.stderr

    dist = once(tmp_path_factory, "wheel", make) / "dist"
    assert len(list(dist.glob("*.tar.gz"))) == 1
    (found,) = dist.glob("*.whl")
    return found


def _left_out(folder: str, names: list[str]) -> set[str]:
    """What git leaves out, at the root only where the name is that of a package elsewhere."""
    found = _LEFT_OUT(folder, names)
    return found if Path(folder) == ROOT else found - {"results"}


@pytest.fixture(scope="session")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel; what the wheel requires comes from the environment of the tests."""

    def make(folder: Path) -> None:
        venv.create(folder, with_pip=False, symlinks=os.name != "nt")
        pip = [sys.executable, "-m", "pip", "--python", str(python(folder)), "install", "--quiet", "--no-deps"]
        subprocess.run([*pip, "--no-index", str(wheel)], check=True)
        # The path of a folder, unlike a site folder, does not bring the repository's editable install along.
        (_site(folder) / "others.pth").write_text(sysconfig.get_path("purelib") + "\n")

    return once(tmp_path_factory, "environment", make)


def python(installed: Path) -> Path:
    return installed / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _site(installed: Path) -> Path:
    return Path(sysconfig.get_path("purelib", vars={"base": str(installed), "platbase": str(installed)}))


def execute(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The environment's Python in a folder, without the repository."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [str(python(installed)), *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


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
    assert {
        f"attitude_cosim/fmus/ready/{flavour}/{block}.fmu" for flavour in FLAVOURS for block in blocks_of(flavour)
    } <= names
    assert {f"attitude_cosim/fmus/ready/loop/{n}" for n in ("linux64.so", "win64.dll", "darwin64.dylib")} <= names
    assert {
        f"attitude_cosim/fmus/ready/container/{n}" for n in ("linux64", "aarch64-linux", "win64", "darwin64")
    } <= names
    assert {f"attitude_cosim/fmus/ready/scenarios/{p.name}" for p in (ROOT / "scenarios").glob("*.yaml")} <= names
    assert "attitude_cosim/fmus/ready/scenarios/satellites/paper_50kg.yaml" in names
    assert "attitude_cosim/plant/inputs.py" in names
    assert "attitude_cosim/fmus/ready/LICENSE" in names
    assert {name.partition("/")[0] for name in names if ".dist-info/" not in name} == NAMES
    assert {f"{name}/py.typed" for name in NAMES} <= names
    assert wheel.name.endswith("-py3-none-any.whl")
    assert wheel.stat().st_size < 12_000_000


def test_from_an_empty_folder_a_user_gets_scenarios_runs_one_and_gets_the_fmus(installed: Path, tmp_path: Path) -> None:
    listed = call(installed, tmp_path, "scenarios", "--copy", "mine")
    assert listed.returncode == 0, listed.stderr
    assert "mine/paper_no_singularity.yaml" in listed.stdout.replace("\\", "/")
    done = call(installed, tmp_path, "mine/paper_no_singularity.yaml")
    assert done.returncode == 0, done.stdout + done.stderr
    manifest = json.loads((tmp_path / "results/paper_no_singularity/manifest.json").read_text())
    assert str(installed) in json.dumps(manifest)
    assert (tmp_path / "results/paper_no_singularity/report.html").is_file()
    bound = call(installed, tmp_path, "momentum-bound", "mine/paper_no_singularity.yaml")
    assert "least time: 2.7 s" in bound.stdout, bound.stderr
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
    done = execute(
        installed, tmp_path, "-c", "from orchestration.master.compiled import _library as l; print(l()._name)"
    )
    assert Path("ready", "loop").as_posix() in done.stdout.replace("\\", "/"), done.stderr
    assert str(installed) in done.stdout


def test_an_installed_copy_has_two_import_names_and_each_of_its_modules_can_be_imported(
    installed: Path, tmp_path: Path
) -> None:
    site = _site(installed)
    assert {path.name for path in site.iterdir() if path.is_dir() and "." not in path.name} == NAMES
    modules = [
        ".".join(path.relative_to(site).with_suffix("").parts).removesuffix(".__init__")
        for name in sorted(NAMES)
        for path in sorted((site / name).rglob("*.py"))
        if path.name != "__main__.py"
    ]
    assert len(modules) > 100
    done = execute(installed, tmp_path, "-c", f"from importlib import import_module as i; [i(n) for n in {modules!r}]")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_an_installed_copy_builds_the_fmus_that_it_brings(installed: Path, tmp_path: Path, flavour: str) -> None:
    done = call(installed, tmp_path, "build", "allocator", "--flavour", flavour, "--out", "built")
    assert done.returncode == 0, done.stderr
    brought = _site(installed) / "attitude_cosim" / "fmus" / "ready" / flavour / "allocator.fmu"
    with zipfile.ZipFile(tmp_path / "built" / "allocator.fmu") as ours, zipfile.ZipFile(brought) as theirs:
        assert {name: ours.read(name) for name in ours.namelist()} == {n: theirs.read(n) for n in theirs.namelist()}


def test_a_python_kit_of_an_installed_copy_builds_a_valid_fmu_that_fits(installed: Path, tmp_path: Path) -> None:
    made = call(installed, tmp_path, "new", "allocator", "mine", "--lang", "python")
    assert made.returncode == 0, made.stderr
    built = execute(installed, tmp_path / "mine", "build.py")
    assert built.returncode == 0, built.stderr
    assert validate_fmu(str(tmp_path / "mine" / "allocator.fmu")) == []
    assert call(installed, tmp_path, "check", "mine/allocator.fmu", "--as", "allocator").returncode == 0


@pytest.mark.usefixtures("c_compiler")
def test_a_c_kit_of_an_installed_copy_builds_and_is_generated_anew(installed: Path, tmp_path: Path) -> None:
    made = call(installed, tmp_path, "new", "allocator", "mine", "--lang", "c")
    assert made.returncode == 0, made.stderr
    assert "python -m attitude_cosim.fmus.kit ." in (tmp_path / "mine" / "README.md").read_text()
    (tmp_path / "mine" / "generated" / "table.c").unlink()
    assert execute(installed, tmp_path / "mine", "-m", "attitude_cosim.fmus.kit", ".").returncode == 0
    subprocess.run(["make"], cwd=tmp_path / "mine", capture_output=True, check=True)
    assert validate_fmu(str(tmp_path / "mine" / "allocator.fmu")) == []


def test_an_import_is_renamed_wherever_it_stands() -> None:
    text = "import plant\nfrom fmus.build import ensure\nfrom fmuspkg import x\n"
    text += "def f():\n    from fmus import (\n        kit,\n    )\n"
    assert renamed(text, "m.py") == text.replace("from fmus.", "from attitude_cosim.fmus.").replace(
        "from fmus ", "from attitude_cosim.fmus "
    ).replace("import plant", "from attitude_cosim import plant")


@pytest.mark.parametrize(
    "line",
    [
        "import fmus.build",
        "import json, plant as p",
        "importlib.import_module('plant.orbit')",
        "files('fmus')",
        "run([sys.executable, '-m', 'fmus.kit'])",
    ],
)
def test_an_import_that_cannot_be_renamed_stops_the_build_with_its_place(line: str) -> None:
    with pytest.raises(ValueError, match=r"m\.py:2: .*the wheel has this module inside attitude_cosim"):
        renamed(f"import importlib\n{line}\n", "m.py")


def test_what_the_wheel_asks_of_a_user_holds_no_compiler(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        metadata = archive.read(next(n for n in archive.namelist() if n.endswith("/METADATA"))).decode()
    needed = [line for line in metadata.splitlines() if line.startswith("Requires-Dist:") and "extra ==" not in line]
    assert needed
    assert not any("ziglang" in line or "pythonfmu" in line for line in needed)
