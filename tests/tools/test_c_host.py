"""What a host that holds no Python, and no C runtime of ours, gets from each flavour."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest

from fmus.build import BLOCKS, blocks_of, ensure

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if sys.platform != "linux":
        pytest.skip("the host is written for Linux")
    out = tmp_path_factory.mktemp("host") / "host"
    source = Path(__file__).with_name("host.c")
    command = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-std=gnu11",
        "-I",
        str(ROOT / "fmus" / "native" / "shell"),
        "-o",
        str(out),
    ]
    subprocess.run([*command, str(source), "-ldl"], check=True, capture_output=True)
    return out


def instantiated(host: Path, block: str, flavour: str, folder: Path) -> str:
    """What the host prints."""
    path = ensure(block, flavour)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    guid = fmpy.read_model_description(str(path)).guid
    library = folder / "binaries" / "linux64" / f"{block}.so"
    run = subprocess.run(
        [str(host), str(library), guid, (folder / "resources").as_uri()], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.mark.parametrize("block", BLOCKS)
def test_the_native_flavour_gives_an_instance(host: Path, block: str, tmp_path: Path) -> None:
    assert instantiated(host, block, "native", tmp_path) == "an instance\n"


@pytest.mark.parametrize("block", blocks_of("python"))
def test_the_python_flavour_says_what_it_needs_and_the_way_out(host: Path, block: str, tmp_path: Path) -> None:
    """The system's reason has the path, which is no format: the host prints it as printf does."""
    said, instance, _ = instantiated(host, block, "python", tmp_path / "50%s %n").split("\n")
    assert instance == "no instance"
    message = (
        "this FMU needs a host that holds Python 3.11 or later with numpy; for any other there is the native "
        "flavour of "
        "this block, which needs nothing. PythonFMU's library cannot be loaded: "
    )
    assert said.startswith(f"block 3 logStatusError: {message}")
    assert "/50%s %n/binaries/" in said
    assert "undefined symbol: _Py" in said or "undefined symbol: Py" in said
    words = " ".join((ROOT / "docs" / "use" / "tools.md").read_text("utf-8").split())
    assert message.strip() in words, "docs/use/tools.md has the exact words"
