"""A kit for another team: a small project that builds at once into a valid FMU with a block's exact interface.

    write(load("allocator"), Path("my_allocator"), "c")       # needs a C compiler and make from then on
    write(load("allocator"), Path("my_allocator"), "python")  # needs this project's packages to build

Files that the team fills in are never overwritten; what is generated from the interface is.
`python -m fmus.kit FOLDER` generates anew from the folder's interface.toml.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from .. import places
from ..contents.description import Capabilities, guid_from, model_description
from ..interface import Interface, parse
from ..native import COMMON, SHELL
from ..native.generate import block_header, table
from ..native.guard import headers
from .fill import by_default, filled

SCENARIO = places.shared("scenarios") / "paper_singularity.yaml"
"""The run of which the test vector is a part, if no other is asked for."""

_HERE = Path(__file__).parent
_TOOL = "attitude-cosim, kit"


class InUse(ValueError):
    """The folder holds something other than a kit of this interface."""


def refuse_other(interface: Interface, folder: Path, *more: str) -> None:
    """Raises InUse where `write`, or what writes `more` beside it, would overwrite what is not of a kit
    of this interface."""
    there, remedy = folder / "interface.toml", "remedy: another folder"
    if there.exists():
        if there.read_bytes().replace(b"\r\n", b"\n") != for_teams(interface).source.encode():
            found = (
                f"found a different or edited one; {remedy}, or python -m fmus.kit {folder} to generate from that one"
            )
            raise InUse(f"{there}: expected the interface {interface.name} as it is written, {found}")
        return
    for name in ("fmi_shell", "generated", "tools", *more):
        if (folder / name).exists():
            raise InUse(f"{folder / name} is there already, and no interface.toml says that it is of a kit; {remedy}")


def for_teams(interface: Interface) -> Interface:
    """The interface without `flavours`: a team may build in Python what we have in C only."""
    return own(re.sub(r"(?m)^flavours *=.*\n", "", interface.source), f"{interface.name}.toml")


def own(text: str, file: str) -> Interface:
    """The interface of a block with code of its own: the project's block for a set shares that of one part."""
    interface = parse(text, file)
    return replace(interface, code=interface.name)


def write(
    interface: Interface,
    folder: Path,
    language: str,
    law: bytes | None = None,
    left_out: Mapping[str, float | str] | None = None,
) -> list[Path]:
    """Writes the project and returns its files; those of the team that are there already are kept. Raises InUse.

    `law` is the text of a law in Python, which the block then has in the place of one to be filled in; `left_out` has
    what an output is that it leaves out: an input's name, or a number. Others are zero.
    """
    refuse_other(interface, folder)
    interface = for_teams(interface)
    files: dict[str, bytes | str] = {"interface.toml": interface.source}
    kept = {"README.md": filled(f"README.{language}.md", interface)}
    if language == "c":
        files |= {f"generated/{name}": text for name, text in generated(interface).items()}
        files |= {f"tools/{name}": (_HERE / name).read_bytes() for name in ("pack.c", "vector.c")}
        files |= {f"fmi_shell/{name}": data for name, data in shell().items()}
        files["fmi_shell/LICENSE"] = places.shared("LICENSE").read_bytes()
        kept["Makefile"] = makefile(interface, "fmi_shell", "fmi_shell/common", "tools")
        kept |= {f"{interface.name}.{kind}": filled(f"block.{kind}.template", interface) for kind in "hc"}
    else:
        kept["build.py"] = filled("build.py.template", interface)
        kept[f"{interface.name}/__init__.py"] = filled("package.py.template", interface)
        kept[f"{interface.name}/block.py"] = filled(
            f"{'law_' if law else ''}block.py.template", interface, left_out=by_default(interface, left_out or {})
        )
        if law:
            files[f"{interface.name}/law.py"] = law
    for name, data in kept.items():
        if not (folder / name).exists():
            files[name] = data
    return [put(folder / name, data) for name, data in files.items()]


def generated(interface: Interface) -> dict[str, str]:
    """Returns the files that are made from the interface: the XML, and the C that the shell includes."""
    guid = guid_from(hashlib.sha256(f"{_TOOL}\n{interface.source}".encode()).hexdigest())
    capabilities = Capabilities(needsExecutionTool=False, canNotUseMemoryManagementFunctions=False)
    header = "/* Generated from interface.toml; do not edit. */\n"
    return {
        "modelDescription.xml": model_description(interface, guid, capabilities, _TOOL).decode(),
        **headers(interface, "interface.toml"),
        "block.h": header + block_header(interface, guid),
        "table.c": header + table(interface),
    }


def shell() -> dict[str, bytes]:
    """The FMI shell: what every native FMU has in common."""
    folders = {SHELL: "", COMMON: "common/"}
    paths = [path for folder in folders for path in sorted(folder.glob("*.[ch]"))]
    return {f"{folders[path.parent]}{path.name}": path.read_bytes() for path in paths}


def makefile(interface: Interface, shell_folder: str, common: str, tools: str) -> str:
    """The Makefile, with the folders of the shell, its common headers and the tools."""
    return filled("Makefile.template", interface, shell=shell_folder, common=common, tools=tools)


def put(path: Path, data: bytes | str) -> Path:
    """Writes a file of a kit, with the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def regenerate(folder: Path) -> list[Path]:
    """Writes `generated/` anew from the folder's interface.toml."""
    interface = own((folder / "interface.toml").read_text("utf-8"), str(folder / "interface.toml"))
    return [put(folder / "generated" / name, text) for name, text in generated(interface).items()]
