"""Writes the reference data of an FMU (FMI-LS-REF): parameters, inputs, outputs that it gives for them, and tolerances.

The inputs are those of a test vector, rounded, so that the files are short.
The outputs are what the FMU gives for these. Tests: tests/orchestration/acceptance/test_references.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from fmus.interface import SAMPLE_PERIOD

from ..errors import InputError, writing
from ..export.ssp import parameter_set, xml_bytes
from ..export.system import Value
from ..fmu.archive import Fmu, open_fmu
from ..fmu.head import ANNOTATION
from ..fmu.model import TYPES, Element, Floats, Model
from ..quantities import QuantityError
from ..scenario.references import Name
from ..system.values import values_of
from .experiments import EXPERIMENTS, PARAMETERS, Table
from .references import run
from .tables import columns_of, csv_text, parameters_of, read_table

NAME = "smoke-test"
VERSION = "1.0.0-beta.1"
DIGITS = 9
"""Of an input; outputs have 15."""
ROWS = 61
SHARE = 1e-8
"""The least tolerance of a signal, relative to its largest value."""
MARGIN = 10.0
"""A tolerance is this many times the difference between the flavours of a block, where that is more."""
_DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
_LS = "http://fmi-standard.org/fmi-ls-manifest"

ET.register_namespace("fmi-ls", _LS)


def write(
    fmu: Path,
    vector: Path,
    folder: Path,
    others: Sequence[Path] = (),
    remark: Callable[[str], None] = lambda text: None,
) -> list[Path]:
    """Writes the files into a folder and returns them. `others` are FMUs of other flavours of the block.

    They have the first ROWS instants of the vector, since they are part of the FMU; `remark` is told where it has more.
    Raises InputError where the vector does not fit the FMU, or where the FMU fails.
    Raises ResultsError where a file cannot be written.
    """
    opened = open_fmu(fmu)
    model = opened.model
    header, table = read_table(vector / "vector.csv")
    if len(table) > ROWS:
        whole, part = table[-1, 0], table[ROWS - 1, 0]
        remark(f"of {vector / 'vector.csv'} to {whole:.10g} s the first {ROWS} instants, to {part:.10g} s")
    table = table[:ROWS]
    columns = columns_of(model, header, vector)
    given = {
        Element(name, position): _rounded(table[:, column])
        for name, places in columns.items()
        if model.variables[name].causality == "input"
        for position, column in enumerate(places)
    }
    start = parameters_of(model, vector)
    step = float(f"{(table[-1, 0] - table[0, 0]) / (len(table) - 1):.12g}")
    if SAMPLE_PERIOD in model.variables:  # a host that steps more finely gets the same outputs
        start.setdefault(SAMPLE_PERIOD, step)
    time = np.array([float(f"{step * i:.12g}") for i in range(len(table))])
    for element in (e for v in model.of("input") if v.type in TYPES for e in v.elements):
        given.setdefault(element, np.full(len(time), float(model.starts.get(element, 0.0))))
    stimuli = Table(str(vector / "vector.csv"), time, given)
    played = [_play(path, model, time, stimuli, start) for path in (fmu, *others)]
    outputs = {
        Element(variable.name, position): played[0][variable.name][:, position]
        for variable in model.of("output")
        if variable.type in TYPES
        for position in range(variable.size)
    }
    tolerances = {
        element: _tolerance(values, [other[element.variable][:, element.position] for other in played[1:]])
        for element, values in outputs.items()
        if model.variables[element.variable].type == "real"
    }
    files = {
        "inputs.csv": _csv(model, time, given, DIGITS),
        "outputs.csv": _csv(model, time, outputs, 15),
        "parameters.ssv": parameter_set(_values(opened, start)),
    }
    files[f"{NAME}.exp"] = _experiment(model, step, time, tolerances)
    files["fmi-ls-manifest.xml"] = _manifest()
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            (folder / name).write_bytes(data)
    return [folder / name for name in files]


def _play(path: Path, model: Model, time: Floats, stimuli: Table, start: Mapping[str, Any]) -> Mapping[str, Floats]:
    played = run({"fmu": str(path.resolve()), "start": dict(start)}, model, time, stimuli)
    if played.failure is not None:
        raise InputError(f"{path}: {played.failure}")
    return played.outputs


def _rounded(values: Floats) -> Floats:
    return np.array([float(f"{value:.{DIGITS}g}") for value in values])


def _tolerance(values: Floats, others: Sequence[Floats]) -> float:
    """Returns the tolerance of a signal, rounded up to one digit."""
    apart = max((float(np.abs(other - values).max()) for other in others), default=0.0)
    least = max(SHARE * float(np.abs(values).max()), MARGIN * apart)
    return float(f"{1.05 * least + 1e-30:.0e}") if least else 1e-15


def _csv(model: Model, time: Floats, columns: Mapping[Element, Floats], digits: int) -> bytes:
    header = ["time", *(model.variables[e.variable].label(e.position).replace("][", ",") for e in columns)]
    rows = [
        [f"{instant:.12g}", *(f"{float(values[i]):.{digits}g}" for values in columns.values())]
        for i, instant in enumerate(time.tolist())
    ]
    return csv_text([header, *rows]).encode()


def _values(opened: Fmu, start: Mapping[str, Any]) -> list[Value]:
    model = opened.model
    found = []
    for key, value in start.items():
        try:
            elements = values_of(model.name, model, Name(key), value)
        except QuantityError as error:
            raise InputError(f"{key}: {error}") from None
        for element, number in elements.items():
            variable = model.variables[element.variable].at([element.position])
            found.append(Value(variable.label(element.position).replace("][", ","), variable, number))
    return found


def _experiment(model: Model, step: float, time: Floats, tolerances: Mapping[Element, float]) -> bytes:
    root = ET.Element("Experiments", name=f"Smoke test of {model.name}")
    entry = ET.SubElement(
        root,
        "Experiment",
        name=NAME,
        description="The FMU alone, with inputs from a run of the loop",
        startTime="0",
        stopTime=f"{time[-1]:.12g}",
        stepSize=f"{step:.12g}",
        tolerance=f"{SHARE:g}",
    )
    ET.SubElement(entry, "Parameters", source="parameters.ssv")
    ET.SubElement(entry, "Stimuli", source="inputs.csv")
    references = ET.SubElement(entry, "References", source="outputs.csv")
    annotation = ET.SubElement(ET.SubElement(references, "Annotations"), "Annotation", type=ANNOTATION)
    for element, tolerance in tolerances.items():
        label = model.variables[element.variable].label(element.position).replace("][", ",")
        ET.SubElement(annotation, "Tolerance", name=label, absolute=f"{tolerance:g}")
    return xml_bytes(root)


def _manifest() -> bytes:
    attributes = {"fmi-ls-name": "org.fmi-standard.fmi-ls-ref", "fmi-ls-version": VERSION}
    attributes["fmi-ls-description"] = _DESCRIPTION
    root = ET.Element("fmiReferences", {f"{{{_LS}}}{key}": value for key, value in attributes.items()})
    for source, kind, role, about in (
        (f"{NAME}.exp", EXPERIMENTS[0], "experiment/smoke-test", "The FMU alone, its inputs and what it has to give"),
        ("parameters.ssv", PARAMETERS, "parameter", "Parameters of the smoke test"),
        ("inputs.csv", "text/csv", "testcase", "Inputs of the smoke test"),
        ("outputs.csv", "text/csv", "result", "Outputs of the smoke test"),
    ):
        ET.SubElement(root, "Related", type=kind, source=source, role=role, description=about)
    return xml_bytes(root)
