"""Writes a scenario as an SSP archive: SystemStructure.ssd, and in resources/ the FMUs and their parameter sets.

What SSP has no words for (step, rates, what is expected ...) goes into an annotation, which ssp/reader.py understands.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from ..quantities import Unit
from ..results.whole import putting
from ..ssp.annotation import BLOCK_KEYS, KEYS
from ..ssp.words import ANNOTATION, NAMESPACES, OPENMODELICA, OPENMODELICA_ANNOTATION, PARAMETER_SET, STRUCTURE
from .system import Component, System, Value

_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String", "enumeration": "Enumeration"}
VERSIONS = ("1.0", "2.0")
"""Of SSP, that can be written."""
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class Style:
    """Form in which an archive is written."""

    version: str = "1.0"
    """Of SSP: 1.0 or 2.0. The documents of 2.0 have nothing that 1.0 lacks."""
    numbers: bool = False
    """Whether enumerations are whole numbers: several tools know no items."""


def write(system: System, path: Path, style: Style = Style()) -> None:
    """Writes the archive. The same system gives the same bytes, but for FMUs that differ."""
    files = {STRUCTURE: _structure(system, style)}
    for component in system.components:
        files[_resource(system, component)] = component.content(style.numbers)
        if component.values:
            files[f"resources/{component.name}.ssv"] = parameter_set(component.values, style)
    with putting(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            info = zipfile.ZipInfo(name, _DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o100644 << 16
            archive.writestr(info, data)


def _resource(system: System, component: Component) -> str:
    """Components of one FMU share its file, which has the first one's name."""
    first = next(c for c in system.components if (c.fmu.path, c.fed) == (component.fmu.path, component.fed))
    return f"resources/{first.name}.fmu"


def _structure(system: System, style: Style) -> bytes:
    scenario = system.scenario
    root = _element(None, "ssd:SystemStructureDescription", version=style.version, name=scenario.name)
    if scenario.description:
        root.set("description", scenario.description)
    root.set("generationTool", "orchestrate")
    top = _element(root, "ssd:System", name=scenario.name)
    elements = _element(top, "ssd:Elements")
    for name in system.order:  # the order of the steps, for a host that takes that of the elements
        component = next(c for c in system.components if c.name == name)
        _component(elements, component, _resource(system, component), style)
    if system.wires:
        connections = _element(top, "ssd:Connections")
        for wire in system.wires:
            ends = {"startElement": wire.source[0], "startConnector": wire.source[1]}
            ends |= {"endElement": wire.target[0], "endConnector": wire.target[1]}
            connection = _element(connections, "ssd:Connection", ends)
            if (wire.factor, wire.offset) != (1.0, 0.0):
                # Said in full, so that a tool that knows no units converts too, and one that does, not twice.
                connection.set("suppressUnitConversion", "true")
                _element(connection, "ssc:LinearTransformation", factor=repr(wire.factor), offset=repr(wire.offset))
    _annotations(top, system)
    ports = [port for component in system.components for port in component.ports]
    if not style.numbers:
        _enumerations(root, "ssd", ((port.variable.name, port.variable.items) for port in ports))
    _units(root, "ssd", (port.variable.unit for port in ports))
    _element(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(float(scenario.duration)))
    return xml_bytes(root)


def _annotations(top: ET.Element, system: System) -> None:
    """OpenModelica's first: OMSimulator takes the first one of the system for its own, and none at the root.

    Its command reads the element FixedStepMaster, its Python classes the attributes.
    """
    annotations = _element(top, "ssd:Annotations")
    entry = _element(annotations, "ssc:Annotation", type=OPENMODELICA_ANNOTATION)
    step = repr(float(system.scenario.step))
    simulation = ET.SubElement(
        ET.SubElement(entry, f"{{{OPENMODELICA}}}Annotations"),
        f"{{{OPENMODELICA}}}SimulationInformation",
        {"name": "steps", "method": "oms_ma", "fixedStepSize": step},
    )
    tolerances = {"absoluteTolerance": "1e-4", "relativeTolerance": "1e-4"}
    ET.SubElement(
        simulation, f"{{{OPENMODELICA}}}FixedStepMaster", {"description": "oms-ma", "stepSize": step, **tolerances}
    )
    ours = _element(annotations, "ssc:Annotation", type=ANNOTATION)
    ET.SubElement(ours, "scenario").text = json.dumps(_rest(system), ensure_ascii=False)


