"""An FMU of FMI 2.0 as one of FMI 3.0, for tests: its description with arrays, its block behind as_fmi3.c."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import fmpy

from orchestration.fmu.archive import Fmu, open_fmu
from orchestration.fmu.head import ANNOTATION
from orchestration.fmu.model import Element, Model, Variable

from . import fmus

SOURCE = Path(__file__).with_name("as_fmi3.c")
TIME = '<Float64 name="time" valueReference="4294967295" causality="independent" variability="continuous"/>'
_KIND = {"real": 0, "integer": 1, "enumeration": 1, "boolean": 2, "string": 3}
_TAG = {"real": "Float64", "integer": "Int32", "enumeration": "Enumeration", "boolean": "Boolean", "string": "String"}


def write(path: Path, fmu: Fmu | Path, tags: Mapping[str, str] | None = None, *changes: tuple[str, str]) -> Path:
    """The FMU of FMI 3.0 at `path`.

    `tags` are FMI's types of variables by their names; `changes` replace text of the XML.
    """
    fmu = fmu if isinstance(fmu, Fmu) else open_fmu(fmu)
    xml = description(fmu, tags or {})
    for old, new in changes:
        assert old in xml, old
        xml = xml.replace(old, new, 1)
    with zipfile.ZipFile(fmu.path) as archive:
        block = archive.read(fmu.library)
    return pack(path, xml, fmus.library("as_fmi3", "-DLOADS"), {"resources/block": block}, _identifier(fmu))


def pack(
    path: Path, xml: str, library: bytes, more: Mapping[str, bytes] | None = None, identifier: str = "probe"
) -> Path:
    """An FMU of FMI 3.0 with this library for this platform."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr(f"binaries/{fmpy.platform_tuple}/{identifier}{fmpy.sharedLibraryExtension}", library)
        for name, data in (more or {}).items():
            archive.writestr(name, data)
    return path


def _identifier(fmu: Fmu) -> str:
    return str(fmu.description.coSimulation.modelIdentifier)


def description(fmu: Fmu, tags: Mapping[str, str]) -> str:
    model = fmu.model
    outputs = model.of("output")
    structure = "".join(
        f'<{tag} valueReference="{reference(v)}"{_dependencies(model, v, known)}/>'
        for tag, known in (("Output", model.feedthrough), ("InitialUnknown", model.initial))
        for v in outputs
    )
    variables = [v for v in model.variables.values() if v.causality in ("input", "output", "parameter")]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName={quoteattr(model.name)} instantiationToken={quoteattr(model.guid)}>
<CoSimulation modelIdentifier="{_identifier(fmu)}" canHandleVariableCommunicationStepSize="true"/>
{_units(model)}{_types(variables)}<ModelVariables>{TIME}
{chr(10).join(_variable(model, v, tags.get(v.name, _TAG[v.type])) for v in variables)}
</ModelVariables>
<ModelStructure>{structure}</ModelStructure>
</fmiModelDescription>
"""


def reference(variable: Variable) -> int:
    """As as_fmi3.c reads it."""
    first = variable.references[0]
    assert variable.references == tuple(range(first, first + variable.size))
    causality = ("output", "input", "parameter").index(variable.causality)
    return _KIND[variable.type] << 28 | causality << 24 | variable.size << 16 | first


def _units(model: Model) -> str:
    units = {u.name: u for v in model.variables.values() for u in (v.unit, *v.units) if u and u.exponents}
    bases = ((name, "".join(f' {k}="{x}"' for k, x in unit.base_unit.items())) for name, unit in units.items())
    entries = "".join(f"<Unit name={quoteattr(name)}><BaseUnit{base}/></Unit>" for name, base in bases)
    return f"<UnitDefinitions>{entries}</UnitDefinitions>\n" if entries else ""


def _types(variables: Iterable[Variable]) -> str:
    entries = "".join(
        f'<EnumerationType name="{v.name} items">'
        + "".join(f'<Item name={quoteattr(item)} value="{number}"/>' for item, number in v.items)
        + "</EnumerationType>"
        for v in variables
        if v.items
    )
    return f"<TypeDefinitions>{entries}</TypeDefinitions>\n" if entries else ""


def _variable(model: Model, v: Variable, tag: str) -> str:
    attributes = {
        "name": v.name,
        "valueReference": reference(v),
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.description:
        attributes["description"] = v.description
    if v.unit is not None and v.type == "real" and v.unit.exponents:
        attributes["unit"] = v.unit.name
    if v.items:
        attributes["declaredType"] = f"{v.name} items"
    starts = [model.starts[e] for e in v.elements] if v.causality != "output" else []
    content = (
        f'<Annotations><Annotation type="{ANNOTATION}"><Optional/></Annotation></Annotations>' if v.optional else ""
    )
    content += "".join(f'<Dimension start="{length}"/>' for length in v.shape)
    if v.type == "string":
        content += "".join(f"<Start value={quoteattr(text)}/>" for text in starts)
    elif starts:
        attributes["start"] = " ".join(str(value).lower() for value in starts)
    limits = (("min", v.minima), ("max", v.maxima)) if tag == "Float64" else ()
    attributes |= {key: all_[0] for key, all_ in limits if all_ and abs(all_[0]) < float("inf")}
    written = "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items())
    return f"<{tag}{written}>{content}</{tag}>"


def _dependencies(model: Model, variable: Variable, known: Mapping[Element, Any]) -> str:
    sets = [known.get(element) for element in variable.elements]
    if any(inputs is None for inputs in sets):
        return ""
    names = dict.fromkeys(element.variable for inputs in sets for element in sorted(inputs))
    return f' dependencies="{" ".join(str(reference(model.variables[name])) for name in names)}"'
