"""The tree of systems in an SSP archive, laid flat: components, what feeds their connectors, values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote
from xml.etree import ElementTree as ET

from ..errors import InputError
from ..fmu.archive import shown
from ..quantities import Unit
from .words import NAMESPACES

_FMU = "application/x-fmu-sharedlibrary"

Path_ = tuple[str, ...]
"""Where an element stands: the names of the systems around it, and its own."""


class End(NamedTuple):
    """A connector of an element."""

    element: Path_
    connector: str


@dataclass
class Given:
    """A value from a parameter set."""

    kind: str
    value: str
    unit: Unit | None = None


@dataclass
class Structure:
    """What the tree of systems holds, laid flat."""

    components: dict[Path_, str] = field(default_factory=dict)
    """Where the FMU of each component stands in the archive."""
    flows: dict[End, tuple[End, float, float, bool]] = field(default_factory=dict)
    """What feeds a connector: from where, with which factor and offset, and whether units are left alone."""
    values: dict[Path_, dict[str, Given]] = field(default_factory=dict)
    kinds: dict[End, str] = field(default_factory=dict)

    def source(self, end: End) -> tuple[End, float, float, bool] | None:
        """The component's connector that feeds this one, through all systems, with the product of what lies between."""
        factor, offset, suppressed = 1.0, 0.0, False
        for _ in range(len(self.flows) + 1):
            if end not in self.flows:
                return None
            end, f, o, s = self.flows[end]
            factor, offset, suppressed = factor * f, factor * o + offset, suppressed or s
            if end.element in self.components:
                return end, factor, offset, suppressed
        return None


def inside(path: Path, folder: Path, source: str) -> Path:
    """A file of the archive by its relative URI."""
    file = (folder / unquote(source)).resolve()
    if not file.is_relative_to(folder.resolve()) or not file.is_file():
        raise InputError(f"{shown(path)} refers to {source!r}, which it does not hold")
    return file


def parsed(path: Path, file: Path, tag: str) -> ET.Element:
    prefix, _, name = tag.partition(":")
    try:
        root = ET.parse(file).getroot()
    except (ET.ParseError, OSError) as error:
        raise InputError(f"{shown(path)}: {file.name} cannot be read: {error}") from None
    if root.tag != f"{{{NAMESPACES[prefix]}}}{name}":
        raise InputError(f"{shown(path)}: {file.name} is no {name} of SSP 1.0: it begins with {root.tag}")
    return root


