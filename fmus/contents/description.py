"""modelDescription.xml of a block, derived from its interface; flavours differ in their capabilities only."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..interface import Element, Interface, Variable, optional_text
from ..units import display_factor, parse_unit

LOG_CATEGORIES = {
    "logStatusWarning": "Messages with the status fmi2Warning",
    "logStatusError": "Messages with the status fmi2Error, which are sent even with logging off",
    "logStatusFatal": "Messages with the status fmi2Fatal, which are sent even with logging off",
    "logAll": "All messages",
}
TOOL = "attitude-cosim"
"""The tool that our annotations name, of optional inputs and of quantities: FMI 2.0 has no attributes for them."""
FRAME_N = "N is the mean equator and equinox of date"
"""In the description of each port with components in N: read as GCRS, positions and field would be wrong."""
TOLERANCE = "1e-06"
"""Of the default experiment: steps are of fixed orders, so no block changes them by it; tools ask for one."""
DIMENSIONLESS = "1"
"""The unit of every Real without one, so that a master can tell dimensionless from not declared."""

_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String", "enumeration": "Enumeration"}


@dataclass(frozen=True)
class Capabilities:
    """The capabilities of a flavour's FMU, by the names of FMI's attributes."""

    needsExecutionTool: bool
    canHandleVariableCommunicationStepSize: bool = True
    canInterpolateInputs: bool = False
    canRunAsynchronuously: bool = False
    canBeInstantiatedOnlyOncePerProcess: bool = False
    canNotUseMemoryManagementFunctions: bool = True
    canGetAndSetFMUstate: bool = True
    canSerializeFMUstate: bool = True
    providesDirectionalDerivative: bool = False


def model_description(
    interface: Interface,
    guid: str,
    capabilities: Capabilities,
    generation_tool: str,
    remark: str = "",
    sources: Sequence[str] = (),
    origin: Mapping[str, str] | None = None,
) -> bytes:
    """The XML file; `remark` follows the description, `sources` are the C files that the FMU carries, `origin` has
    author, version, copyright and date. No date of the build stands in it, so the same arguments give the same bytes.
    Raises QuantityError."""
    head = {"fmiVersion": "2.0", "modelName": interface.name, "guid": guid, "license": "BSD-3-Clause"}
    head["description"] = f"{interface.description}. {remark}" if remark else interface.description
    head |= {"generationTool": generation_tool, "variableNamingConvention": "structured"}
    root = ET.Element("fmiModelDescription", head | dict(origin or {}))
    flags = {name: text_of(value) for name, value in vars(capabilities).items()}
    kind = ET.SubElement(root, "CoSimulation", {"modelIdentifier": interface.name, **flags})
    if sources:
        files = ET.SubElement(kind, "SourceFiles")
        for name in sources:
            ET.SubElement(files, "File", name=name)
    unit_definitions(root, shown_units(interface))
    _type_definitions(root, interface)
    categories = ET.SubElement(root, "LogCategories")
    for name, about in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=about)
    times = {"startTime": "0.0", "stopTime": text_of(interface.stop), "stepSize": text_of(interface.step)}
    ET.SubElement(root, "DefaultExperiment", times | {"tolerance": TOLERANCE})
    variables = ET.SubElement(root, "ModelVariables")
    for variable in interface.variables.values():
        for position, element in enumerate(variable.elements):
            _scalar_variable(variables, variable, position, element)
    _model_structure(root, interface)
    return xml_bytes(root)


def xml_bytes(root: ET.Element) -> bytes:
    """A file of an FMU, indented."""
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def guid_from(digest: str) -> str:
    """A GUID in the usual form from at least 32 hexadecimal digits."""
    return "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"


def about(variable: Variable, position: int | None = None) -> str:
    """The description with the frame of its components, and which value means that an optional input is not
    connected; of an element at its end which it is: `[x]`."""
    more = [f"frame: {variable.frame}"] if variable.frame else []
    if variable.frame and "N" in variable.frame.split():
        more.append(FRAME_N)
    if variable.optional:
        more.append(optional_text(variable))
    whole = f"{variable.description} ({'; '.join(more)})" if more else variable.description
    axes = "" if position is None else axes_of(variable, position)
    return f"{whole} [{axes}]" if axes else whole


def axes_of(variable: Variable, position: int) -> str:
    """In words which element of a vector or matrix stands at a position: `x`, `row x, column y`, `rod 1`, `wheel 2, z`,
    `scalar` of a quaternion. Nothing where its components are of no axes."""
    shape, words = variable.shape, []
    if variable.each is not None and len(shape) > 0 and shape[0] != 3:
        size = len(variable.elements) // shape[0]
        words.append(f"{variable.each} {position // size + 1}")
        shape, position = shape[1:], position % size
    frame = variable.frame or ""
    if frame == "rods" and shape == (3,):
        words.append(f"rod {position + 1}")
    elif frame and shape == (3,):
        words.append("xyz"[position])
    elif " from " in frame and shape == (4,):
        words.append(("scalar", "x", "y", "z")[position])
    elif frame and shape == (3, 3):
        words.append(f"row {'xyz'[position // 3]}, column {'xyz'[position % 3]}")
    return ", ".join(words)


def sizes(variable: Variable, position: int) -> dict[str, str]:
    """The attributes min, max and nominal of an element, where it has them, as either version of FMI names them."""
    whole = {"min": variable.min, "max": variable.max}
    found = {key: float(v) if variable.type == "real" else int(v) for key, v in whole.items() if v is not None}
    if (nominal := variable.nominals[position]) is not None:
        found["nominal"] = nominal
    return {key: text_of(value) for key, value in found.items()}


def add_items(parent: ET.Element, variable: Variable) -> None:
    """Adds the items of an enumeration, each with its words in the description of the variable: `'item': ...`."""
    for value, item in enumerate(variable.items, start=1):
        entry = ET.SubElement(parent, "Item", name=item, value=str(value))
        if found := re.search(rf"'{re.escape(item)}': (.+?)(?:; '|$)", variable.description):
            entry.set("description", found[1])


def shown_units(interface: Interface) -> dict[str, set[str]]:
    """The units of an interface, each with those in which it is shown."""
    shown: dict[str, set[str]] = {}
    for variable in interface.variables.values():
        for name in map(_unit_name, variable.units if variable.type == "real" else ()):
            shown.setdefault(name, set()).update({variable.display_unit} - {None})  # type: ignore[arg-type]
    return shown


def unit_definitions(root: ET.Element, shown: Mapping[str, set[str]]) -> None:
    """Adds UnitDefinitions of units, each with those in which it is shown."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted(shown):
        entry = ET.SubElement(definitions, "Unit", name=name)
        unit = parse_unit(name)
        ET.SubElement(entry, "BaseUnit", unit.base_unit)
        for display in sorted(shown[name]):
            factor = display_factor(unit, parse_unit(display))
            ET.SubElement(entry, "DisplayUnit", name=display, factor=text_of(factor))


