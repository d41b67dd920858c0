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
from tests.native.test_derivatives import derivative
from tests.native.test_fmi3 import slave, three

SCRIPTS = Path(sys.executable).parent


@pytest.mark.parametrize("block", some(BLOCKS, "allocator"))
def test_fmpy_compiles_the_sources_and_the_library_gives_the_same_bits(block: str, tmp_path: Path) -> None:
    shipped = ensure(block)
    compiled = _compiled(shipped, tmp_path)
    assert _library(compiled, block) != _library(shipped, block)
    _assert_same_bits(compiled, shipped, block)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("block", some(BLOCKS, "controller", "plant"))
def test_fmpy_compiles_those_of_fmi_3_with_their_slopes(block: str, compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"needs {compiler}")
    shipped = three(block)
    compiled = _compiled(shipped, tmp_path, CC=compiler, CXX={"gcc": "g++", "clang": "clang++"}[compiler])
    _assert_same_bits(compiled, shipped, block)
    if load(block).derivatives:
        seen = [_slopes(fmu, block, tmp_path / name) for fmu, name in ((shipped, "shipped"), (compiled, "compiled"))]
        assert seen[0].any()
        np.testing.assert_array_equal(*seen)


def _compiled(shipped: Path, folder: Path, **more: str) -> Path:
    """A copy of the FMU that has the library which `fmpy compile` makes of its sources."""
    require_c_compiler()
    environment = os.environ | {"PATH": f"{SCRIPTS}{os.pathsep}{os.environ['PATH']}"} | more
    if shutil.which("cmake", path=environment["PATH"]) is None:
        pytest.skip("needs cmake")
    fmu = Path(shutil.copy(shipped, folder))
    subprocess.run([SCRIPTS / "fmpy", "compile", fmu], check=True, capture_output=True, env=environment)
    return fmu


def _library(fmu: Path, block: str) -> bytes:
    with zipfile.ZipFile(fmu) as archive:
        return archive.read(f"binaries/linux64/{block}.so")


def _assert_same_bits(one: Path, other: Path, block: str) -> None:
    seen = [played(fmu, load(block)).view(np.uint64) for fmu in (one, other)]
    np.testing.assert_array_equal(*seen)


def _slopes(fmu: Path, block: str, folder: Path) -> np.ndarray:
    """The slopes of all outputs along all inputs, in initialization mode with the start values."""
    it = slave(fmu, folder)
    it.block = load(block)
    it.enterInitializationMode()
    outputs, inputs = ([v.name for v in it.block.of(kind) if v.type == "real"] for kind in ("output", "input"))
    seed = np.ones(sum(len(it.block.variables[name].elements) for name in inputs))
    found = derivative(it, outputs, inputs, seed)
    it.freeInstance()
    return found


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
