"""Packs a vendor's FMU: vendor.c, one of our blocks, and the table of what is different.

In C with FMI 2.0 or 3.0, or in Python by PythonFMU.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import fmpy
import numpy as np
from pythonfmu.builder import FmuBuilder

from orchestration.fmu.archive import Fmu, open_fmu
from orchestration.quantities import parse_unit

from ..orchestration import as_fmi3

HERE = Path(__file__).parent
OUTPUTS = 1000
"""The first reference of an output."""
EFFECTS = ("delay", "hold", "stuck", "limit", "lag", "noise", "dead", "quantum", "single")
FLAVOURS = ("FMI 2", "FMI 3", "Python")
Matrix = Any
"""An array of floats."""


@dataclass
class Port:
    """A port of ours and what the vendor has in its place: theirs = A ours + c in plain numbers, or turned."""

    ours: str
    causality: str
    names: list[str]
    """Their scalars, or one name with indices of an array."""
    unit: str | None
    description: str
    A: Matrix
    """(theirs, ours)."""
    c: Matrix
    kind: str = "linear"
    """linear, attitude, turned or earth: as vendor.c has them."""
    form: int = 0
    inverse: bool = False
    factor: float = 1.0
    start: list[float] = field(default_factory=list)

    @property
    def size(self) -> int:
        return len(self.names)


@dataclass
class Vendor:
    """A vendor's FMU before it is packed."""

    block: str
    ports: list[Port]
    parameters: list[tuple[str, str, float, str]] = field(default_factory=list)
    """Name, unit, value and description of what only theirs has."""
    changed: dict[tuple[str, int], float] = field(default_factory=dict)
    """Elements of our parameters that it has with another value: the factor."""
    direct: bool = True
    """Whether outputs are declared to depend on the inputs of their instant."""
    effects: list[tuple[str, str, int, float]] = field(default_factory=list)
    """Kind, output of ours, element of theirs, value."""

    def port(self, ours: str) -> Port:
        return next(port for port in self.ports if port.ours == ours)


@cache
def _library(fmi3: bool) -> bytes:
    sources = [HERE / "vendor.c"] + ([as_fmi3.SOURCE] if fmi3 else [])
    compiler = shutil.which("cc") or shutil.which("gcc")
    assert compiler is not None
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "vendor.so"
        flags = ["-shared", "-fPIC", "-O1", "-D_GNU_SOURCE", "-std=c11", "-Wl,-Bsymbolic"]
        subprocess.run([compiler, *flags, *map(str, sources), "-o", str(out), "-lm"], check=True)
        return out.read_bytes()


