"""The FMU of a record: a library that plays rows back, the rows as a resource, and the description of its ports.

pack(path, [Port("omega_B_measured", (3,), "rad/s", "...")], rows, stop=600.0, step=1.0, guid=guid)

The native flavour only: the library knows no port, so one serves every record, and no compiler is needed where it is
ready-made. Tests: tests/orchestration/telemetry/test_pack.py.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import struct
import tempfile
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import places
from ..contents.archive import common
from ..contents.description import Capabilities, model_description
from ..interface import Interface, parse
from ..native import SHELL
from ..native.toolchain import FLAGS, PLATFORMS, compile_library, compiler

HERE = Path(__file__).parent
SHARED = tuple(HERE / f"{name}.c" for name in ("host", "record_file", "remaining"))
"""What other FMUs of one library and a table in their resources have of these sources."""
NAME = "telemetry"
PORTS_MAX, VALUES_MAX = 512, 4096
"""As in telemetry.c."""
_CAPABILITIES = Capabilities(
    needsExecutionTool=False,
    canNotUseMemoryManagementFunctions=False,
    canGetAndSetFMUstate=False,
    canSerializeFMUstate=False,
)
_HOST = "Nothing: the library is compiled from C for Linux, Windows and macOS (64 bits); the record is a resource."
_OWN = (
    ("hold", "parameter", "real", "s", "How long a sample stays valid; with 0 it is valid in the step that brings it"),
    ("shift", "parameter", "real", "s", "Added to the time of every row"),
    ("rows", "output", "integer", "", "Number of rows up to now"),
    ("age", "output", "real", "s", "Time since the last row"),
    ("ended", "output", "boolean", "", "Whether the last row has passed"),
)


class Port(NamedTuple):
    """An output of the next values of a row, with its unit as FMI has it; a scalar has the shape ()."""

    name: str
    shape: tuple[int, ...]
    unit: str
    description: str

    @property
    def size(self) -> int:
        """Number of its values."""
        return math.prod(self.shape)


def interface(ports: Sequence[Port], stop: float, step: float, description: str) -> Interface:
    """Returns the interface of a record's FMU; its value references are those of telemetry.c."""
    lines = [f'[block]\nname = "{NAME}"\ndescription = {json.dumps(description)}']
    lines.append(f"[experiment]\nstop = {stop!r}\nstep = {step!r}")

    def add(name: str, causality: str, kind: str, unit: str, about: str, shape: tuple[int, ...] = ()) -> None:
        lines.append(f'[variables.{name}]\ncausality = "{causality}"\ntype = "{kind}"')
        lines.append(f"description = {json.dumps(about)}")
        lines.extend([f"unit = {json.dumps(unit)}"] * bool(unit) + [f"shape = {list(shape)}"] * bool(shape))
        lines.extend(['variability = "fixed"\nstart = 0.0'] * (causality == "parameter"))

    for row in _OWN:
        add(*row)
    for name, shape, unit, about in ports:
        add(name, "output", "real", unit, about, shape)
        add(f"{name}_valid", "output", "boolean", "", f"Whether {name} has a sample now, or one no older than hold")
        add(f"{name}_sample", "output", "integer", "", f"Number of the last sample of {name}, from 1")
    return parse("\n".join(lines), "telemetry")


def pack(
    path: Path,
    ports: Sequence[Port],
    rows: Iterable[NDArray[np.float64]],
    *,
    stop: float,
    step: float,
    guid: str,
    description: str,
) -> None:
    """Writes the FMU. `rows` are blocks (n, 1 + values) of time, s, and values, NaN where one is missing; they stream.

    Raises CompilerError and OSError.
    """
    about = interface(ports, stop, step, description)
    files = {
        "modelDescription.xml": model_description(about, guid, _CAPABILITIES, f"attitude-cosim, {compiler()}"),
        **common(about, HERE, places.shared("LICENSE"), _HOST),
    }
    for platform, library in libraries().items():
        files[f"binaries/{platform}/{NAME}{PLATFORMS[platform].suffix}"] = library
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        count, record, sizes = 0, Path(folder, "telemetry.bin"), [port.size for port in ports]
        head = struct.Struct("<8s40sIIQ")
        with record.open("w+b") as file:
            file.write(bytes(head.size) + struct.pack(f"<{len(sizes)}I", *sizes))
            for block in rows:
                file.write(np.ascontiguousarray(block, "<f8").tobytes())
                count += len(block)
            file.seek(0)
            file.write(head.pack(b"TELEM1", guid.encode(), len(sizes), sum(sizes), count))
        fmu = Path(folder, path.name)
        with zipfile.ZipFile(fmu, "w") as archive:
            for name, data in files.items():
                archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
            archive.write(record, "resources/telemetry.bin")
        os.replace(fmu, path)


def libraries(name: str = NAME, sources: Sequence[Path] = tuple(sorted(HERE.glob("*.c")))) -> dict[str, bytes]:
    """Returns a library by platform: ready-made, or compiled where missing or out of date. Raises CompilerError."""
    headers = list(dict.fromkeys([path.parent for path in sources] + [SHELL]))
    mine = [path for folder in headers[:-1] for path in sorted(folder.glob("*.h"))]
    texts = [path.read_bytes() for path in (*sources, *mine, SHELL / "fmi2.h")]
    folder = places.ready(name)
    if folder is None:
        digest = hashlib.sha256(b"\n".join([*texts, f"{compiler()}{FLAGS}{PLATFORMS}".encode()])).hexdigest()[:16]
        folder = places.work() / name / digest
        if not folder.exists():
            made = compile_library(name, sources, headers, PLATFORMS, hosted=True)
            folder.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder.parent) as new:
                for platform, library in made.items():
                    Path(new, platform).write_bytes(library)
                Path(new).chmod(0o755)
                if not folder.exists():  # else another process has been quicker
                    os.rename(new, folder)
                    Path(new).mkdir()
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
