"""C of this package as a library of this machine: ready-made in a wheel, or compiled where it is missing or out of
date."""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from collections.abc import Sequence
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
    parts = source, *headers, _NATIVE / "toolchain.py"
    digest = hashlib.sha256(b"\n".join(path.read_bytes() for path in parts)).hexdigest()[:16]
    folder = places.work() / name
    path = folder / f"{platform.system()}-{platform.machine()}-{digest}"
    if not path.exists():
        from fmus.native import toolchain  # here, since it takes 15 ms and is seldom needed  # noqa: PLC0415

        host = toolchain.host_platform()
        data = toolchain.compile_library(name, [source], [header.parent for header in headers], [host])[host]
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
            file.write(data)
        os.replace(file.name, path)
    return path
