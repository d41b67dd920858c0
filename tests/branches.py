"""Branch coverage of the blocks' C by gcov: `python -m tests.branches` (`make coverage`); needs gcc.

The blocks are compiled for their drivers in the tests and for fuzz.c without optimization, against the system's C
library. Then the tests and some random calls run, and gcovr prints the share of branches that were taken, and writes
out/coverage/index.html. What fmus/native/freestanding does in place of the C library is not in it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

import click
import pytest

from fmus.interface import BLOCKS
from fmus.native.toolchain import host_platform

from . import once
from .controller.planned import core
from .native import driver
from .native.fuzzer import build

ROOT = Path(__file__).parents[1]
OUT = ROOT / "out" / "coverage"
CODE = ("plant", "estimator", "controller", "allocator", "fmus/native/common", "fmus/native/shell")
TESTS = (
    *("allocator/bounded", "controller/planned", "plant/judge"),
    *(
        f"native/test_{name}.py"
        for name in ("direct", "flavours", "plant", "planned", "refusals", "shell", "thresholds")
    ),
)
"""Those that reach the blocks by their drivers."""
CALLS, SEEDS = 20000, 3
GCC = ("gcc", "-std=c11", "-O0", "-g", "--coverage", "-fprofile-update=atomic", "-fPIC", "-ffp-contract=off")


@click.group(invoke_without_command=True)
@click.pass_context
def main(ctx: click.Context) -> None:
    """Measure the branch coverage of the blocks' C."""
    if ctx.invoked_subcommand:
        return
    shutil.rmtree(OUT, ignore_errors=True)
    made = OUT / "made"
    made.mkdir(parents=True)
    again = [sys.executable, "-m", "tests.branches"]
    for command in ([*again, "fly"], *([*again, "fuzz", block] for block in BLOCKS)):
        subprocess.run(command, cwd=ROOT, check=True)
    filters = [word for folder in CODE for word in ("--filter", f"{ROOT / folder}/")]
    report = ["--txt-metric", "branch", "--txt", "-", "--json", str(OUT / "coverage.json")]
    pages = ["--html-details", str(OUT / "index.html")]
    gcovr = [sys.executable, "-m", "gcovr", "--root", str(ROOT), "--merge-mode-functions", "merge-use-line-min"]
    subprocess.run([*gcovr, *filters, *report, *pages, str(made)], cwd=ROOT, check=True)


@main.command(hidden=True)
def fly() -> None:
    """Run the tests on instrumented blocks. gcov writes its counts when this process ends."""
    once.FOLDER = OUT / "made" / "kept"
    for module in (driver, core):
        vars(module)["compile_library"] = _compile
    words = ["-q", "-p", "no:xdist", "-p", "no:cacheprovider", *(f"tests/{name}" for name in TESTS)]
    end = pytest.main(words)
    # Some compare a few bits with those of the FMUs' own compiler; what they took counts all the same.
    sys.exit(0 if end == pytest.ExitCode.TESTS_FAILED else end)


@main.command(hidden=True)
@click.argument("block")
def fuzz(block: str) -> None:
    """Call a block at random."""
    program = OUT / "made" / f"fuzz-{block}"
    build(block, GCC, program)
    for seed in range(1, 1 + SEEDS):
        subprocess.run([program, str(seed), str(CALLS)], check=True, stdout=subprocess.DEVNULL)


def _compile(
    name: str, sources: Sequence[Path], includes: Sequence[Path], platforms: Iterable[str]
) -> dict[str, bytes]:
    """Stands in for toolchain.compile_library: the library leaves its counts beside the notes of its compiler."""
    library = Path(tempfile.mkdtemp(prefix=f"{name}-", dir=OUT / "made"), "library.so")
    arguments = [*(f"-I{path}" for path in includes), "-shared", *map(str, sources), "-o", str(library), "-lm"]
    subprocess.run([*GCC, *arguments], check=True)
    return {host_platform(): library.read_bytes()}


if __name__ == "__main__":
    main(prog_name="python -m tests.branches")
