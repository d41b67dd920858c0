"""Programs of the machine that an evidence command calls.

Tests: tests/evidence/test_tools.py.
"""

from __future__ import annotations

import shutil

from orchestration import InputError

PACKAGES = {
    "frama-c": "frama-c-base",
    "why3": "why3",
    "z3": "z3",
    "cppcheck": "cppcheck",
    "clang-tidy": "clang-tidy",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi",
    "arm-none-eabi-nm": "binutils-arm-none-eabi",
    "arm-none-eabi-size": "binutils-arm-none-eabi",
    "qemu-system-arm": "qemu-system-arm",
}
"""Debian's package of each."""


def tool(name: str) -> str:
    """The program's path. Raises InputError with how to get it."""
    path = shutil.which(name)
    if path is None:
        raise InputError(
            f"{name} is not installed; remedy: apt install {PACKAGES[name]}, or your system's package of it"
        )
    return path
