"""C of this package as a library of this machine: ready-made in a wheel, or compiled where it is missing or out of
date."""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from fmus import places

from ..fmu.platforms import PLATFORM, SUFFIX

_NATIVE = Path(places.__file__).with_name("native")
FMI_HEADERS = _NATIVE / "shell"
"""Where fmi2.h is."""


def compiled(name: str, source: Path, headers: Sequence[Path]) -> Path:
    """Returns the library of a source that includes these headers.

    Raises RuntimeError without a compiler, OSError where there is no folder to write to.
    """
    if ready := places.ready(f"loop/{'' if name == 'loop' else name + '-'}{PLATFORM}{SUFFIX}"):
        return ready

    def make(path: Path) -> None:
        from fmus.native import toolchain  # here, since it takes 15 ms and is seldom needed  # noqa: PLC0415

        host = toolchain.host_platform()
        folders = [header.parent for header in headers]
        path.write_bytes(toolchain.compile_library(name, [source], folders, [host])[host])

    return kept(name, [source, *headers, _NATIVE / "toolchain.py"], make)


def kept(name: str, parts: Sequence[Path], make: Callable[[Path], None], suffix: str = "") -> Path:
    """Returns the file that `make` writes to the path it is given; it is made where it is missing or older than its
    parts. Raises OSError where there is no folder to write to, and what `make` raises.
    """
    digest = hashlib.sha256(b"\n".join(path.read_bytes() for path in parts)).hexdigest()[:16]
    path = places.work() / name / f"{platform.system()}-{platform.machine()}-{digest}{suffix}"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            made = Path(folder, name + suffix)
            make(made)
            os.replace(made, path)
    return path
