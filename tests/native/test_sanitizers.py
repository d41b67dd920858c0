"""Thousands of random FMI calls, right and wrong, under sanitizers: no crash, no undefined behaviour, no leak."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from fmus import native
from fmus.interface import BLOCKS, load
from tests.blocks import folder
from tests.kept import kept

from .driver import GUID

SYSTEM = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]
ZIG = ["-fsanitize=undefined", "-fno-sanitize-trap=undefined", "-fno-sanitize-recover=all"]


def _compiler(kind: str) -> list[str]:
    if kind == "zig":
        return [sys.executable, "-m", "ziglang", "cc", *ZIG]
    found = next((c for c in ("gcc", "clang", "cc") if shutil.which(c)), None)
    if found is None:
        reason = "the address sanitizer needs a system compiler (gcc or clang)"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return [found, *SYSTEM]


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("kind", ["zig", "system"])
def test_random_calls_under_sanitizers(block: str, kind: str, tmp_path: Path) -> None:
    sources, includes = native.lay_out(load(block), folder(block), GUID, tmp_path)
    fuzz = Path(__file__).with_name("fuzz.c")
    compiler = _compiler(kind)
    command = [*compiler, "-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]

    def make(path: Path) -> None:
        arguments = [*(f"-I{folder}" for folder in includes), *map(str, sources), str(fuzz), "-o", str(path), "-lm"]
        built = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
        assert built.returncode == 0, built.stderr

    program = kept("fuzz", [version("ziglang"), *command, *sources, *includes, fuzz], make)
    seeds = 2 if block == "controller_planned" else 5  # a plan takes a thousand times as long as a law
    for seed in range(1, 1 + seeds):
        run = subprocess.run([program, str(seed), "20000"], capture_output=True, text=True, check=False)
        assert run.returncode == 0, f"seed {seed}: {run.stdout}{run.stderr}"
        refusals, steps = (int(word) for word in run.stdout.split() if word.isdigit())
        assert refusals > 1000
        assert steps > 100
