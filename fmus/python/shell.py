"""The shell round PythonFMU's library, compiled for every platform for which PythonFMU brings one.
Tests: tests/fmus/python/test_errors.py."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..native.toolchain import PLATFORMS, shared_library

PLATFORM_ARGUMENTS = {"linux64": ["-ldl"], "win64": ["-ffreestanding", "-nostdlib", "-lkernel32"]}
"""FMI's platforms for which PythonFMU brings a library, with further arguments of the compiler."""

_HERE = Path(__file__).parent
_HEADERS = Path(__file__).parents[1] / "native" / "shell"
_WARNINGS = ["-Wno-language-extension-token", "-Wno-gnu-alignof-expression"]


def shell_sources() -> dict[str, bytes]:
    """The files of which the shell is made, for every platform, by name."""
    return {path.name: path.read_bytes() for path in [*_HERE.glob("*.c"), *_HERE.glob("*.h")]}


@cache
def compile_shell(platform: str, guid: str) -> bytes:
    """The library for one of `PLATFORM_ARGUMENTS`, with the GUID that it answers to. Raises CompilerError."""
    (target,) = PLATFORMS[platform].targets
    arguments: list[str | Path] = [
        *_WARNINGS,
        f'-DBLOCK_GUID="{guid}"',
        f"-I{_HEADERS}",
        _HERE / "shell.c",
        _HERE / ("library_windows.c" if platform == "win64" else "library_posix.c"),
        *PLATFORM_ARGUMENTS[platform],
    ]
    return shared_library(f"shell{PLATFORMS[platform].suffix}", platform, target, arguments)
