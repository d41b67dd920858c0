"""The libraries of a Python FMU: PythonFMU's own, and the shell round each, compiled by zig for every platform it has."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

SOURCES = (Path(__file__).with_name("shell.c"), Path(__file__).parent / "native" / "shell" / "fmi2.h")
PLATFORMS = {
    "linux64": ("x86_64-linux-gnu.2.17", ".so", ["-ldl", "-Wl,--build-id=none"]),
    "win64": ("x86_64-windows-gnu", ".dll", ["-ffreestanding", "-nostdlib", "-lkernel32"]),
}
"""FMI's platforms for which PythonFMU brings a library: zig's target, the library's suffix, further arguments."""

_FLAGS = ["-std=c11", "-O2", "-g0", "-fPIC", "-shared", "-s", "-fvisibility=hidden", "-fno-stack-protector"]
_FLAGS += [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wshadow",
    "-Wno-language-extension-token",
    "-Wno-gnu-alignof-expression",
    "-Werror",
]


class CompilerError(RuntimeError):
    """The shell could not be compiled; the message has the compiler's words."""


def compiler_version() -> str:
    """The version of zig, which has a say in a library's bytes."""
    return version("ziglang")


@cache
def compile_shell(platform: str, guid: str) -> bytes:
    """The shell's library for one of `PLATFORMS`, with the GUID that it answers to."""
    target, suffix, arguments = PLATFORMS[platform]
    if find_spec("ziglang") is None:
        raise CompilerError("building an FMU needs the compiler of the package ziglang: pip install ziglang")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "shell" + suffix)
        command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *_FLAGS, f'-DBLOCK_GUID="{guid}"']
        command += ["-I", str(SOURCES[1].parent), "-o", str(library), SOURCES[0].name, *arguments]
        run = subprocess.run(command, cwd=SOURCES[0].parent, capture_output=True, text=True, check=False)
        if run.returncode:
            raise CompilerError(f"zig cannot compile {SOURCES[0].name} for {platform}:\n{run.stderr}")
        return library.read_bytes()