def _type_definitions(root: ET.Element, interface: Interface) -> None:
    types: dict[str, tuple[Variable, int]] = {}
    for variable in interface.variables.values():
        if variable.type in ("real", "enumeration"):
            for position in range(len(variable.elements)):
                types.setdefault(type_name(variable, position), (variable, position))
    definitions = ET.SubElement(root, "TypeDefinitions")
    for name, (variable, position) in sorted(types.items()):
        entry = ET.SubElement(definitions, "SimpleType", name=name)
        if variable.type == "real":
            ET.SubElement(entry, "Real", _unit_attributes(variable, position))
            continue
        add_items(ET.SubElement(entry, "Enumeration"), variable)


def type_name(variable: Variable, position: int = 0) -> str:
    """The type of an element: an enumeration's has its variable's name in capitals (`GainSchedule`), a Real's its
    units' (`rad shown in deg`)."""
    if variable.type == "enumeration":
        return "".join(part[:1].upper() + part[1:] for part in variable.name.split("_")) + "Choice"
    name = _unit_name(variable.units[position])
    return f"{name} shown in {variable.display_unit}" if variable.display_unit else f"{name}"


def _scalar_variable(parent: ET.Element, variable: Variable, position: int, element: Element) -> None:
    attributes = {
        "name": element.name,
        "valueReference": str(element.value_reference),
        "description": about(variable, position),
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality != "input":
        attributes["initial"] = "calculated" if variable.causality == "output" else "exact"
    entry = ET.SubElement(parent, "ScalarVariable", attributes)
    kind: dict[str, str] = {}
    if variable.type in ("real", "enumeration"):
        kind["declaredType"] = type_name(variable, position)
    if variable.type == "real":
        kind |= _unit_attributes(variable, position)
    kind |= sizes(variable, position)
    if element.start is not None:
        kind["start"] = text_of(float(element.start) if variable.type == "real" else element.start)
    ET.SubElement(entry, _TAGS[variable.type], kind)
    if variable.optional or variable.quantity:
        tool = ET.SubElement(ET.SubElement(entry, "Annotations"), "Tool", name=TOOL)
        if variable.optional:
            ET.SubElement(tool, "Optional")
        if variable.quantity:
            ET.SubElement(tool, "Quantity", name=variable.quantity)


def _model_structure(root: ET.Element, interface: Interface) -> None:
    """Outputs with their direct feedthrough, and what each output's initial value depends on."""
    index = {element.value_reference: i for i, (_, element) in enumerate(interface.elements.values(), start=1)}
    structure = ET.SubElement(root, "ModelStructure")
    for tag, resolve in (("Outputs", interface.feedthrough), ("InitialUnknowns", interface.initial_dependencies)):
        unknowns = ET.SubElement(structure, tag)
        for variable in interface.of("output"):
            for position, element in enumerate(variable.elements):
                known = sorted({index[e.value_reference] for e in resolve(variable, position)})
                ET.SubElement(
                    unknowns,
                    "Unknown",
                    index=str(index[element.value_reference]),
                    dependencies=" ".join(map(str, known)),
                    dependenciesKind=" ".join(["dependent"] * len(known)),
                )


def _unit_name(unit: str | None) -> str:
    return unit or DIMENSIONLESS


def _unit_attributes(variable: Variable, position: int) -> dict[str, str]:
    display = {"displayUnit": variable.display_unit} if variable.display_unit else {}
    return {"unit": _unit_name(variable.units[position]), **display}


def text_of(value: float | int | bool | str) -> str:
    """As XML has it."""
    return str(value).lower() if isinstance(value, bool) else str(value)
