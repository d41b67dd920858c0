"""Whether this machine can compile what another team writes in C."""

from __future__ import annotations

import shutil


def has_compiler() -> bool:
    """Whether a C kit can be built here."""
    return shutil.which("make") is not None and any(shutil.which(cc) for cc in ("cc", "gcc", "clang"))
