"""The tree of systems in an SSP archive, laid flat: components, what feeds their connectors, values."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, hint
from ..fmu.zipped import shown
from ..quantities import Unit
from .documents import check, inside, parsed
from .words import NAMESPACES

_FMU = "application/x-fmu-sharedlibrary"
COMPONENTS_MAX, CONNECTIONS_MAX, _HOPS_MAX = 1000, 20_000, 1000
"""Of all systems together; and through how many connectors of systems a signal may pass."""

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
    """Content of the tree of systems, laid flat."""

    components: dict[Path_, str] = field(default_factory=dict)
    """Where the FMU of each component stands in the archive."""
    flows: dict[End, tuple[End, float, float, bool]] = field(default_factory=dict)
    """What feeds a connector: from where, with which factor and offset, and whether units are left alone."""
    where: str = ""
    """The archive, for messages."""
    values: dict[Path_, dict[str, Given]] = field(default_factory=dict)
    kinds: dict[End, str] = field(default_factory=dict)

    def source(self, end: End) -> tuple[End, float, float, bool] | None:
        """The component's connector that feeds this one, through all systems, with the product of what lies between."""
        factor, offset, suppressed = 1.0, 0.0, False
        target = end
        for _ in range(_HOPS_MAX):
            if end not in self.flows:
                return None
            end, f, o, s = self.flows[end]
            factor, offset, suppressed = factor * f, factor * o + offset, suppressed or s
            if end.element in self.components:
                return end, factor, offset, suppressed
        raise InputError(f"{self.where}: {_named(target)} is fed in a circle, or through more than {_HOPS_MAX} systems")


