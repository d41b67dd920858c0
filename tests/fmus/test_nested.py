"""A block inside another's folder, `toy_small` in `toy/small`: each is made of its own files, under its own name."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from fmus import build as module
from fmus.build import Block, BuildError, blocks_of, build, ensure
from fmus.fingerprint import data_packages, fingerprint
from fmus.interface import BLOCKS, InterfaceError, load, parse
from fmus.kit.fill import filled
from fmus.native.generate import ports_header

from .host import Host
from .toy import toy

SMALL = """
[block]
name = "toy_small"
description = "A small block in the folder of another"

[experiment]
stop = 1.0
step = 0.1

[variables.rate]
causality = "input"
unit = "m/s"
description = "Something"
start = 1.0

[variables.applied]
causality = "input"
optional = true
shape = [3]
unit = ["A.m2", "A.m2", "N.m"]
description = "What two rods and a wheel gave"
start = [1e9, 1e9, 1e9]

[variables.mode]
causality = "parameter"
variability = "fixed"
type = "enumeration"
items = ["one", "two"]
description = "A choice"
start = "two"

[variables.sum]
causality = "output"
unit = "m"
description = "Nothing yet"
"""
TABLES = """
PACKAGES = ("pint",)
def generated():
    import {package}.native.tables as this
    assert this.generated is generated
    return {{"numbers.c": "extern const int numbers[1];\\nconst int numbers[1] = {{1}};\\n"}}
"""


@pytest.fixture
def blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Block, Block]:
    """The toy, and a block in its folder of both flavours; its functions do what a new kit's do."""
    outer = toy(tmp_path)
    folder = outer.folder / "small"
    small = parse(SMALL, "toy_small.toml")
    native = folder / "native"
    native.mkdir(parents=True)
    (folder / "__init__.py").write_text(
        "from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step\n"
    )
    (folder / "block.py").write_text(filled("block.py.template", small))
    for name, text in (
        ("toy_small.h", filled("block.h.template", small)),
        ("toy_small.c", filled("block.c.template", small)),
    ):
        (native / name).write_text(text)
    (native / "tables.py").write_text(TABLES.format(package="toy.small"))
    monkeypatch.syspath_prepend(tmp_path)
    return outer, Block(small, folder)


@pytest.mark.parametrize("flavour", ["native", "python"])
def test_it_builds_in_both_flavours_with_its_own_name_and_runs(
    flavour: str, blocks: tuple[Block, Block], tmp_path: Path
) -> None:
    path = build([blocks[1]], flavour, tmp_path / "out")["toy_small"]
    assert path.name == "toy_small.fmu"
    assert validate_fmu(str(path)) == []
    with Host(path) as host:
        host.started(rate=2.0).step(0)
        assert host.get("sum") == 0.0


def test_the_outer_block_neither_carries_nor_depends_on_it(blocks: tuple[Block, Block], tmp_path: Path) -> None:
    outer, small = blocks
    path = ensure(outer, "python", tmp_path / "out")
    first = path.stat().st_mtime_ns
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    assert any(name.endswith("/toy/helper.py") for name in names)
    assert not [name for name in names if "small" in name]
    before = fingerprint(small, "native")
    (small.folder / "block.py").write_text("# changed\n")
    assert fingerprint(small, "native") != before
    assert ensure(outer, "python", tmp_path / "out").stat().st_mtime_ns == first


def test_names_in_c_are_of_both_parts(blocks: tuple[Block, Block]) -> None:
    header = ports_header(blocks[1].interface)["toy_small_ports.h"]
    assert "} ToySmallInputs;" in header
    assert "TOY_SMALL_MODE_ONE = 1" in header
    assert "/* A.m2, A.m2, N.m; What two rods" in header


def test_the_packages_behind_the_tables_of_its_c_count_for_its_fingerprint(blocks: tuple[Block, Block]) -> None:
    assert data_packages(blocks[1].folder) == ["pint"]


def test_units_are_those_of_each_element(blocks: tuple[Block, Block], tmp_path: Path) -> None:
    description = fmpy.read_model_description(str(build([blocks[1]], "native", tmp_path)["toy_small"]))
    units = {v.name: (v.unit, v.declaredType.unit) for v in description.modelVariables if v.name.startswith("applied")}
    assert units == {"applied[1]": ("A.m2",) * 2, "applied[2]": ("A.m2",) * 2, "applied[3]": ("N.m",) * 2}
    assert {"A.m2", "N.m"} <= {unit.name for unit in description.unitDefinitions}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'unit = ["A.m2", "A.m2", "N.m"]',
            'unit = ["A.m2", "N.m"]',
            r"variables.applied: unit: expected the shape \[3\], found \['A.m2', 'N.m'\]",
        ),
        ('unit = "m"\n', 'unit = ["m"]\n', "variables.sum: unit: expected one value, since there is no shape"),
        ('"N.m"]', '"N.m"]\ndisplay_unit = "mN.m"', "units of their own has no display_unit"),
        ("start = [1e9, 1e9, 1e9]", "start = [1e9, 0.0, 1e9]", r"optional, and its start is 1e\+09 in every element"),
        (
            'unit = "m"\n',
            'unit = "m"\noptional = true\n',
            "variables.sum: only a real or integer input may be optional",
        ),
        (
            'name = "toy_small"',
            'name = "toy_small"\nflavours = ["c"]',
            r"block.flavours: expected a list of native, python, found \['c'\]",
        ),
    ],
)
def test_an_error_in_an_interface_is_named(old: str, new: str, message: str) -> None:
    with pytest.raises(InterfaceError, match=message):
        parse(SMALL.replace(old, new))


def test_a_block_of_one_flavour_is_left_out_of_the_other_and_refused_there_by_name(
    blocks: tuple[Block, Block], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    only = Block(
        parse(SMALL.replace('name = "toy_small"', 'name = "toy_small"\nflavours = ["native"]')), blocks[1].folder
    )
    for call in (build, lambda chosen, *rest: ensure(chosen[0], *rest)):
        with pytest.raises(BuildError, match="toy_small has no flavour 'python'; expected native"):
            call([only], "python", tmp_path)
    monkeypatch.setattr(module, "BLOCKS", (*BLOCKS, "toy_small"))
    monkeypatch.setattr(module, "load", lambda name: only.interface if name == "toy_small" else load(name))
    assert set(blocks_of("native")) - set(blocks_of("python")) >= {"toy_small"}
