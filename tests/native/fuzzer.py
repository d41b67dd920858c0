"""fuzz.c with a block and the FMI shell, built under sanitizers."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from fmus import native
from fmus.interface import load
from tests.blocks import folder
from tests.machine import C_COMPILERS
from tests.once import built

from .driver import GUID

FUZZ = Path(__file__).with_name("fuzz.c")
SYSTEM = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer")
ZIG = ("-fsanitize=undefined", "-fno-sanitize-trap=undefined", "-fno-sanitize-recover=all")


def compiler(kind: str) -> list[str] | None:
    """The command of the compiler `zig` or `system` with its sanitizers; None where the system has no compiler."""
    if kind == "zig":
        return [sys.executable, "-m", "ziglang", "cc", *ZIG]
    name = next((c for c in C_COMPILERS if shutil.which(c)), None)
    return [name, *SYSTEM] if name else None


def build(block: str, command: Sequence[str], path: Path) -> None:
    """Compiles the program `fuzz SEED CALLS` of a block."""
    with tempfile.TemporaryDirectory() as generated:
        sources, includes = native.lay_out(load(block), folder(block), GUID, Path(generated))
        arguments = [*(f"-I{folder}" for folder in includes), *map(str, sources), str(FUZZ), "-o", str(path), "-lm"]
        built = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
        assert built.returncode == 0, built.stderr


def fuzzer(block: str, compiler: Sequence[str]) -> Path:
    """The program, kept from one run to the next."""
    command = [*compiler, "-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]
    with tempfile.TemporaryDirectory() as generated:
        sources, includes = native.lay_out(load(block), folder(block), GUID, Path(generated))
        made_of = [version("ziglang"), *command, *sources, *includes, FUZZ]
        return built("fuzz", made_of, lambda path: build(block, command, path))
