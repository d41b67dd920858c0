"""What some tests ask of the machine beyond Python and make: without it they are skipped, but fail where .ci/run has
installed it."""

from __future__ import annotations

import os
import shutil
import sys
from typing import NoReturn

import pytest

C_COMPILERS = ("gcc", "clang", "cc")


def lacking(what: str) -> NoReturn:
    """Ends a test that cannot run here: skipped, but failed where the environment variable CI is set."""
    if os.environ.get("CI"):
        pytest.fail(f"{what}; .ci/run installs it")
    pytest.skip(what)


def require(*programs: str) -> None:
    """Goes on where all these programs are there."""
    if missing := [program for program in programs if shutil.which(program) is None]:
        lacking(f"needs {', '.join(missing)}")


def require_c_compiler() -> None:
    """Goes on where a C kit can be built."""
    require("make")
    if not any(map(shutil.which, C_COMPILERS)):
        lacking("needs a C compiler")


def require_elf_tools(*programs: str) -> None:
    """Goes on where these programs read and write ELF: on Linux, where they are."""
    if sys.platform != "linux":
        pytest.skip("ELF is the format of Linux")
    require(*programs)
