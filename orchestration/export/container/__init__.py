"""Writes a scenario as one FMU: the blocks' FMUs in its resources, and a library that steps them as our master does.

The library is the C of this folder around the master's own loop.c. What it needs to know of wires, values and variables
stands in resources/container.bin, so one serves every scenario, and no compiler is needed where it is ready-made. Its
steps are those of the scenario, whatever the host's step is; inside, time begins at 0.

Tests: tests/orchestration/export/test_container.py.
"""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmus import places, telemetry
from fmus.contents.archive import archive
from fmus.contents.description import guid_from
from fmus.native.toolchain import PLATFORMS, CompilerError

from ...errors import InputError
from ...fmu.archive import platforms, second
from ...results.whole import putting
from ..system import Component, System
from .description import described, identifier
from .inside import Inside
from .table import table

HERE = Path(__file__).parent
LOOP = HERE.parents[1] / "master" / "loop.c"
NAME = "container"
_KEPT = ("resources/", "documentation/licenses/")
"""What an FMU inside keeps, beside its description and its binaries for the container's platforms."""


def write(system: System, path: Path, numbers: bool = False) -> None:
    """Builds the container, the same bytes for the same system; enumerations are integers where `numbers`.

    Raises InputError where one process cannot hold it, no platform is that of all FMUs, or there is no compiler.
    """
    _check(system)
    inside = [Inside.of(i, c) for i, c in enumerate(_in_order(system))]
    try:
        compiled = _of_all(system, inside, libraries())
    except CompilerError as error:
        raise InputError(f"the container's library cannot be made: {error}") from None
    name = identifier(path.stem)
    files = {f"binaries/{p}/{name}{PLATFORMS[p].suffix}": library for p, library in compiled.items()}
    for each in inside:
        files |= _files(each, list(compiled))
    licence = places.shared("LICENSE")
    files |= {"documentation/licenses/license.txt": licence.read_bytes()} if licence.exists() else {}
    digest = hashlib.sha256()
    own = {"": described(system, inside, path.stem, "", numbers), " ": table(system, inside, "")}
    for entry, data in (files | own).items():
        digest.update(f"{entry} {len(data)}\n".encode() + data)
    guid = guid_from(digest.hexdigest())
    files["modelDescription.xml"] = described(system, inside, path.stem, guid, numbers)
    files["resources/container.bin"] = table(system, inside, guid)
    with putting(path) as part:
        part.write_bytes(archive(files))


def libraries() -> dict[str, bytes]:
    """Returns the library by platform. Raises CompilerError."""
    return telemetry.libraries(NAME, [*sorted(HERE.glob("*.c")), LOOP, *telemetry.SHARED])


def _in_order(system: System) -> list[Component]:
    components = {component.name: component for component in system.components}
    return [components[name] for name in system.order]


def _check(system: System) -> None:
    if pair := second({component.name: component.fmu for component in system.components}):
        message = (
            f"its FMU, which is that of {pair[0]}, too, can have one instance in a process "
            "(canBeInstantiatedOnlyOncePerProcess), "
            "and a container has all in one; cannot be exported"
        )
        raise InputError(system.scenario.error(("blocks", pair[1], "fmu"), message))


def _of_all(system: System, inside: Sequence[Inside], compiled: Mapping[str, bytes]) -> dict[str, bytes]:
    """The libraries for the platforms of all FMUs inside. Raises InputError where there is none."""
    left = dict(compiled)
    for each in inside:
        names = each.names
        here = {p for p in left if f"binaries/{p}/{each.identifier}{PLATFORMS[p].suffix}" in names}
        if not here:
            key, found = ("blocks", each.component.name, "fmu"), ", ".join(platforms(names)) or "none"
            message = f"it has binaries for {found}; a container needs one for a platform of all its FMUs"
            raise InputError(system.scenario.error(key, f"{message}, here one of {', '.join(left)}"))
        left = {p: library for p, library in left.items() if p in here}
    return left


def _files(each: Inside, chosen: Sequence[str]) -> dict[str, bytes]:
    """Returns what the container has of an FMU."""
    kept = (*_KEPT, *(f"binaries/{platform}/" for platform in chosen))
    with zipfile.ZipFile(each.component.fmu.path) as source:
        return {
            f"resources/{each.folder}/{name}": source.read(name)
            for name in source.namelist()
            if not name.endswith("/") and (name.startswith(kept) or name == "modelDescription.xml")
        }
