"""The C in `sources/` of an FMU: another tool compiles it to a library that gives the same bits."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from posixpath import normpath

import numpy as np
import pytest

from fmus.build import ensure
from fmus.interface import BLOCKS, InterfaceError, load
from fmus.native.carried import collected
from tests.blocks import some
from tests.fmus.carried_data import played
from tests.machine import require_c_compiler

SCRIPTS = Path(sys.executable).parent


@pytest.mark.parametrize("block", some(BLOCKS, "allocator"))
def test_fmpy_compiles_the_sources_and_the_library_gives_the_same_bits(block: str, tmp_path: Path) -> None:
    require_c_compiler()
    environment = os.environ | {"PATH": f"{SCRIPTS}{os.pathsep}{os.environ['PATH']}"}
    if shutil.which("cmake", path=environment["PATH"]) is None:
        pytest.skip("needs cmake")
    fmu = tmp_path / f"{block}.fmu"
    shutil.copy(ensure(block), fmu)
    shipped, before = played(fmu, load(block)), _library(fmu, block)
    subprocess.run([SCRIPTS / "fmpy", "compile", fmu], check=True, capture_output=True, env=environment)
    assert _library(fmu, block) != before
    np.testing.assert_array_equal(played(fmu, load(block)).view(np.uint64), shipped.view(np.uint64))


def _library(fmu: Path, block: str) -> bytes:
    with zipfile.ZipFile(fmu) as archive:
        return archive.read(f"binaries/linux64/{block}.so")


@pytest.mark.parametrize("block", BLOCKS)
def test_every_file_that_computes_forbids_fused_multiply_add(block: str) -> None:
    """By <math.h>, so that the bits do not depend on the options of whoever compiles."""
    with zipfile.ZipFile(ensure(block)) as archive:
        files = {
            name.removeprefix("sources/"): archive.read(name).decode()
            for name in archive.namelist()
            if name.startswith("sources/")
        }

    def reaches(name: str, seen: set[str]) -> bool:
        seen.add(name)
        beside = name.rpartition("/")[0]
        included = re.findall(r'#include ["<]([\w/.]+)[">]', files.get(name, ""))
        inside = [next((p for p in (normpath(f"{beside}/{i}"), i) if p in files), i) for i in included]
        return "math.h" in inside or any(reaches(i, seen) for i in inside if i not in seen)

    computing = [n for n in files if n.endswith(".c") and n not in ("memory.c", "state.c", "table.c")]
    assert [n for n in computing if not reaches(n, set())] == []
    assert "FP_CONTRACT OFF" in files["math.h"]


def test_two_files_of_one_name_are_refused(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "step.c").write_text("")
    with pytest.raises(InterfaceError, match=r"two.step\.c: another file .* has the name step\.c"):
        collected([tmp_path / "one", tmp_path / "two"])
