"""terminalsAndIcons/terminalsAndIcons.xml: ports that are wired together, and where they stand on the icon.

FMI 2.0.4 took it over from FMI 3.0 (2.4.9), so the file names that version. Terminals of one name on two blocks fit
each other: a tool that knows terminals wires all their variables at once. Tests: tests/fmus/contents/test_contents.py.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

from ..interface import Interface
from .description3 import names_3

EDGE, BODY, HALF = 100, 80, 8
"""Of the icon's coordinates: the square, the block within it, and half a terminal's height."""


def terminals_and_icons(interface: Interface, version: int = 2) -> bytes:
    """The XML file: the icon's place, then a terminal each with its inputs at the left or its outputs at the right."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = ET.SubElement(root, "GraphicalRepresentation")
    ET.SubElement(graphics, "CoordinateSystem", _extent(-EDGE, -EDGE, EDGE, EDGE), suggestedScalingFactorTo_mm="0.1")
    ET.SubElement(graphics, "Icon", _extent(-BODY, -BODY, BODY, BODY))
    if interface.terminals:
        entries = ET.SubElement(root, "Terminals")
        for causality, side in (("input", -1), ("output", 1)):
            names = [n for n, members in interface.terminals.items() if _causality(interface, members) == causality]
            for place, name in enumerate(names, start=1):
                _terminal(entries, interface, name, version, side, BODY - 2 * BODY * place // (len(names) + 1))
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _terminal(parent: ET.Element, interface: Interface, name: str, version: int, side: int, height: int) -> None:
    variables = [interface.variables[member] for member in interface.terminals[name]]
    about = "; ".join(variable.description for variable in variables)
    entry = ET.SubElement(parent, "Terminal", name=name, matchingRule="plug", description=about)
    for variable in variables:
        names = [e.name for e in variable.elements] if version == 2 else names_3(variable)
        for member_name in names:
            member = {"variableName": member_name, "memberName": member_name, "variableKind": "signal"}
            ET.SubElement(entry, "TerminalMemberVariable", member)
    left, right = sorted((side * BODY, side * (BODY + 2 * HALF)))
    extent = _extent(left, height - HALF, right, height + HALF)
    ET.SubElement(entry, "TerminalGraphicalRepresentation", extent, iconBaseName="terminal")


def _causality(interface: Interface, members: tuple[str, ...]) -> str:
    return interface.variables[members[0]].causality


def _extent(x1: int, y1: int, x2: int, y2: int) -> dict[str, str]:
    return {"x1": str(x1), "y1": str(y1), "x2": str(x2), "y2": str(y2)}
