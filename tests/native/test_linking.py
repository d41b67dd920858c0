"""All blocks' flight code goes into one program: what a block exports carries its name, and its headers go together."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from fmus import native
from fmus.block import natives
from fmus.interface import BLOCKS as ALL
from fmus.interface import SETS, load
from fmus.native.generate import camel_case
from fmus.native.toolchain import FLAGS
from tests.blocks import folder
from tests.machine import require

BLOCKS = [block for block in ALL if block not in SETS]
"""One for a set of parts is another block's code again, with the names of that block: a program has one of the two."""
ZIG = [sys.executable, "-m", "ziglang"]
FLIGHT = [flag for flag in FLAGS if not flag.startswith("-fvisibility")]


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A static library of each block's flight code: its own C and the tables that the build writes."""
    made = tmp_path_factory.mktemp("flight")
    return {block: _archive(block, made) for block in BLOCKS}


def _archive(block: str, made: Path) -> Path:
    objects = []
    sources, _ = native.lay_out(load(block), folder(block), "{}", made)
    within = natives(folder(block))[1:]  # the C of another block, which has its own archive
    for source in (s for s in sources if s.parent != native.SHELL and s.name != "table.c"):
        if not set(within).isdisjoint(source.parents):
            continue
        objects.append(made / f"{block}.{source.stem}.o")
        includes = [f"-I{path}" for path in (native.COMMON, made, *natives(folder(block)))]
        subprocess.run([*ZIG, "cc", *FLIGHT, *includes, "-c", str(source), "-o", str(objects[-1])], check=True)
    archive = made / f"lib{block}.a"
    subprocess.run([*ZIG, "ar", "rcs", str(archive), *map(str, objects)], check=True)
    return archive


def test_headers_of_a_block_that_there_is_not_are_refused_by_name(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "fmus.native", str(tmp_path), "alocator"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, list(tmp_path.iterdir())) == (1, [])
    assert done.stderr.startswith("python -m fmus.native: there is no block 'alocator'; expected one of plant, ")


def exported(archive: Path) -> dict[str, str]:
    """Symbols with external linkage that an archive defines, with nm's letter for each."""
    require("nm")
    listed = subprocess.run(["nm", "-g", "--defined-only", str(archive)], capture_output=True, text=True, check=True)
    rows = [line.split() for line in listed.stdout.splitlines()]
    return {row[2].removeprefix("_") if sys.platform == "darwin" else row[2]: row[1] for row in rows if len(row) == 3}


@pytest.mark.parametrize("block", BLOCKS)
def test_every_exported_symbol_carries_the_blocks_name(block: str, archives: dict[str, Path]) -> None:
    symbols = exported(archives[block])
    assert {f"{block}_{f}" for f in ("check", "prepare", "start", "outputs", "step")} <= set(symbols)
    assert [name for name in symbols if not name.startswith(f"{block}_")] == []
    assert set(symbols.values()) <= {"T", "R", "D"}, "functions and constants: nothing that is written to"
    writable = {name for name, letter in symbols.items() if letter == "D"}
    assert writable <= {f"{block}_field_models"}, "tables of pointers, relocated when loaded"


def test_no_two_blocks_export_the_same_symbol(archives: dict[str, Path]) -> None:
    names = [name for archive in archives.values() for name in exported(archive)]
    assert len(names) == len(set(names))


def test_all_blocks_link_into_one_program_that_includes_all_their_headers(
    archives: dict[str, Path], tmp_path: Path
) -> None:
    includes = "\n".join(f'#include "{folder(block) / "native" / block}.h"' for block in BLOCKS)
    calls = "".join(
        f"    static {camel_case(block)}Parameters {block};\n"
        f"    refused += !{block}_check(&{block}, &fault); /* all is zero, its inertia too */\n"
        for block in BLOCKS
        if block != "plant_sensors"  # for which nothing but zeros is right
    )
    program = tmp_path / "main.c"
    made = archives[BLOCKS[0]].parent
    program.write_text(
        f"{includes}\n\nint main(void)\n{{\n    Fault fault;\n    int refused = 0;\n{calls}    return refused;\n}}\n"
    )
    whole = ["-Wl,--whole-archive", *map(str, archives.values()), "-Wl,--no-whole-archive"]
    command = [
        *ZIG,
        "cc",
        *FLIGHT,
        f"-I{native.COMMON}",
        f"-I{made}",
        f"-I{folder('controller_planned') / 'native'}",
        str(program),
        *whole,
        "-lm",
        "-o",
        str(tmp_path / "all"),
    ]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    assert subprocess.run([tmp_path / "all"], check=False).returncode == len(BLOCKS) - 1
