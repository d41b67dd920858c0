"""modelDescription.xml of a block for FMI 3.0, and buildDescription.xml, from the same interface as for FMI 2.0.

A variable is an array as a whole, under the value reference that its first element has in FMI 2.0. One whose elements
differ in their units, which FMI 3.0 has no place for, is as many scalars. Tests: tests/native/test_fmi3.py.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from ..interface import Element, Interface, Variable
from .description import (
    DIMENSIONLESS,
    LOG_CATEGORIES,
    TOLERANCE,
    TOOL,
    Capabilities,
    about,
    add_items,
    shown_units,
    sizes,
    text_of,
    type_name,
    unit_definitions,
    xml_bytes,
)

_TAGS = {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "string": "String", "enumeration": "Enumeration"}


def parts(variable: Variable) -> list[tuple[Element, ...]]:
    """The elements of each array that the variable is in FMI 3.0."""
    whole = len(set(variable.units)) == 1 or variable.type != "real"
    return [variable.elements] if whole else [(element,) for element in variable.elements]


def names_3(variable: Variable) -> list[str]:
    """The names of these arrays."""
    arrays = parts(variable)
    return [variable.name] if len(arrays) == 1 else [elements[0].name for elements in arrays]


def model_description_3(
    interface: Interface, token: str, capabilities: Capabilities, generation_tool: str, origin: Mapping[str, str]
) -> bytes:
    """The XML file, whose bytes depend on the arguments only. Raises QuantityError."""
    head = {"fmiVersion": "3.0", "modelName": interface.name, "instantiationToken": token, "license": "BSD-3-Clause"}
    head |= {"description": interface.description, "generationTool": generation_tool}
    root = ET.Element("fmiModelDescription", head | {"variableNamingConvention": "structured"} | dict(origin))
    flags = {
        "needsExecutionTool": capabilities.needsExecutionTool,
        "canBeInstantiatedOnlyOncePerProcess": capabilities.canBeInstantiatedOnlyOncePerProcess,
        "canGetAndSetFMUState": capabilities.canGetAndSetFMUstate,
        "canSerializeFMUState": capabilities.canSerializeFMUstate,
        "canHandleVariableCommunicationStepSize": capabilities.canHandleVariableCommunicationStepSize,
    }
    if interface.derivatives:
        flags |= {"providesDirectionalDerivatives": True, "providesAdjointDerivatives": True}
    kind = {"modelIdentifier": interface.name} | {name: text_of(value) for name, value in flags.items()}
    ET.SubElement(root, "CoSimulation", kind)
    unit_definitions(root, {"s": set(), **shown_units(interface)})  # s is that of time
    _types(root, interface)
    categories = ET.SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=meaning.replace("fmi2", "fmi3"))
    stop, step = text_of(interface.stop), text_of(interface.step)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime=stop, stepSize=step, tolerance=TOLERANCE)
    variables = ET.SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": str(len(interface.elements)), "causality": "independent"}
    ET.SubElement(variables, "Float64", time | {"variability": "continuous", "unit": "s"})
    for variable in interface.variables.values():
        for elements in parts(variable):
            _variable(variables, variable, elements)
    _structure(root, interface)
    return xml_bytes(root)


def build_description(interface: Interface, sources: list[str]) -> bytes:
    """buildDescription.xml: how to compile the C files in sources/."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=interface.name)
    language = "C++20" if any(name.endswith(".cpp") for name in sources) else "C11"
    files = ET.SubElement(configuration, "SourceFileSet", language=language)
    for name in sources:
        ET.SubElement(files, "SourceFile", name=name)
    return xml_bytes(root)


def _types(root: ET.Element, interface: Interface) -> None:
    chosen = {type_name(v): v for v in interface.variables.values() if v.type == "enumeration"}
    definitions = ET.SubElement(root, "TypeDefinitions") if chosen else root
    for name, variable in sorted(chosen.items()):
        entry = ET.SubElement(definitions, "EnumerationType", name=name)
        add_items(entry, variable)


def _variable(parent: ET.Element, variable: Variable, elements: tuple[Element, ...]) -> None:
    whole = len(elements) == len(variable.elements)
    attributes = {
        "name": variable.name if whole else elements[0].name,
        "valueReference": str(elements[0].value_reference),
        "description": about(variable, None if whole else variable.elements.index(elements[0])),
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality == "parameter":
        attributes["initial"] = "exact"
    if variable.causality == "output":
        attributes["initial"] = "calculated"
    if variable.type == "enumeration":
        attributes["declaredType"] = type_name(variable)
    if variable.type == "real":
        attributes["unit"] = variable.units[variable.elements.index(elements[0])] or DIMENSIONLESS
        if variable.display_unit:
            attributes["displayUnit"] = variable.display_unit
    attributes |= sizes(variable, variable.elements.index(elements[0]))
    starts = [text_of(float(e.start) if variable.type == "real" else e.start) for e in elements if e.start is not None]
    if starts and variable.type != "string":
        attributes["start"] = " ".join(starts)
    entry = ET.SubElement(parent, _TAGS[variable.type], attributes)
    if variable.optional or variable.quantity:
        annotation = ET.SubElement(ET.SubElement(entry, "Annotations"), "Annotation", type=TOOL)
        if variable.optional:
            ET.SubElement(annotation, "Optional")
        if variable.quantity:
            ET.SubElement(annotation, "Quantity", name=variable.quantity)
    for length in variable.shape if whole else ():
        ET.SubElement(entry, "Dimension", start=str(length))
    for text in starts if variable.type == "string" else ():
        ET.SubElement(entry, "Start", value=text)


def _structure(root: ET.Element, interface: Interface) -> None:
    """Outputs with their direct feedthrough, and what their initial values depend on: arrays as a whole."""
    first = {
        element.value_reference: elements[0].value_reference
        for variable in interface.variables.values()
        for elements in parts(variable)
        for element in elements
    }
    structure = ET.SubElement(root, "ModelStructure")
    for tag, resolve in (("Output", interface.feedthrough), ("InitialUnknown", interface.initial_dependencies)):
        for variable in interface.of("output"):
            for elements in parts(variable):
                places = (variable.elements.index(element) for element in elements)
                known = {first[e.value_reference] for place in places for e in resolve(variable, place)}
                listed = " ".join(map(str, sorted(known)))
                reference = str(elements[0].value_reference)
                ET.SubElement(structure, tag, valueReference=reference, dependencies=listed)
