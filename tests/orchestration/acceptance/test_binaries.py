"""The tables of libraries: against nm, for each platform that a compiler builds, damaged, and without the package
lief."""

from __future__ import annotations

import subprocess
import sys
import zipfile

import fmpy
import pytest

from fmus.build import ensure
from orchestration.acceptance import binaries
from orchestration.acceptance.check import check
from tests.machine import require_elf_tools
from tests.orchestration import fmus, vendor

pytestmark = pytest.mark.compile

FMI = set(binaries.FUNCTIONS["fmi2"])


def listed(*options):
    done = subprocess.run(["nm", "-D", *options, "p.so"], capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


def test_the_symbols_of_a_library_are_those_that_nm_lists(tmp_path, monkeypatch):
    pytest.importorskip("lief")
    require_elf_tools("nm")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.so").write_bytes(fmus.library())
    library = binaries.read(fmus.library())
    defined = {name.split("@")[0] for _, kind, name in listed("--defined-only") if kind in "TDBRVW"}
    assert FMI <= defined <= library.exported
    assert {words[-1].split("@")[0] for words in listed("--undefined-only") if words[0] == "U"} == library.undefined


@pytest.mark.parametrize(
    ("platform", "suffix", "kind"),
    [("linux64", ".so", "ELF"), ("win64", ".dll", "PE"), ("darwin64", ".dylib", "Mach-O")],
)
def test_the_functions_are_seen_on_each_platform_and_damage_is(platform, suffix, kind):
    pytest.importorskip("lief")
    with zipfile.ZipFile(ensure("allocator", "native")) as archive:
        name = f"binaries/{platform}/allocator{suffix}"
        if name not in archive.namelist():
            pytest.skip("built for this machine only")
        data = archive.read(name)
    library = binaries.read(data)
    assert (library.kind, library.exported >= FMI) == (kind, True)
    for left in (20, 100, 500, 2000):
        with pytest.raises(binaries.Unreadable, match="its tables are damaged"):
            binaries.read(data[:left])
    with pytest.raises(binaries.Unreadable, match="it is no shared library"):
        binaries.read(b"#!/bin/sh\n" + data)


def test_without_its_reader_the_check_says_what_it_has_not_looked_at(tmp_path, monkeypatch):
    fmus.write_pair(tmp_path, runnable=True)
    vendor.write(tmp_path, runnable=True)
    monkeypatch.setitem(sys.modules, "lief", None)
    monkeypatch.chdir(tmp_path)
    found, _ = check(tmp_path / "vendor.fmu", "regulator.fmu", tmp_path / "mapping.yaml")
    assert not [finding for finding in found if finding.level == "error"]
    (told,) = [finding for finding in found if finding.topic == "functions"]
    assert (told.level, told.remedy) == ("warning", "pip install 'attitude-cosim[check]'")
    assert "what they need, is not looked at without the package lief" in told.text
    fmus.write(tmp_path / "vendor.fmu", fmus.description("regulator"), b"text")
    found, _ = check(tmp_path / "vendor.fmu", "regulator.fmu")
    assert f"{fmpy.platform}: it is no shared library" in [finding.text for finding in found], "that is seen without"