def _rest(system: System) -> dict[str, Any]:
    """Returns what the scenario says beyond components, connections and values."""
    data = {k: v for k, v in system.scenario.source.data.items() if k in KEYS}
    if system.delays is not None:  # faults, values and other delays are FMUs
        data = {k: v for k, v in data.items() if k not in ("faults", "delays", "timeline")}
        phases = [{k: v for k, v in e.items() if k != "set"} for e in system.scenario.source.data.get("timeline") or ()]
        data |= {"delays": list(system.delays)} if system.delays else {}
        data |= {"timeline": kept} if (kept := [entry for entry in phases if "phase" in entry]) else {}
    given = system.scenario.source.data["blocks"]
    blocks = {name: {k: v for k, v in entry.items() if k in BLOCK_KEYS} for name, entry in given.items()}
    return data | {"blocks": {name: entry for name, entry in blocks.items() if entry}}


def _component(parent: ET.Element, component: Component, source: str, style: Style) -> None:
    attributes = {"name": component.name, "type": "application/x-fmu-sharedlibrary", "source": source}
    entry = _element(parent, "ssd:Component", attributes, implementation="CoSimulation")
    if component.ports:
        connectors = _element(entry, "ssd:Connectors")
        for port in component.ports:
            connector = _element(connectors, "ssd:Connector", name=port.name, kind=port.kind)
            tag = _tag(port.variable.type, style)
            kind = _element(connector, f"ssc:{tag}")
            if port.variable.type == "real" and port.variable.unit is not None:
                kind.set("unit", port.variable.unit.name)
            if tag == "Enumeration":
                kind.set("name", port.variable.name)
    if component.values:
        bindings = _element(entry, "ssd:ParameterBindings")
        attributes = {"type": "application/x-ssp-parameter-set", "source": f"resources/{component.name}.ssv"}
        _element(bindings, "ssd:ParameterBinding", attributes)


def _tag(kind: str, style: Style) -> str:
    return "Integer" if kind == "enumeration" and style.numbers else _TAGS[kind]


def parameter_set(values: Sequence[Value], style: Style = Style()) -> bytes:
    """Returns the document of start values."""
    root = _element(None, "ssv:ParameterSet", version=style.version, name=PARAMETER_SET)
    parameters = _element(root, "ssv:Parameters")
    for value in values:
        tag = _tag(value.variable.type, style)
        parameter = _element(parameters, "ssv:Parameter", name=value.name)
        entry = _element(parameter, f"ssv:{tag}", value=_text(value, tag))
        if tag == "Real" and value.variable.unit is not None:
            entry.set("unit", value.variable.unit.name)
        if tag == "Enumeration":
            entry.set("name", value.variable.name)
    variables = [value.variable for value in values]
    if not style.numbers:
        _enumerations(root, "ssv", ((variable.name, variable.items) for variable in variables))
    _units(root, "ssv", (variable.unit for variable in variables))
    return xml_bytes(root)


def _text(value: Value, tag: str) -> str:
    if tag == "Enumeration":
        return next(name for name, number in value.variable.items if number == value.value)
    if isinstance(value.value, bool):
        return str(value.value).lower()
    return str(value.value)


def _enumerations(
    root: ET.Element, prefix: str, enumerations: Iterable[tuple[str, tuple[tuple[str, int], ...]]]
) -> None:
    known = {name: items for name, items in enumerations if items}
    if known:
        parent = _element(root, f"{prefix}:Enumerations")
        for name, items in sorted(known.items()):
            entry = _element(parent, "ssc:Enumeration", name=name)
            for item, number in items:
                _element(entry, "ssc:Item", name=item, value=str(number))


def _units(root: ET.Element, prefix: str, units: Iterable[Unit | None]) -> None:
    known = {unit.name: unit for unit in units if unit is not None}
    if known:
        parent = _element(root, f"{prefix}:Units")
        for name, unit in sorted(known.items()):
            _element(_element(parent, "ssc:Unit", name=name), "ssc:BaseUnit", unit.base_unit)


def _element(
    parent: ET.Element | None, tag: str, given: dict[str, str] | None = None, /, **attributes: str
) -> ET.Element:
    prefix, _, tag = tag.partition(":")
    full = f"{{{NAMESPACES[prefix]}}}{tag}"
    all_attributes = {**(given or {}), **attributes}
    return ET.Element(full, all_attributes) if parent is None else ET.SubElement(parent, full, all_attributes)


def xml_bytes(root: ET.Element) -> bytes:
    """Returns the document of this root, indented, which is done in place."""
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
