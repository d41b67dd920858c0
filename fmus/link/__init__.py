"""The link FMU: a block's ports, and a device at the end of a line behind them.

ensure(load("controller"))                      # the path of controller_link.fmu, built where it is out of date
package(load("controller"), platforms="host")   # its bytes, for this machine only
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

from .. import places
from ..contents.archive import archive, common
from ..contents.description import Capabilities, guid_from, model_description
from ..interface import Interface, parse
from ..native import COMMON, SHELL
from ..native.generate import camel_case, identity, table
from ..native.guard import headers
from ..native.toolchain import FLAGS, PLATFORMS, compile_library, compiler, host_platform
from . import wire

HERE = Path(__file__).parent
NATIVE, FIRMWARE = HERE / "native", HERE / "firmware"
"""The C of the FMU's end of the line, and that of the device."""

CAPABILITIES = Capabilities(
    needsExecutionTool=False,
    canNotUseMemoryManagementFunctions=False,
    canGetAndSetFMUstate=False,
    canSerializeFMUstate=False,
)
_HOST = (
    "A device that answers: a board on a cable, or a program. link_transport and link_address say where it is. "
    "The library is compiled from C for Linux, Windows and macOS (64 bits) and uses the system's sockets, serial "
    "lines and "
    "pipes only. The device's memory is out of reach, so the FMU's state cannot be saved."
)
_FUNCTIONS = ("check", "prepare", "start", "outputs", "step", "release")


def linked(interface: Interface) -> Interface:
    """The interface of the link FMU: that of the block, with the parameters and outputs of the link beside."""
    source = re.sub(r'(?m)^name = ".*"$', f'name = "{interface.name}_link"', interface.source, count=1)
    source = re.sub(
        r'(?m)^description = "(.*)"$', r'description = "A device at the end of a line: \1"', source, count=1
    )
    source = re.sub(r"(?m)^flavours *=.*\n", "", source)
    return parse(source + "\n" + (HERE / "link.toml").read_text("utf-8"), f"{interface.name}.toml")


def ensure(interface: Interface) -> Path:
    """The path of an interface's link FMU for all platforms, which is built first where it is missing or its sources
    have changed.

    Raises CompilerError, InterfaceError.
    """
    path = places.work() / "fmus" / "link" / f"{interface.name}_link.fmu"
    if not (path.exists() and guid_from(_digest(linked(interface))) == _guid_of(path)):
        data = package(interface)
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(data)
        os.chmod(file.name, 0o644)
        os.replace(file.name, path)
    return path


def _guid_of(path: Path) -> str | None:
    """The GUID in an FMU's description; None where there is no FMU to be read."""
    try:
        with zipfile.ZipFile(path) as there:
            found = re.search(rb'guid="([^"]*)"', there.read("modelDescription.xml"))
    except (OSError, KeyError, zipfile.BadZipFile):
        return None
    return found[1].decode() if found else None


def package(interface: Interface, platforms: str | Sequence[str] = tuple(PLATFORMS)) -> bytes:
    """The link FMU of an interface. The same sources give the same bytes.

    `platforms` are FMI's names, or "host" for this machine's. Raises CompilerError, InterfaceError.
    """
    chosen = [host_platform()] if platforms == "host" else [platforms] if isinstance(platforms, str) else platforms
    whole = linked(interface)
    guid = guid_from(_digest(whole))
    files = {
        "modelDescription.xml": model_description(whole, guid, CAPABILITIES, f"attitude-cosim, {compiler()}"),
        **common(whole, NATIVE, places.shared("LICENSE"), _HOST),
    }
    with tempfile.TemporaryDirectory() as folder:
        sources, includes = lay_out(interface, guid, Path(folder))
        libraries = compile_library(whole.name, sources, includes, chosen, hosted=True)
    for name, library in libraries.items():
        files[f"binaries/{name}/{whole.name}{PLATFORMS[name].suffix}"] = library
    return archive(files)


def lay_out(interface: Interface, guid: str, generated_into: Path) -> tuple[list[Path], list[Path]]:
    """Writes the generated files; returns the C sources and the folders of headers, ready for a compiler."""
    whole = linked(interface)
    for name, text in {
        **headers(whole),
        "block.h": _block_header(whole, guid),
        "table.c": table(whole),
        "wire.h": wire.header(interface),
        "wire.c": wire.source(interface),
    }.items():
        (generated_into / name).write_text(text, "utf-8", newline="\n")
    return [*sources(), generated_into / "table.c", generated_into / "wire.c"], [NATIVE, SHELL, COMMON, generated_into]


def sources() -> list[Path]:
    """The C of every link FMU: the FMI shell, with the link's own functions in the place of those that save states."""
    return [*sorted(p for p in SHELL.glob("*.c") if p.name != "state.c"), *sorted(NATIVE.glob("*.c"))]


def _block_header(interface: Interface, guid: str) -> str:
    """block.h: what the shell needs of a block, which is the same for each interface but for its structures."""
    records = "\n".join(f"typedef {camel_case(interface.code)}{name} {name};" for name in wire.RECORDS.values())
    calls = "\n".join(f"#define block_{name} link_{name}" for name in _FUNCTIONS)
    calls += f"\n#define block_guard {interface.code}_guard\n#define block_state_used(x) sizeof(State)"
    return f"""\
#ifndef BLOCK_H
#define BLOCK_H

#include "fault.h"
#include "{interface.code}_guard.h"

{identity(interface, guid)}

{records}
typedef struct LinkState State;
typedef struct LinkLaw Law;

{calls}

#include "link_block.h"

#endif
"""


def _digest(interface: Interface) -> str:
    digest = hashlib.sha256(f"{compiler()}\n{FLAGS}\n{PLATFORMS}\n{CAPABILITIES}\n{interface.source}".encode())
    for path in [*sources(), *sorted(NATIVE.glob("*.h")), *sorted(SHELL.glob("*.h")), *sorted(COMMON.glob("*.h"))]:
        data = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"\n{path.name} {len(data)}\n".encode() + data)
    return digest.hexdigest()
