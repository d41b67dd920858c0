"""Programs of the machine that an evidence command calls, and the text of what they read.

Tests: tests/evidence/test_tools.py.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from orchestration import InputError

A = TypeVar("A")
B = TypeVar("B")
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


def side_by_side(call: Callable[[A], B], items: Iterable[A]) -> Iterator[B]:
    """The results of calls that wait for a program, two at a time, in the order of the items."""
    with ThreadPoolExecutor(2) as pool:
        yield from pool.map(call, items)


def without_comments(path: Path, but: str = "") -> str:
    """The text of a file of C; `but`: the sign that begins comments that stay, as `@` does those for Frama-C."""
    stays = f"(?!{but})" if but else ""
    return re.sub(rf"[ \t]*(?:/\*{stays}.*?\*/|//{stays}[^\n]*)", "", path.read_text("utf-8"), flags=re.DOTALL)
