"""The XML documents of an unpacked SSP archive, each held against its schema of SSP 1.0.

One of SSP 2.0 is held against that, too: what 2.0 has added (arrays, types of FMI 3.0) is refused by it.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import fmpy
from lxml import etree

from ..errors import InputError, Place, naming
from ..fmu.zipped import shown, xml_root
from .words import NAMESPACES

_SCHEMAS = {
    "ssd:SystemStructureDescription": "SystemStructureDescription",
    "ssv:ParameterSet": "SystemStructureParameterValues",
    "ssm:ParameterMapping": "SystemStructureParameterMapping",
}
SIZE_MAX = 16_000_000
"""Bytes of a document."""


def inside(path: Path, folder: Path, source: str) -> Path:
    """A file of the archive by its relative URI. Raises InputError."""
    try:
        file = (folder / unquote(source)).resolve()
        if file.is_relative_to(folder.resolve()) and file.is_file():
            return file
    except (OSError, ValueError):  # a name that no file can have
        pass
    raise InputError(f"{shown(path)} refers to {source!r}, which it does not hold")


def parsed(path: Path, file: Path, tag: str) -> Any:
    """The root of a document that begins with this tag. Raises InputError."""
    size = file.stat().st_size
    if size > SIZE_MAX:
        raise InputError(
            f"{shown(path)}: {file.name} holds {size / 1e6:.3g} MB; expected at most {SIZE_MAX / 1e6:.3g} MB"
        )
    with naming(Place(str(shown(path)))):
        root = xml_root(file.read_bytes(), file.name)
    prefix, _, name = tag.partition(":")
    if root.tag != f"{{{NAMESPACES[prefix]}}}{name}":
        raise InputError(f"{shown(path)}: {file.name} is no {name} of SSP 1.0: it begins with {root.tag}")
    check(path, file.name, root, tag)
    return root


def check(path: Path, where: str, root: Any, tag: str) -> None:
    """Holds an element against the schema of its kind. Raises InputError."""
    schema = _schema(_SCHEMAS[tag])
    newer = [
        entry for entry in root.iter("{*}" + tag.partition(":")[2], "{*}ParameterSet") if entry.get("version") == "2.0"
    ]
    for entry in newer:
        entry.set("version", "1.0")
    valid = schema.validate(root)
    for entry in newer:
        entry.set("version", "2.0")
    if not valid:
        some = [f"  line {e.line}: {' '.join(e.message.split())}" for e in list(schema.error_log)[:5]]
        also = ", and what SSP 2.0 has added is not read" if newer else ""
        raise InputError("\n".join([f"{shown(path)}: {where} is not valid by the schema of SSP 1.0{also}:", *some]))


@cache
def _schema(name: str) -> Any:
    return etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "ssp" / "schema" / f"{name}.xsd"))
