"""A kit for a device: the link FMU of a block, a firmware skeleton in C or a device in Python, and a bench that plays
vectors at it.

write(load("controller"), Path("controller_device"), "c") Tests: tests/fmus/kit/test_device_kit.py.
"""

from __future__ import annotations

from pathlib import Path
from pprint import pformat
from typing import NamedTuple

from .. import link, native
from ..interface import Interface, Variable
from ..link import wire
from ..native import COMMON
from ..native.generate import TEXT_SIZE, camel_case
from ..native.guard import headers
from . import for_teams, own, put, refuse_other
from .fill import filled

PARTS = ("firmware", "link", "ports.py", "bench.py")
"""Beside those of any kit, what `write` overwrites."""


def write(interface: Interface, folder: Path, language: str) -> list[Path]:
    """Writes the project and returns its files; those of the team that are there already are kept.

    Raises InUse, CompilerError, InterfaceError.
    """
    refuse_other(interface, folder, *PARTS)
    interface = for_teams(interface)
    name = interface.name
    fmu = link.ensure(interface)
    files: dict[str, bytes | str] = {"interface.toml": interface.source, fmu.name: fmu.read_bytes()}
    kept: dict[str, bytes | str] = {"README.md": filled(f"README.device.{language}.md", interface)}
    for part in ("__init__", "device", "lines", "bench"):
        files[f"link/{part}.py"] = (link.HERE / f"{part}.py").read_bytes() if part != "__init__" else ""
    files["ports.py"] = python_ports(interface)
    files["bench.py"] = filled("bench.py.template", interface)
    if language == "c":
        files |= {f"firmware/{path.name}": path.read_bytes() for path in firmware()}
        files |= {f"generated/{key}": text for key, text in generated(interface).items()}
        kept["Makefile"] = filled("Makefile.device.template", interface)
        kept |= {f"{name}.{kind}": filled(f"device.{kind}.template", interface) for kind in "hc"}
    else:
        kept[f"{name}_device.py"] = filled("device.py.template", interface)
    files |= {key: data for key, data in kept.items() if not (folder / key).exists()}
    return [put(folder / key, data) for key, data in files.items()]


def is_of_device(folder: Path) -> bool:
    """Returns whether a folder holds a kit for a device."""
    return (folder / "link" / "device.py").is_file()


def regenerate(folder: Path) -> list[Path]:
    """Writes what is generated anew from the folder's interface.toml, the link FMU too. Raises
    CompilerError, InterfaceError."""
    interface = own((folder / "interface.toml").read_text("utf-8"), str(folder / "interface.toml"))
    return write(interface, folder, "c" if (folder / "firmware").is_dir() else "python")


def firmware() -> list[Path]:
    """The C of every device: the protocol, and boards."""
    paths = [p for p in sorted(link.FIRMWARE.iterdir()) if p.suffix in (".c", ".h", ".ld") and p.name != "of_block.c"]
    return [*paths, link.NATIVE / "frame.c", link.NATIVE / "frame.h", COMMON / "fault.h"]


def generated(interface: Interface, of_block: bool = False) -> dict[str, str]:
    """Returns the C that a device needs of the interface. `of_block`: for a block that is written for the
    FMI shell, with of_block.c."""
    name, title = interface.code, camel_case(interface.code)
    types = [*wire.RECORDS.values(), *(("State", "Law") if of_block else ("Memory",))]
    parts = [f"typedef {title}{kind} {kind};" for kind in types]
    if of_block:
        parts += [f"#define block_{call} {name}_{call}" for call in ("check", "prepare", "start", "outputs", "step")]
        parts.append(
            "typedef struct {\n    Parameters p;\n    Law law;\n    State state;\n    char why[96];\n} Memory;"
        )
        call = "block_sample(const Parameters *p, Memory *memory, const Inputs *u, double t, double h, Outputs *y)"
        parts.append(f"const char *{call};")
    else:
        parts.append(f"#define block_sample {name}_sample")
    body = "\n".join(parts)
    return {
        **headers(interface, "interface.toml"),
        "block.h": (
            f'#ifndef BLOCK_H\n#define BLOCK_H\n\n#include "{name}.h"\n\n#include <stddef.h>\n\n{body}\n\n#endif\n'
        ),
        "wire.h": wire.header(interface),
        "wire.c": wire.source(interface),
    }


class Sources(NamedTuple):
    """The C of a native block as a device, without a board."""

    flight: list[Path]
    """Of the block alone."""
    line: list[Path]
    """The link's."""
    headers: list[Path]
    """Folders."""


def lay_out(interface: Interface, block: Path, folder: Path) -> Sources:
    """Writes what is generated for the block in the folder `block` into `folder`."""
    own, headers = native.lay_out(interface, block, "{0}", folder)
    for name, text in generated(interface, of_block=True).items():
        put(folder / name, text)
    flight = [path for path in own if path.parent != native.SHELL and path.name != "table.c"]
    line = [folder / "wire.c", link.FIRMWARE / "of_block.c", link.FIRMWARE / "device.c", link.NATIVE / "frame.c"]
    return Sources(flight, line, [p for p in headers if p != native.SHELL] + [link.FIRMWARE, link.NATIVE])


def python_ports(interface: Interface) -> str:
    """ports.py: the variables on the line, in Python."""
    parts = [
        f'"""The interface {interface.name} on the line. Generated from interface.toml; do not edit."""\n# fmt: off\n',
        "from link.device import Field, Ports\n",
        f"PORTS = Ports(\n    name={interface.name!r},\n    "
        f"hash=bytes.fromhex({wire.interface_hash(interface).hex()!r}),",
    ]
    for causality in wire.RECORDS:
        fields = "".join(f"        {_field(v)},\n" for v in interface.of(causality))
        parts.append(f"    {causality}s=(\n{fields}    ),")
    return "\n".join(parts) + "\n)\n"


def _field(variable: Variable) -> str:
    start = variable.start
    if variable.type == "enumeration":
        start = variable.elements[0].start
    size = TEXT_SIZE if variable.type == "string" else 0
    return f"Field({variable.name!r}, {variable.type!r}, {variable.shape!r}, {pformat(start, width=1000)}, {size})"