@cache
def _of_python() -> dict[str, bytes]:
    """Returns what PythonFMU packs of the slave, by name."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "slave" / "flight_software.py"
        script.parent.mkdir()
        shutil.copy(HERE / "slave.py", script)
        with zipfile.ZipFile(FmuBuilder.build_FMU(script, dest=Path(folder))) as archive:
            return {n: archive.read(n) for n in archive.namelist() if n.startswith(("binaries/", "resources/"))}


def pack(path: Path, vendor: Vendor, inner: Fmu, starts: Iterable[tuple[Any, Any]], flavour: str = "FMI 2") -> Path:
    """Writes the FMU. `starts` are the parameters' values that a scenario gives ours: they are built in."""
    flat = [(name, port) for port in vendor.ports for name in port.names]
    inputs = [pair for pair in flat if pair[1].causality == "input"]
    outputs = [pair for pair in flat if pair[1].causality == "output"]
    xml = _description(vendor, inputs, outputs)
    with zipfile.ZipFile(inner.path) as archive:
        block = archive.read(inner.library)
    files = {
        "resources/inner": block,
        "resources/table": _table(vendor, inner, starts).encode(),
        "resources/guid": str(inner.model.guid).encode(),
    }
    binary = {f"binaries/{fmpy.platform}/vendor{fmpy.sharedLibraryExtension}": _library(False)}
    if flavour == "Python":
        xml = xml.replace('modelIdentifier="vendor"', 'modelIdentifier="Vendor" needsExecutionTool="true"')
        binary = {"resources/vendor": _library(False), **_of_python()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("modelDescription.xml", xml)
        for name, data in (binary | files).items():
            archive.writestr(name, data)
    if flavour == "FMI 3":
        two = open_fmu(path)
        as_fmi3.pack(path, as_fmi3.description(two, {}), _library(True), files, "vendor")
    return path


def _table(vendor: Vendor, inner: Fmu, starts: Iterable[tuple[Any, Any]]) -> str:
    known = inner.model.variables
    inputs = [name for port in vendor.ports if port.causality == "input" for name in port.names]
    outputs = [name for port in vendor.ports if port.causality == "output" for name in port.names]
    lines = [f"inputs {len(inputs) + len(vendor.parameters)}", f"outputs {len(outputs)}"]
    starting = [x for port in vendor.ports if port.causality == "input" for x in port.start]
    lines += [f"start {i} {x!r}" for i, x in enumerate(starting)]
    values = dict(starts)
    for (name, position), factor in vendor.changed.items():
        element = known[name].elements[position]
        values[element] = float(values.get(element, inner.model.starts[element])) * factor
    for element, value in values.items():
        variable = known[element.variable]
        if variable.causality == "parameter":
            kind = {"real": "real", "boolean": "boolean"}.get(variable.type, "integer")
            lines.append(f"{kind} {variable.references[element.position]} {float(value)!r}")
    for port in vendor.ports:
        theirs = inputs if port.causality == "input" else outputs
        at = [theirs.index(name) for name in port.names]
        ours = known[port.ours].references
        linear = port.kind != "attitude"
        A, c = np.asarray(port.A, float), np.asarray(port.c, float)
        if port.causality == "input" and linear:
            A = np.linalg.inv(A)
            c = -A @ c
        role = {"r_N": 1, "v_N": 2}.get(port.ours, 0)
        words = [len(ours), len(at), port.form, int(port.inverse), role, repr(float(port.factor)), *ours, *at]
        if linear:
            words += [repr(float(x)) for x in (*A.ravel(), *c)]
        lines.append(f"{port.causality[:-3]} {port.kind} " + " ".join(map(str, words)))
    for kind, ours, position, value in vendor.effects:
        at_ = outputs.index(vendor.port(ours).names[position])
        lines.append(f"effect {EFFECTS.index(kind)} {at_} {value!r}")
    return "\n".join(lines) + "\n"


def _description(vendor: Vendor, inputs: Sequence[tuple[str, Port]], outputs: Sequence[tuple[str, Port]]) -> str:
    units = dict.fromkeys([p.unit for p in vendor.ports if p.unit] + [u for _, u, _, _ in vendor.parameters if u])
    defined = "".join(
        f"<Unit name={quoteattr(name)}><BaseUnit"
        + "".join(f' {key}="{value}"' for key, value in parse_unit(name).base_unit.items())
        + "/></Unit>"
        for name in units
    )
    starts = [x for port in vendor.ports if port.causality == "input" for x in port.start]
    variables = [
        _variable(name, i, "input", port.unit, port.description, starts[i]) for i, (name, port) in enumerate(inputs)
    ]
    variables += [
        _variable(name, len(inputs) + i, "parameter", unit, text, value)
        for i, (name, unit, value, text) in enumerate(vendor.parameters)
    ]
    first = len(variables) + 1
    variables += [
        _variable(name, OUTPUTS + i, "output", port.unit, port.description, None)
        for i, (name, port) in enumerate(outputs)
    ]
    every = " ".join(str(i + 1) for i in range(len(inputs) if vendor.direct else 0))
    unknowns = "".join(f'<Unknown index="{first + i}" dependencies="{every}"/>' for i in range(len(outputs)))
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="flight_sw" guid="vendor" variableNamingConvention="structured">
<CoSimulation modelIdentifier="vendor" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions>{defined}</UnitDefinitions>
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>
</fmiModelDescription>""".replace("<UnitDefinitions></UnitDefinitions>", "")


def _variable(name: str, reference: int, causality: str, unit: str | None, text: str, start: float | None) -> str:
    variability = "fixed" if causality == "parameter" else "continuous"
    given = (f" unit={quoteattr(unit)}" if unit else "") + (f' start="{start!r}"' if start is not None else "")
    initial = ' initial="exact"' if causality == "parameter" else ""
    words = f" description={quoteattr(text)}" if text else ""
    return (
        f'<ScalarVariable name={quoteattr(name)} valueReference="{reference}" causality="{causality}" '
        f'variability="{variability}"{initial}{words}><Real{given}/></ScalarVariable>'
    )
