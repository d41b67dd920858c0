"""A kit that is renamed is the kit that would have been written under the new name, and keeps what it replaces."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from fmus.interface import load
from fmus.kit import regenerate, write
from fmus.kit.rename import rename
from orchestration.fmu.archive import read_head
from tests.machine import require_c_compiler


def renamed(folder: Path, language: str) -> Path:
    write(load("allocator"), folder, language)
    rename(folder, "actuators")
    regenerate(folder)
    return folder


@pytest.mark.parametrize("language", ["c", "python"])
def test_nothing_of_the_old_name_is_left_but_the_block_that_it_replaces(tmp_path, language):
    folder = renamed(tmp_path / "kit", language)
    names = [path.name for path in folder.rglob("*")]
    assert not [name for name in names if "allocator" in name]
    left = "".join(p.read_text() for p in folder.rglob("*") if p.suffix in (".c", ".h", ".py") or p.name == "Makefile")
    assert "allocator_" not in left.replace("allocator_bounded", "")
    assert "Allocator" not in left
    assert "orchestrate check actuators.fmu --as allocator" in (folder / "README.md").read_text()


@pytest.mark.compile
def test_a_renamed_kit_in_c_builds_an_fmu_of_the_new_name(tmp_path):
    require_c_compiler()
    folder = renamed(tmp_path / "kit", "c")
    subprocess.run(["make", "-s", "-C", folder, "actuators.fmu"], check=True, capture_output=True)
    assert read_head(folder / "actuators.fmu") is not None


def test_a_name_that_code_cannot_have_and_a_folder_without_a_kit_are_refused_in_a_sentence(tmp_path):
    write(load("allocator"), tmp_path / "kit", "c")
    with pytest.raises(ValueError, match="expected a name of small letters"):
        rename(tmp_path / "kit", "My Actuators")
    done = subprocess.run(
        [sys.executable, "-m", "fmus.kit", str(tmp_path), "--name", "x"], capture_output=True, text=True, check=False
    )
    told = f"{tmp_path} holds no interface.toml, so it is no kit; remedy: the folder of one\n"
    assert (done.returncode, done.stderr) == (1, told)
