"""The kit: what another team is given builds at once, is valid, and knows when it is right."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu

from fmus import kit
from fmus.block import natives
from fmus.interface import BLOCKS, load, parse
from fmus.native import generated_sources
from fmus.native.generate import camel_case
from orchestration import load as load_scenario
from orchestration.acceptance.vector import name_of
from orchestration.fmu.interfaces import place
from tests.blocks import folder as folder_of
from tests.blocks import some
from tests.commands import orchestrate

ROOT = Path(__file__).parents[3]
needs_compiler = pytest.mark.usefixtures("c_compiler")


def make(folder: Path, *targets: str) -> subprocess.CompletedProcess[str]:
    """Without optimisation, which takes a third of the time; the tests of the wheel build a kit as a team does."""
    environment = {"CFLAGS": "-O0", **os.environ}
    return subprocess.run(["make", *targets], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def flown(block: str, folder: Path) -> list[str]:
    """Options for a run with the block, where no scenario of the project has it: that of the block in whose place it
    stands."""
    if any(name_of(load_scenario(path), block) for path in kit.SCENARIO.parent.glob("*.yaml")):
        return []
    source = load_scenario(kit.SCENARIO).source.without([(key,) for key in ("expect", "figures", "holds", "record")])
    entry = source.data["blocks"][place(block)]
    known = load(block).variables
    start = {key: value for key, value in entry["start"].items() if key.partition("[")[0] in known}
    source = source.with_entry(("blocks", place(block)), {"fmu": block, "start": start})
    path = folder / "flown.yaml"
    path.write_text(json.dumps(source.data), "utf-8")  # which is YAML, too
    return ["--scenario", str(path)]


@pytest.fixture(scope="module", params=some(BLOCKS, "plant", "allocator", "supervisor"))
def c_kit(request, tmp_path_factory) -> tuple[str, Path]:
    folder = tmp_path_factory.mktemp("kits") / request.param
    result = orchestrate("new", request.param, folder, "--lang", "c", *flown(request.param, folder.parent))
    assert result.exit_code == 0, result.output
    return request.param, folder


@needs_compiler
def test_a_fresh_c_kit_builds_a_valid_fmu_that_fits(c_kit):
    block, folder = c_kit
    built = make(folder)
    assert built.returncode == 0, built.stderr
    fmu = folder / f"{block}.fmu"
    assert validate_fmu(str(fmu)) == []
    with zipfile.ZipFile(fmu) as archive:
        assert archive.testzip() is None
    checked = orchestrate("check", fmu, "--as", block)
    assert checked.exit_code == 0, checked.stdout
    assert "missing" not in checked.stdout


@needs_compiler
def test_the_vector_tells_an_empty_block_from_a_right_one(c_kit):
    block, folder = c_kit
    empty = make(folder, "vector")
    assert empty.returncode != 0
    assert "outputs differ from what is expected" in empty.stdout
    for path in (path for source in natives(folder_of(block)) for path in source.rglob("*.[ch]")):
        flat = re.sub(r'#include "[\w./]*/', '#include "', path.read_text("utf-8"))  # a kit has no folders
        (folder / path.name).write_text(flat, "utf-8")
    for name, text in generated_sources(load(block), folder_of(block)).items():
        (folder / name).write_text(text)
    if (code := load(block).code) != block:  # ours for a set of parts is that of one part by name
        types = ("Parameters", "Inputs", "Outputs", "State", "Law")
        own = [f"typedef {camel_case(code)}{t} {camel_case(block)}{t};" for t in types]
        own += [f"#define {block}_{f} {code}_{f}" for f in ("check", "prepare", "start", "outputs", "step")]
        own += [f"#define {block.upper()}_PORTS_H"]  # the types are those of the code's own ports
        (folder / f"{block}.h").write_text("\n".join(["#pragma once", f'#include "{code}.h"', *own, ""]))
        (folder / f"{block}.c").write_text(f'#include "{block}.h"\n')
    right = make(folder, "vector", "CFLAGS=-O1")
    assert right.returncode == 0, right.stdout + right.stderr
    assert "all outputs are as expected" in right.stdout


@needs_compiler
@pytest.mark.thorough
def test_orchestrate_plays_the_vector_too(c_kit):
    block, folder = c_kit
    from fmus.build import ensure

    right = orchestrate("check", ensure(block, "native"), "--as", block, "--vector", folder / "vector")
    assert right.exit_code == 0, right.stdout
    assert right.stdout.count("vector ") >= len(load(block).of("output"))


@needs_compiler
def test_a_kit_packs_reference_data_that_are_played_and_tell_a_later_change(tmp_path):
    folder = tmp_path / "kit"
    assert orchestrate("new", "allocator", folder).exit_code == 0
    source = folder / "allocator.c"
    text = source.read_text()
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    made = subprocess.run(
        ["make", "CFLAGS=-O0", "reference"], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    fmu = folder / "allocator.fmu"
    assert validate_fmu(str(fmu)) == []
    right = orchestrate("check", fmu, "--as", "allocator")
    assert (right.exit_code, "outputs as expected over 6 s" in right.stdout) == (0, True), right.stdout
    source.write_text(text.replace("Outputs){0};", "Outputs){.holding = true};"))
    assert make(folder).returncode == 0
    wrong = orchestrate("check", fmu, "--as", "allocator")
    assert (wrong.exit_code, "smoke-test: holding differs by 1" in wrong.stdout) == (1, True), wrong.stdout


@pytest.mark.parametrize("options", [[], ["--lang", "python"], ["--link"], ["--link", "--lang", "python"]])
@pytest.mark.thorough
def test_the_commands_it_prints_hold_in_a_folder_whose_name_has_a_space(tmp_path, options):
    folder = tmp_path / "my kit"
    told = orchestrate("new", "allocator", folder, *options).stdout
    (line,) = (line for line in told.splitlines() if line.startswith("  cd "))
    assert shlex.split(line)[:2] == ["cd", str(folder)]


def test_a_python_kit_builds_a_valid_fmu_that_fits(tmp_path):
    folder = tmp_path / "mine"
    written = orchestrate("new", "allocator", folder, "--lang", "python")
    assert written.exit_code == 0
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    built = subprocess.run(
        [sys.executable, "build.py"], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    fmu = folder / "allocator.fmu"
    assert validate_fmu(str(fmu)) == []
    empty = orchestrate("check", fmu, "--as", "allocator", "--vector", folder / "vector")
    assert empty.exit_code == 1
    assert re.search(r"ERROR +vector +dipole_cmd: differs by", empty.stdout)
    assert "the ports fit, the outputs are not those of the vector" in empty.stdout
    own = shlex.split(written.stdout.splitlines()[-1])
    assert own[2:] == ["--swap", "allocator=allocator.fmu"]
    flown = orchestrate(*own[1:3], f"allocator={fmu}", "--out", tmp_path / "flown")
    assert flown.exit_code == 1, "equations of its own fly in the loop; these are zeros and meet no expectation"
    assert (tmp_path / "flown" / "expectations.json").exists()
    for path in (ROOT / "allocator").glob("*.py"):
        shutil.copy(path, folder / "allocator")
    subprocess.run([sys.executable, "build.py"], cwd=folder, env=environment, capture_output=True, check=True)
    right = orchestrate("check", fmu, "--as", "allocator", "--vector", folder / "vector")
    assert right.exit_code == 0, right.stdout


def test_a_team_may_build_in_python_what_we_have_in_c_only(tmp_path):
    only = parse(load("allocator").source.replace("[block]", '[block]\nflavours = ["native"]', 1))
    kit.write(only, tmp_path, "python")
    assert parse((tmp_path / "interface.toml").read_text()).flavours == ("native", "python")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "build.py"], cwd=tmp_path, env=environment, capture_output=True, check=True)
    assert validate_fmu(str(tmp_path / "allocator.fmu")) == []


def test_what_the_skeletons_say_of_an_optional_input(tmp_path):
    for language, file in (("c", "generated/allocator_bounded_ports.h"), ("python", "allocator_bounded/block.py")):
        kit.write(load("allocator_bounded"), tmp_path / language, language)
        text = (tmp_path / language / file).read_text()
        assert re.sub(r"\s+(\* )?", " ", text).count("optional; 1e9 means not connected") == 3


def test_what_a_team_has_written_is_kept(tmp_path):
    interface = load("controller")
    kit.write(interface, tmp_path, "c")
    (tmp_path / "controller.c").write_text("/* ours */")
    (tmp_path / "generated" / "table.c").write_text("/* spoilt */")
    kit.write(interface, tmp_path, "c")
    assert (tmp_path / "controller.c").read_text() == "/* ours */"
    assert "ROW(" in (tmp_path / "generated" / "table.c").read_text()


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_kit_of_another_or_of_an_edited_interface_is_not_overwritten(tmp_path):
    folder = tmp_path / "kit"
    assert orchestrate("new", "allocator", folder).exit_code == 0
    again = contents(folder)
    assert orchestrate("new", "allocator", folder).exit_code == 0
    assert contents(folder) == again, "the same interface is generated anew"
    other = orchestrate("new", "plant", folder)
    assert (other.exit_code, contents(folder)) == (2, again)
    assert other.stderr.startswith(f"{folder / 'interface.toml'}: expected the interface plant as it is written, found")
    (folder / "interface.toml").write_text((folder / "interface.toml").read_text() + "\n# ours\n")
    edited = contents(folder)
    refused = orchestrate("new", "allocator", folder)
    assert (refused.exit_code, contents(folder)) == (2, edited)
    assert f"remedy: another folder, or python -m fmus.kit {folder}" in refused.stderr


@pytest.mark.parametrize("name", ["vector/vector.csv", "vector", "generated/allocator_ports.h", "tools/pack.c"])
def test_a_folder_in_use_by_something_else_is_not_overwritten(name, tmp_path):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("ours")
    result = orchestrate("new", "allocator", tmp_path)
    assert (result.exit_code, contents(tmp_path)) == (2, {name: b"ours"})
    assert result.stderr.startswith(f"{tmp_path / name.partition('/')[0]} is there already, and no interface.toml")


@pytest.mark.parametrize("blocked", ["file/kit", "kit/vector"])
def test_a_folder_that_cannot_be_written_is_refused_in_one_line(blocked, tmp_path):
    if blocked == "kit/vector":
        assert orchestrate("new", "allocator", tmp_path / "kit").exit_code == 0
        shutil.rmtree(tmp_path / "kit" / "vector")
        (tmp_path / "kit" / "vector").write_text("a file")
        result = orchestrate("new", "allocator", tmp_path / "kit")
    else:
        (tmp_path / "file").write_text("a file")
        result = orchestrate("new", "allocator", tmp_path / "file" / "kit")
    assert result.exit_code == 4, result.stderr
    assert result.stderr.startswith(str(tmp_path / blocked).removesuffix("/vector"))
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("new", "alocator"), "there is no block 'alocator'; did you mean 'allocator'?"),
        (("new", "allocator", "--scenario", "no.yaml"), "no.yaml: there is no such file"),
        (("new", "allocator", "--scenario", "scenarios/minimal.yaml"), "minimal.yaml has no block 'allocator'"),
        (("check", "allocator.fmu", "--as", "allocator", "--vector", "docs"), "there is no FMU"),
    ],
)
def test_a_wrong_call_is_refused(arguments, message, monkeypatch):
    monkeypatch.chdir(ROOT)
    result = orchestrate(*arguments)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr
