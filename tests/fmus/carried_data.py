"""Plays the reference data that one of our FMUs carries, by FMPy, of either version of FMI: for comparisons to
the last bit."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from fmus.contents.references import FOLDER
from fmus.interface import Interface

KINDS = {"integer": ("Integer", "Int32"), "enumeration": ("Integer", "Int64"), "boolean": ("Boolean", "Boolean")}


def rows(folder: Path, name: str, interface: Interface) -> list[dict[str, float]]:
    """The rows of a table by the names of elements: of FMI 3.0, a column is an array."""

    def elements(name: str, cell: str) -> list[tuple[str, float]]:
        arrays = interface.variables
        names = [e.name for e in arrays[name].elements] if name in arrays else [name]
        return list(zip(names, map(float, cell.split()), strict=True))

    with (folder / FOLDER / name).open(newline="") as file:
        return [dict(pair for item in row.items() for pair in elements(*item)) for row in csv.DictReader(file)]


def start_values(folder: Path) -> dict[str, str]:
    found = ET.parse(folder / FOLDER / "parameters.ssv").findall(".//{*}Parameter")
    return {entry.attrib["name"]: entry[0].attrib["value"] for entry in found}


def played(fmu: Path, interface: Interface) -> np.ndarray:
    """Returns the outputs (rows, columns of outputs.csv) that the FMU gives, as FMPy gets them."""
    folder = Path(extract(str(fmu)))
    try:
        return _played(folder, interface)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _played(folder: Path, interface: Interface) -> np.ndarray:
    description = read_model_description(str(folder))
    three = description.fmiVersion.startswith("3")
    kind: Any = FMU3Slave if three else FMU2Slave
    it = kind(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=str(folder),
        instanceName="played",
    )
    references = {v.name: v.valueReference for v in description.modelVariables}
    values: dict[str, list[Any]] = {v.name: [e.start for e in v.elements] for v in interface.variables.values()}

    def call(verb: str, name: str, *more: Any) -> Any:
        variable = interface.variables[name]
        if three:
            what = {"real": "Float64", "string": "String"}.get(variable.type) or KINDS[variable.type][1]
            # An array whose elements differ in unit has a variable an element.
            names = [name] if name in references else [e.name for e in variable.elements]
            given = [references[n] for n in names], *more
            return getattr(it, f"{verb}{what}")(*given, **({"nValues": len(variable.elements)} if not more else {}))
        what = {"real": "Real", "string": "String"}.get(variable.type) or KINDS[variable.type][0]
        return getattr(it, f"{verb}{what}")([references[e.name] for e in variable.elements], *more)

    def put(numbers: dict[str, Any]) -> None:
        touched = {}
        for name, value in numbers.items():
            variable, element = interface.elements[name]
            if variable.type in KINDS:
                value = {"true": 1, "false": 0}.get(str(value), value)
                value = variable.items.index(value) + 1 if value in variable.items else int(float(value))
            values[variable.name][variable.elements.index(element)] = (
                value if variable.type in (*KINDS, "string") else float(value)
            )
            touched[variable.name] = variable
        for name in touched:
            call("set", name, values[name])

    given, columns = rows(folder, "inputs.csv", interface), list(rows(folder, "outputs.csv", interface)[0])[1:]
    inputs = [{k: v for k, v in row.items() if k != "time"} for row in given]

    def outputs() -> list[float]:
        found = {interface.elements[name][0].name: [] for name in columns}
        found = {name: list(call("get", name)) for name in found}
        places = [(v.name, v.elements.index(e)) for v, e in (interface.elements[name] for name in columns)]
        return [float(found[name][place]) for name, place in places]

    it.instantiate()
    if not three:
        it.setupExperiment(startTime=0.0)
    put(start_values(folder))
    it.enterInitializationMode()
    put(inputs[0])
    it.exitInitializationMode()
    found = [outputs()]
    for before, at, after in zip(inputs[:-1], given[:-1], given[1:], strict=True):
        put(before)
        step = given[1]["time"] - given[0]["time"]
        it.doStep(round(at["time"] / step) * step, step)
        assert after["time"] > at["time"]
        found.append(outputs())
    it.terminate()
    it.freeInstance()
    return np.array(found)


def hashed(outputs: np.ndarray) -> int:
    """FNV-1a of the numbers' bits, row by row."""
    value = 14695981039346656037
    for byte in np.ascontiguousarray(outputs, "<f8").tobytes():
        value = (value ^ byte) * 1099511628211 % 2**64
    return value