class _System:
    """Reads a tree of systems into a structure."""

    def __init__(self, path: Path, folder: Path, into: Structure) -> None:
        self._path, self._folder, self._into = path, folder, into

    def read(self, system: Any, place: Path_) -> None:
        if not place:
            self._connectors(system, place)
        inside_it: set[str] = set()
        for element in system.findall("ssd:Elements/*", NAMESPACES):
            name = element.get("name", "")
            inner = (*place, name)
            if name in inside_it:
                raise InputError(
                    f"{shown(self._path)}: there are two elements {'.'.join(inner)}; expected each name once"
                )
            inside_it.add(name)
            self._connectors(element, inner)
            kind = element.tag.rpartition("}")[2]
            if kind == "System":
                self.read(element, inner)
            elif kind == "Component" and element.get("type", _FMU) == _FMU:
                self._into.components[inner] = element.get("source", "")
                self._count(len(self._into.components), COMPONENTS_MAX, "components")
                self._bindings(element, inner)
            else:
                raise self._refused(inner, "a component that is no FMU" if kind == "Component" else f"a {kind}")
        for connection in system.findall("ssd:Connections/ssd:Connection", NAMESPACES):
            self._connection(connection, place, inside_it)
        self._bindings(system, place)  # a system's values count more than those of its elements

    def _refused(self, place: Path_, what: str) -> InputError:
        return InputError(f"{shown(self._path)}: {'.'.join(place)} is {what}, which orchestrate does not run")

    def _count(self, count: int, limit: int, what: str) -> None:
        if count > limit:
            raise InputError(f"{shown(self._path)} has more than {limit} {what}, the most that is read")

    def _connectors(self, element: Any, place: Path_) -> None:
        for connector in element.findall("ssd:Connectors/ssd:Connector", NAMESPACES):
            end = End(place, connector.get("name", ""))
            if end in self._into.kinds:
                raise InputError(
                    f"{shown(self._path)}: there are two connectors {_named(end)}; expected each name once"
                )
            self._into.kinds[end] = connector.get("kind", "")

    def _connection(self, entry: Any, place: Path_, inside_it: set[str]) -> None:
        ends = []
        for side in ("start", "end"):
            element = entry.get(f"{side}Element")
            if element is not None and element not in inside_it:
                system = f"the system {'.'.join(place)}" if place else "the system"
                raise self._wrong(entry, f"{system} has no element {element!r}{hint(element, inside_it)}")
            ends.append(End(place if element is None else (*place, element), entry.get(f"{side}Connector", "")))
            if ends[-1] not in self._into.kinds:
                offered = [e.connector for e in self._into.kinds if e.element == ends[-1].element]
                ending = hint(ends[-1].connector, offered)
                whose = ".".join(ends[-1].element) or "the system"
                raise self._wrong(entry, f"{whose} has no connector {ends[-1].connector!r}{ending}")
        begin, end = ends
        # The names say nothing of the direction: an element's output gives, and so does a system's input to its inside.
        gives = [
            self._into.kinds.get(e)
            in (("input", "parameter") if e.element == place else ("output", "calculatedParameter"))
            for e in ends
        ]
        if gives[0] == gives[1]:
            raise self._wrong(entry, f"{_named(begin)} and {_named(end)} both {'give' if gives[0] else 'take'} a value")
        if gives == [False, True]:
            begin, end = end, begin
        factor, offset = 1.0, 0.0
        for child in entry:
            kind = child.tag.rpartition("}")[2]
            if kind == "LinearTransformation":
                factor, offset = float(child.get("factor", "1")), float(child.get("offset", "0"))
                if not (math.isfinite(factor) and math.isfinite(offset)):
                    raise self._wrong(
                        entry, f"the factor {factor:g} and the offset {offset:g}; expected finite numbers"
                    )
            elif kind.endswith("Transformation"):
                raise self._refused((*end.element, end.connector), f"fed through a {kind}")
        if end in self._into.flows:
            raise self._wrong(entry, f"{_named(end)} is fed already, by {_named(self._into.flows[end][0])}")
        self._into.flows[end] = (begin, factor, offset, entry.get("suppressUnitConversion") in ("true", "1"))
        self._count(len(self._into.flows), CONNECTIONS_MAX, "connections")

    def _wrong(self, entry: Any, what: str) -> InputError:
        names = [
            ".".join(filter(None, (entry.get(f"{side}Element"), entry.get(f"{side}Connector"))))
            for side in ("start", "end")
        ]
        return InputError(f"{shown(self._path)}: the connection {' -> '.join(names)}: {what}")

    def _bindings(self, element: Any, place: Path_) -> None:
        for binding in element.findall("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
            source = binding.get("source")
            self._check_binding(binding, place)
            if source:
                values = parsed(self._path, inside(self._path, self._folder, source), "ssv:ParameterSet")
            elif (inline := binding.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)) is not None:
                check(self._path, f"a parameter set of {'.'.join(place) or 'the system'}", inline, "ssv:ParameterSet")
                values = inline
            else:
                continue
            values_by_name = {f"{binding.get('prefix', '')}{name}": given for name, given in parameters(values)}
            mapping = binding.find("ssd:ParameterMapping", NAMESPACES)
            if mapping is not None:
                values_by_name = self._mapped(values_by_name, mapping)
            for name, given in values_by_name.items():
                self._assign(place, name, given)

    def _check_binding(self, binding: Any, place: Path_) -> None:
        for entry in (binding, *binding.findall("ssd:ParameterMapping", NAMESPACES)):
            kind = entry.get("type", "")
            if kind and not kind.startswith("application/x-ssp-parameter-"):
                raise self._refused(place, f"given parameters of the type {kind!r}")
            if entry.get("sourceBase", "SSD") != "SSD":
                raise self._refused(place, "given parameters that stand inside a component")

    def _mapped(self, values_by_name: dict[str, Given], mapping: Any) -> dict[str, Given]:
        source = mapping.get("source")
        entries = (
            parsed(self._path, inside(self._path, self._folder, source), "ssm:ParameterMapping") if source else mapping
        )
        if not source:
            for inline in mapping:
                check(self._path, "a parameter mapping", inline, "ssm:ParameterMapping")
        mapped = {}
        for entry in entries.iter(f"{{{NAMESPACES['ssm']}}}MappingEntry"):
            name, target = entry.get("source", ""), entry.get("target", "")
            if len(entry):
                raise InputError(
                    f"{shown(self._path)}: the mapping of {name} to {target} has a transformation, which "
                    "orchestrate does not do"
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


def _named(end: End) -> str:
    return ".".join((*end.element, end.connector))


def parameters(values: Any) -> Iterator[tuple[str, Given]]:
    """Names and values of a parameter set."""
    units = {entry.get("name"): _unit(entry) for entry in values.findall("ssv:Units/ssc:Unit", NAMESPACES)}
    for parameter in values.findall("ssv:Parameters/ssv:Parameter", NAMESPACES):
        for entry in parameter:
            kind = entry.tag.rpartition("}")[2]
            if kind in ("Real", "Integer", "Boolean", "String", "Enumeration"):
                named = entry.get("unit")
                unit = units.get(named, Unit(named, None)) if named else None
                yield parameter.get("name", ""), Given(kind, entry.get("value", ""), unit)


def _unit(entry: Any) -> Unit:
    base = entry.find("ssc:BaseUnit", NAMESPACES)
    return Unit.from_base_unit(entry.get("name", ""), {} if base is None else base.attrib)


def read(path: Path, folder: Path, system: Any) -> Structure:
    """Returns what the outermost system of an unpacked archive holds. Raises InputError."""
    structure = Structure(where=str(shown(path)))
    _System(path, folder, structure).read(system, ())
    return structure
