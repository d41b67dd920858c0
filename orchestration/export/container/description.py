"""The modelDescription.xml of a container: what its FMUs say of their variables, by the names `block.variable`.

Offered are all outputs, and the parameters and inputs to which nothing is connected; a wire is the local variable
`wire.block.output`, too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from fmus.contents.description import LOG_CATEGORIES, TOOL

from ..system import System
from .inside import Inside

_OWN_INDICES = ("derivative", "reinit")
"""Attributes that mean other variables of the same FMU, or model exchange."""


@dataclass(frozen=True)
class Exposed:
    """A variable of the container, whose value reference is its place in the list."""

    name: str
    of: Inside | None
    """None for the time."""
    inner: str = ""
    """FMI's name in that FMU."""
    settable: bool = False
    local: bool = False


def exposed(system: System, inside: Sequence[Inside]) -> list[Exposed]:
    """Returns the variables in their order."""
    by_name = {each.name: each for each in inside}
    sources = dict.fromkeys(wire.source for wire in system.wires)
    found = [Exposed("time", None)]
    found += [Exposed(f"wire.{block}.{name}", by_name[block], name, local=True) for block, name in sources]
    found += [Exposed(f"{i.name}.{p.name}", i, p.name, settable=True) for i in inside for p in i.component.free]
    outputs = ((i, p) for i in inside for p in i.component.ports if p.kind == "output")
    return found + [Exposed(f"{i.name}.{p.name}", i, p.name) for i, p in outputs]


def identifier(stem: str) -> str:
    """Returns a name of C for the library of a file of this name."""
    return re.sub(r"^(?=\d)|\W", "_", stem, flags=re.ASCII) or "_"


def described(system: System, inside: Sequence[Inside], name: str, guid: str, numbers: bool) -> bytes:
    """Returns the document; enumerations are integers where `numbers`."""
    scenario = system.scenario
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=guid,
        description=scenario.description or f"{scenario.name}: {', '.join(system.order)}",
        license="That of each FMU inside, see resources",
        generationTool=TOOL,
        variableNamingConvention="structured",
    )
    flags = {"modelIdentifier": identifier(name), "canHandleVariableCommunicationStepSize": "true"}
    for flag, all_ in (
        ("needsExecutionTool", any),
        ("canBeInstantiatedOnlyOncePerProcess", any),
        ("canGetAndSetFMUstate", all),
        ("canSerializeFMUstate", all),
    ):
        flags[flag] = str(all_(each.says(flag) for each in inside)).lower()
    ET.SubElement(root, "CoSimulation", flags)
    shared = _Shared()
    variables = ET.Element("ModelVariables")
    listed = exposed(system, inside)
    for reference, about in enumerate(listed):
        variables.append(_time(reference) if about.of is None else _scalar(reference, about, shared, numbers))
    root.extend(shared.lists())
    categories = ET.SubElement(root, "LogCategories")
    for category, about_it in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=category, description=about_it)
    times = {"startTime": "0.0", "stopTime": repr(float(scenario.duration)), "stepSize": repr(float(scenario.step))}
    ET.SubElement(root, "DefaultExperiment", times)
    root.append(variables)
    root.append(_structure(listed, variables))
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _time(reference: int) -> ET.Element:
    entry = ET.Element("ScalarVariable", name="time", valueReference=str(reference), causality="independent")
    entry.set("variability", "continuous")
    ET.SubElement(entry, "Real")
    return entry


def _scalar(reference: int, about: Exposed, shared: _Shared, numbers: bool) -> ET.Element:
    """The FMU's own element, with the names, types and units of the container and the scenario's start value."""
    assert about.of is not None
    entry = deepcopy(about.of.scalars[about.inner])
    entry.attrib.pop("canHandleMultipleSetPerTimeInstant", None)
    entry.attrib |= {"name": about.name, "valueReference": str(reference)}
    kind = next(each for each in entry if each.tag == about.of.type(about.inner).tag)
    for attribute in _OWN_INDICES:
        kind.attrib.pop(attribute, None)
    if about.local:
        entry.attrib |= {"causality": "local", "initial": "calculated"}
        kind.attrib.pop("start", None)
    value = next((v.value for v in about.of.component.values if v.name == about.inner and about.settable), None)
    if value is not None:
        kind.set("start", str(value).lower() if isinstance(value, bool) else str(value))
    if numbers and kind.tag == "Enumeration":
        kind.tag = "Integer"
        kind.attrib.pop("declaredType", None)
    shared.take(about.of, kind)
    return entry


class _Shared:
    """Units and types of all FMUs, which get a name of their own where two of one name differ."""

    def __init__(self) -> None:
        self._units: dict[str, ET.Element] = {}
        self._types: dict[str, ET.Element] = {}

    def take(self, of: Inside, kind: ET.Element) -> None:
        """Takes up what the type of a variable refers to, and refers to it by its name here."""
        name = kind.get("declaredType")
        declared = of.root.find(f"TypeDefinitions/SimpleType[@name='{name}']") if name else None
        if declared is not None:
            declared = deepcopy(declared)
            for inner in declared:
                self._unit(of, inner)
            kind.set("declaredType", _added(self._types, of, declared))
        self._unit(of, kind)

    def _unit(self, of: Inside, kind: ET.Element) -> None:
        name = kind.get("unit")
        unit = next((u for u in of.root.iterfind("UnitDefinitions/Unit") if u.get("name") == name), None)
        if unit is not None:
            kind.set("unit", _added(self._units, of, deepcopy(unit)))

    def lists(self) -> Iterator[ET.Element]:
        """The lists of units and of types, where there are some."""
        for tag, known in (("UnitDefinitions", self._units), ("TypeDefinitions", self._types)):
            if known:
                element = ET.Element(tag)
                element.extend(known[name] for name in sorted(known))
                yield element


def _added(known: dict[str, ET.Element], of: Inside, element: ET.Element) -> str:
    """Adds a definition. Returns its name."""
    name = element.get("name", "")
    if name in known and _text(known[name]) != _text(element):
        name = f"{name} ({of.name})"
        element.set("name", name)
    known.setdefault(name, element)
    return name


def _text(element: ET.Element) -> tuple[object, ...]:
    return element.tag, sorted(element.attrib.items()), [_text(child) for child in element]


def _structure(listed: Sequence[Exposed], variables: ET.Element) -> ET.Element:
    """Between two steps an output depends on the free inputs of its own FMU; in initialization on all there is."""
    structure = ET.Element("ModelStructure")
    outputs, initial = ET.SubElement(structure, "Outputs"), ET.Element("InitialUnknowns")
    free = [
        (index, about)
        for index, (about, entry) in enumerate(zip(listed, variables, strict=True), 1)
        if entry.get("causality") == "input"
    ]
    for index, (about, entry) in enumerate(zip(listed, variables, strict=True), 1):
        if entry.get("causality") == "output" and about.of is not None:
            feeding = about.of.feeding(about.inner) if any(a.of is about.of for _, a in free) else set()
            known = [i for i, a in free if a.of is about.of and a.inner in feeding]
            ET.SubElement(outputs, "Unknown", index=str(index), dependencies=" ".join(map(str, known)))
            if entry.get("initial") != "exact":
                ET.SubElement(initial, "Unknown", index=str(index))
    structure.extend([initial] if len(initial) else [])
    if not len(outputs):
        structure.remove(outputs)
    return structure
