"""The FMU that stands before a block in an exported loop: faults and delays of its signals, and values at given times.

One library serves any of them; resources/changes.bin has the table, which `packed` writes. Its inputs and outputs are
scalars with the block's own names, `b_B[1]`, and `b_B_given[1]` for what comes in. The C stands in this folder.

Tests: tests/fmus/test_changes.py, tests/tools/test_every_scenario.py.
"""

from __future__ import annotations

import hashlib
import math
import struct
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .. import places, telemetry
from ..contents.archive import archive
from ..contents.description import LOG_CATEGORIES, TOOL, guid_from
from ..native.toolchain import PLATFORMS

HERE = Path(__file__).parent
NAME = "changes"
CHANNELS_MAX, OPERATIONS_MAX = 512, 4096
"""As in table.h."""
_TYPES = {"real": ("Real", 0), "integer": ("Integer", 1), "enumeration": ("Enumeration", 1), "boolean": ("Boolean", 2)}
KINDS = ("replace", "add", "freeze")
"""What an operation does to a value, in the order of table.h."""


@dataclass(frozen=True)
class Operation:
    """Change of a value from an instant (s, included) to another (excluded); the later in a list on the top."""

    kind: str
    first: float
    until: float = math.inf
    value: float = 0.0
    before: bool = False
    """Whether the value belongs to the beginning of a step, else to its end."""
    at_start: bool = False
    """Whether it acts in initialization mode."""


@dataclass(frozen=True)
class Channel:
    """An element that is given to a block: from an input of the same unit where `fed`, else from the table alone."""

    name: str
    """FMI's name of the element, `b_B[1]`: that of the output."""
    type: str
    start: float
    """The output at t = 0, where it is delayed or not fed."""
    operations: tuple[Operation, ...]
    fed: bool = False
    delayed: bool = False
    """By one step."""
    given: float = 0.0
    """The input at t = 0."""
    unit: tuple[str, Mapping[str, str]] | None = None
    """Its name, and FMI's attributes of its base unit."""
    items: tuple[tuple[str, int], ...] = ()
    inner: str = field(default="", init=False)
    """FMI's name of the input."""

    def __post_init__(self) -> None:
        stem, bracket, index = self.name.partition("[")
        object.__setattr__(self, "inner", f"{stem}_given{bracket}{index}")


def packed(channels: Sequence[Channel], description: str, stop: float, step: float) -> bytes:
    """Returns the FMU, the same bytes for the same arguments. Raises CompilerError, and ValueError above the limits."""
    operations = [(number, o) for number, channel in enumerate(channels) for o in channel.operations]
    if len(channels) > CHANNELS_MAX or len(operations) > OPERATIONS_MAX:
        raise ValueError(
            f"expected at most {CHANNELS_MAX} signals with {OPERATIONS_MAX} changes before a block, found "
            f"{len(channels)} with {len(operations)}"
        )
    compiled = libraries()
    digest = hashlib.sha256(repr((channels, description, stop, step)).encode())
    for library in compiled.values():
        digest.update(library)
    guid = guid_from(digest.hexdigest())
    table = struct.pack("<8s40sII", b"CHANG1", guid.encode(), len(channels), len(operations))
    for c in channels:
        table += struct.pack("<IIIIdd", _TYPES[c.type][1], c.fed, c.delayed, 0, c.given, c.start)
    for number, o in operations:
        row = (number, KINDS.index(o.kind), o.before, o.at_start, o.first, o.until, o.value)
        table += struct.pack("<IIIIddd", *row)
    files = {f"binaries/{name}/{NAME}{PLATFORMS[name].suffix}": library for name, library in compiled.items()}
    files |= {"modelDescription.xml": _description(channels, guid, description, stop, step)}
    licence = places.shared("LICENSE")
    files |= {"documentation/licenses/license.txt": licence.read_bytes()} if licence.exists() else {}
    return archive({**files, "resources/changes.bin": table})


def libraries() -> dict[str, bytes]:
    """Returns the library by platform; it has four of telemetry's sources. Raises CompilerError."""
    return telemetry.libraries(NAME, [*sorted(HERE.glob("*.c")), *telemetry.SHARED, telemetry.HERE / "stateless.c"])


def _description(channels: Sequence[Channel], guid: str, description: str, stop: float, step: float) -> bytes:
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=NAME,
        guid=guid,
        description=description,
        license="BSD-3-Clause",
        generationTool=TOOL,
        variableNamingConvention="structured",
    )
    ET.SubElement(root, "CoSimulation", modelIdentifier=NAME, canHandleVariableCommunicationStepSize="true")
    units = dict(c.unit for c in channels if c.unit is not None)
    if units:
        definitions = ET.SubElement(root, "UnitDefinitions")
        for name, base in sorted(units.items()):
            ET.SubElement(ET.SubElement(definitions, "Unit", name=name), "BaseUnit", dict(base))
    types = {_type(c): c.items for c in channels if c.type == "enumeration"}
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for name, items in sorted(types.items()):
            entry = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")
            for item, value in items:
                ET.SubElement(entry, "Item", name=item, value=str(value))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description=LOG_CATEGORIES["logStatusError"])
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime=repr(stop), stepSize=repr(step))
    variables = ET.SubElement(root, "ModelVariables")
    indices: list[tuple[int, int]] = []
    for number, c in enumerate(channels):
        if c.fed:
            _variable(variables, c, c.inner, 2 * number, "input")
        feeding = len(variables) if c.fed and not c.delayed else 0
        _variable(variables, c, c.name, 2 * number + 1, "output")
        indices.append((len(variables), feeding))
    structure = ET.SubElement(root, "ModelStructure")
    for tag in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, tag)
        for index, feeding in indices:
            known = str(feeding) if feeding else ""
            ET.SubElement(unknowns, "Unknown", index=str(index), dependencies=known)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _type(channel: Channel) -> str:
    return f"{channel.name.partition('[')[0]}Choice"


def _variable(parent: ET.Element, channel: Channel, name: str, reference: int, causality: str) -> None:
    about = "What comes in" if causality == "input" else "What the block is given"
    attributes = {"name": name, "valueReference": str(reference), "description": about, "causality": causality}
    attributes["variability"] = "continuous" if channel.type == "real" else "discrete"
    if causality == "output":
        attributes["initial"] = "calculated"
    tag, number = _TYPES[channel.type]
    value: dict[str, str] = {}
    if channel.type == "real":
        value |= {"unit": channel.unit[0]} if channel.unit is not None else {}
    elif channel.type == "enumeration":
        value["declaredType"] = _type(channel)
    if causality == "input":
        start = channel.given
        value["start"] = (
            repr(float(start)) if number == 0 else str(int(start)) if number == 1 else str(bool(start)).lower()
        )
    ET.SubElement(ET.SubElement(parent, "ScalarVariable", attributes), tag, value)
