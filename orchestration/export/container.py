"""Writes a scenario as one FMU: the blocks, their wires and start values inside a container of
fmu-manipulation-toolbox.

The container steps the blocks one after the other in the scenario's order (or all at once, for parallel exchange) and
offers their outputs and parameters as `block.variable`.
"""

from __future__ import annotations

import json
import logging
import tempfile
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from ..errors import InputError
from ..fmu.archive import second
from ..quantities import Unit
from ..results.whole import putting
from .system import System


def write(system: System, path: Path) -> None:
    """Builds the container. Raises InputError where the toolbox is missing, or the scenario needs what it cannot do."""
    try:
        from fmu_manipulation_toolbox.assembly import Assembly, AssemblyError  # optional  # noqa: PLC0415
        from fmu_manipulation_toolbox.container import FMUContainerError  # optional  # noqa: PLC0415
    except ImportError:
        raise InputError(
            "--container needs the package fmu-manipulation-toolbox, version 2 or later: pip install "
            "fmu-manipulation-toolbox"
        ) from None
    _check(system)
    log = logging.getLogger("fmu_manipulation_toolbox")
    log.setLevel(logging.ERROR)
    with tempfile.TemporaryDirectory(prefix="orchestrate-") as temporary:
        work = Path(temporary)
        for component in system.components:
            (work / _file(component.name)).write_bytes(component.content())
        (work / "container.json").write_text(json.dumps(_description(system, path.name)), "utf-8")
        try:
            Assembly(work / "container.json", fmu_directory=work).make_fmu(filename=path.name)
        except (AssemblyError, FMUContainerError) as error:
            raise InputError(f"fmu-manipulation-toolbox cannot build the container: {error}") from None
        _finish(system, work / path.name, path)


def _check(system: System) -> None:
    converted = next((w for w in system.wires if (w.factor, w.offset) != (1.0, 0.0)), None)
    if converted is not None:
        raise InputError(
            f"{'.'.join(converted.source)} -> {'.'.join(converted.target)}: a container passes values as they "
            "are, and these units differ"
        )

    if pair := second({component.name: component.fmu for component in system.components}):
        message = (
            f"its FMU, which is that of {pair[0]}, too, can have one instance in a process "
            "(canBeInstantiatedOnlyOncePerProcess), "
            "and a container has all in one; cannot be exported"
        )
        raise InputError(system.scenario.error(("blocks", pair[1], "fmu"), message))


def _finish(system: System, made: Path, path: Path) -> None:
    """Copies the container with what the toolbox leaves out of its description: units, names of items, what it is."""
    with (
        zipfile.ZipFile(made) as source,
        putting(path) as part,
        zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as target,
    ):
        for entry in source.infolist():
            data = source.read(entry)
            target.writestr(entry, _described(system, data) if entry.filename == "modelDescription.xml" else data)


def _described(system: System, xml: bytes) -> bytes:
    root = ET.fromstring(xml)
    scenario = system.scenario
    root.set("description", scenario.description or f"{scenario.name}: {', '.join(system.order)}")
    root.set("license", "That of each FMU inside, see resources")
    root.attrib.pop("author", None)
    variables = {f"{c.name}.{p.name}": p.variable for c in system.components for p in (*c.ports, *c.free)}
    experiment = root.find("DefaultExperiment")
    if experiment is not None:  # that of the blocks, whose times are of other scenarios
        experiment.set("startTime", "0.0")
        experiment.set("stopTime", repr(float(scenario.duration)))
    units: dict[str, Unit] = {}
    for entry in root.iter("ScalarVariable"):
        variable = variables.get(entry.get("name", "").removeprefix("wire."))
        if variable is None:
            continue
        if variable.items:
            items = ", ".join(f"{number}: {item}" for item, number in variable.items)
            entry.set("description", f"{entry.get('description', '')} ({items})".strip())
        real = entry.find("Real")
        if variable.unit is not None and real is not None:
            units[variable.unit.name] = variable.unit
            real.set("unit", variable.unit.name)
    if units:
        definitions = ET.Element("UnitDefinitions")
        for name, unit in sorted(units.items()):
            ET.SubElement(ET.SubElement(definitions, "Unit", name=name), "BaseUnit", unit.base_unit)
        place = next(i for i, child in enumerate(root) if child.tag not in ("ModelExchange", "CoSimulation"))
        root.insert(place, definitions)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True)


def _file(block: str) -> str:
    """Wires become local variables that are called after the file; `block.variable` is kept for outputs."""
    return f"wire.{block}.fmu"


def _description(system: System, name: str) -> dict[str, Any]:
    """Returns what the toolbox reads."""
    components = system.components
    outputs = [(c, p) for c in components for p in c.ports if p.kind == "output"]
    return {
        "name": name,
        "fmu": [_file(block) for block in system.order],
        "link": [
            [_file(wire.source[0]), wire.source[1], _file(wire.target[0]), wire.target[1]] for wire in system.wires
        ],
        "start": [[_file(c.name), v.name, _text(v.value)] for c in components for v in c.values],
        "input": [[f"{c.name}.{p.name}", _file(c.name), p.name] for c in components for p in c.free],
        "output": [[_file(c.name), p.name, f"{c.name}.{p.name}"] for c, p in outputs],
        "step_size": float(system.scenario.step),
        "sequential": system.scenario.exchange == "sequential",
        "mt": False,
        "auto_link": False,
        "auto_output": False,
        "auto_input": False,
        "auto_parameter": False,
    }


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
