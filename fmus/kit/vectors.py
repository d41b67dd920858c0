"""vectors.h: the reference data of a block as C, so that a runner reads no file.

Tests: tests/fmus/kit/test_flight.py."""

from __future__ import annotations

import csv
import xml.etree.ElementTree as ET
from pathlib import Path

from ..contents.references import folder_of
from ..interface import Element, Interface, InterfaceError, Variable
from ..native.generate import camel_case, members_of, quoted

_WHOLE = 0.5
"""The tolerance of what is no real number: any other value is beyond it."""


def header(interface: Interface, block: Path, bits: int) -> str:
    """The text of vectors.h. `bits`: the hash of all outputs' bits. Raises InterfaceError where there are no data."""
    folder = folder_of(interface, block)
    if not (folder / "inputs.csv").exists():
        raise InterfaceError(f"{interface.name} has no reference data: expected {folder / 'inputs.csv'}")
    given, expected = _table(folder / "inputs.csv"), _table(folder / "outputs.csv")
    root = ET.parse(folder / "smoke-test.exp").getroot()
    step = next(root.iter("Experiment")).attrib["stepSize"]
    tolerances = {entry.attrib["name"]: entry.attrib["absolute"] for entry in root.iter("Tolerance")}
    inputs, outputs = (_elements(interface, table[0][1:]) for table in (given, expected))
    title = camel_case(interface.code)
    calls = "\n".join(f"#define block_{call} {interface.code}_{call}" for call in _CALLS)
    limits = ", ".join(tolerances.get(element.name, str(_WHOLE)) for _, element in outputs)
    names = ", ".join(quoted(element.name) for _, element in outputs)
    return f"""\
/* The reference data of {interface.name}: inputs.csv, outputs.csv, parameters.ssv and smoke-test.exp. Generated. */
#ifndef VECTORS_H
#define VECTORS_H

#include "{interface.code}.h"

#include <stdint.h>

#define BLOCK "{interface.name}"
#define STEP {step} /* s */
enum {{ ROWS = {len(given) - 1}, OUTPUTS = {len(outputs)} }};

{"".join(f"typedef {title}{kind} {kind};{chr(10)}" for kind in ("Parameters", "Inputs", "Outputs", "State", "Law"))}
{calls}

static const Parameters parameters = {{
{_starts(interface, interface.of("parameter"), _set(folder / "parameters.ssv"))}
}};
static const Inputs start = {{
{_starts(interface, interface.of("input"), {})}
}};
static const uint64_t bits = 0x{bits:016x}u; /* of all outputs, as the FMU gives them */
static const char *const names[OUTPUTS] = {{{names}}};
static const double tolerance[OUTPUTS] = {{{limits}}};
static const double given[ROWS][{len(inputs)}] = {{
{_rows(given)}
}};
static const double expected[ROWS][OUTPUTS] = {{
{_rows(expected)}
}};

static void set_inputs(Inputs *u, const double x[])
{{
{_assigned(interface, inputs, "u->{member} = {value};")}
}}

static void get_outputs(const Outputs *y, double x[])
{{
{_assigned(interface, outputs, "x[{i}] = y->{member};")}
}}

#endif
"""


_CALLS = ("check", "prepare", "start", "outputs", "step")
_CASTS = {"integer": "(int32_t)x[{i}]", "enumeration": "(int32_t)x[{i}]", "boolean": "x[{i}] != 0.0"}


def _table(path: Path) -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def _rows(table: list[list[str]]) -> str:
    return ",\n".join(f"    {{{', '.join(row[1:])}}}" for row in table[1:])


def _elements(interface: Interface, names: list[str]) -> list[tuple[Variable, Element]]:
    return [interface.elements[name.replace("][", ",")] for name in names]


def _member(interface: Interface, variable: Variable, element: Element) -> str:
    return members_of(interface, variable)[variable.elements.index(element)]


def _assigned(interface: Interface, elements: list[tuple[Variable, Element]], form: str) -> str:
    lines = []
    for i, (variable, element) in enumerate(elements):
        value = _CASTS.get(variable.type, "x[{i}]").format(i=i)
        lines.append("    " + form.format(i=i, member=_member(interface, variable, element), value=value))
    return "\n".join(lines)


def _set(path: Path) -> dict[str, str]:
    """The values of a file of parameters by the names of the elements."""
    found = {}
    for parameter in ET.parse(path).getroot().findall(".//{*}Parameter"):
        (value,) = parameter
        found[parameter.attrib["name"]] = value.attrib["value"]
    return found


def _starts(interface: Interface, variables: list[Variable], given: dict[str, str]) -> str:
    lines = []
    for variable in variables:
        for element in variable.elements:
            text = given.get(element.name, str(element.start))
            if variable.type == "string":
                text = quoted(text)
            elif variable.type == "boolean":
                text = text.lower()
            elif text in variable.items:
                text = str(variable.items.index(text) + 1)
            lines.append(f"    .{_member(interface, variable, element)} = {text},")
    return "\n".join(lines)