class _System:
    """Reads a tree of systems into a structure."""

    def __init__(self, path: Path, folder: Path, into: Structure) -> None:
        self._path, self._folder, self._into = path, folder, into

    def read(self, system: ET.Element, place: Path_) -> None:
        for element in system.findall("ssd:Elements/*", NAMESPACES):
            inner = (*place, element.get("name", ""))
            self._connectors(element, inner)
            kind = element.tag.rpartition("}")[2]
            if kind == "System":
                self.read(element, inner)
            elif kind == "Component" and element.get("type", _FMU) == _FMU:
                self._into.components[inner] = element.get("source", "")
                self._bindings(element, inner)
            else:
                raise self._refused(inner, "a component that is no FMU" if kind == "Component" else f"a {kind}")
        self._connectors(system, place)
        for connection in system.findall("ssd:Connections/ssd:Connection", NAMESPACES):
            self._connection(connection, place)
        self._bindings(system, place)  # a system's values count more than those of its elements

    def _refused(self, place: Path_, what: str) -> InputError:
        return InputError(f"{shown(self._path)}: {'.'.join(place)} is {what}, which orchestrate does not run")

    def _connectors(self, element: ET.Element, place: Path_) -> None:
        for connector in element.findall("ssd:Connectors/ssd:Connector", NAMESPACES):
            self._into.kinds[End(place, connector.get("name", ""))] = connector.get("kind", "")

    def _connection(self, entry: ET.Element, place: Path_) -> None:
        ends = []
        for side in ("start", "end"):
            element = entry.get(f"{side}Element")
            ends.append(End(place if element is None else (*place, element), entry.get(f"{side}Connector", "")))
        begin, end = ends
        # The names say nothing of the direction: an element's output gives, and so does a system's input to its inside.
        gives = [
            self._into.kinds.get(e)
            in (("input", "parameter") if e.element == place else ("output", "calculatedParameter"))
            for e in ends
        ]
        if gives == [False, True]:
            begin, end = end, begin
        factor, offset = 1.0, 0.0
        for child in entry:
            kind = child.tag.rpartition("}")[2]
            if kind == "LinearTransformation":
                factor, offset = float(child.get("factor", "1")), float(child.get("offset", "0"))
            elif kind.endswith("Transformation"):
                raise self._refused((*end.element, end.connector), f"fed through a {kind}")
        self._into.flows[end] = (begin, factor, offset, entry.get("suppressUnitConversion") in ("true", "1"))

    def _bindings(self, element: ET.Element, place: Path_) -> None:
        for binding in element.findall("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
            source = binding.get("source")
            if source:
                values = parsed(self._path, inside(self._path, self._folder, source), "ssv:ParameterSet")
            elif (inline := binding.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)) is not None:
                values = inline
            else:
                continue
            values_by_name = {f"{binding.get('prefix', '')}{name}": given for name, given in _parameters(values)}
            mapping = binding.find("ssd:ParameterMapping", NAMESPACES)
            if mapping is not None:
                values_by_name = self._mapped(values_by_name, mapping)
            for name, given in values_by_name.items():
                self._assign(place, name, given)

    def _mapped(self, values_by_name: dict[str, Given], mapping: ET.Element) -> dict[str, Given]:
        source = mapping.get("source")
        entries = (
            parsed(self._path, inside(self._path, self._folder, source), "ssm:ParameterMapping") if source else mapping
        )
        mapped = {}
        for entry in entries.iter(f"{{{NAMESPACES['ssm']}}}MappingEntry"):
            name, target = entry.get("source", ""), entry.get("target", "")
            if len(entry):
                raise InputError(
                    f"{shown(self._path)}: the mapping of {name} to {target} has a transformation, which orchestrate does not do"
                )
            if name in values_by_name:
                mapped[target] = values_by_name[name]
        return mapped

    def _assign(self, place: Path_, name: str, given: Given) -> None:
        """The innermost component whose name begins the parameter's takes it; SSP ignores what fits nowhere."""
        if place in self._into.components:
            self._into.values.setdefault(place, {})[name] = given
            return
        for component in self._into.components:
            inner = ".".join(component[len(place) :]) + "."
            if component[: len(place)] == place and name.startswith(inner):
                self._into.values.setdefault(component, {})[name.removeprefix(inner)] = given


def _parameters(values: ET.Element) -> Iterator[tuple[str, Given]]:
    units = {entry.get("name"): _unit(entry) for entry in values.findall("ssv:Units/ssc:Unit", NAMESPACES)}
    for parameter in values.findall("ssv:Parameters/ssv:Parameter", NAMESPACES):
        for entry in parameter:
            kind = entry.tag.rpartition("}")[2]
            if kind in ("Real", "Integer", "Boolean", "String", "Enumeration"):
                yield parameter.get("name", ""), Given(kind, entry.get("value", ""), units.get(entry.get("unit")))


def _unit(entry: ET.Element) -> Unit:
    base = entry.find("ssc:BaseUnit", NAMESPACES)
    return Unit.from_base_unit(entry.get("name", ""), {} if base is None else base.attrib)


def read(path: Path, folder: Path, system: ET.Element) -> Structure:
    """What the outermost system of an unpacked archive holds. Raises InputError."""
    structure = Structure()
    _System(path, folder, structure).read(system, ())
    return structure
