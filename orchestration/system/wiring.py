"""Checks what a scenario connects, and makes links of it: which element feeds which, with the change of unit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from ..errors import InputError, Place, Problem, Problems, hint, naming
from ..fmu.model import Element, Model, Variable
from ..scenario.references import Connection, Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key


class Node(NamedTuple):
    """An element of a block's variable."""

    block: str
    element: Element


@dataclass(frozen=True)
class Link:
    """Element by element: target = factor * source + offset."""

    text: str
    source: tuple[Node, ...]
    target: tuple[Node, ...]
    factor: float = 1.0
    offset: float = 0.0
    delayed: bool = False


@dataclass
class Wiring:
    links: list[Link] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def sources(self) -> dict[Node, Node]:
        """The output that feeds an input, without those that come delayed."""
        return {t: s for link in self.links if not link.delayed for s, t in zip(link.source, link.target, strict=True)}


class _End(NamedTuple):
    block: str
    variable: Variable
    positions: list[int]
    own: bool = False
    """Whether its unit is that of this element, and perhaps of no other."""

    @property
    def name(self) -> str:
        """Name of the whole, or of the element whose unit is looked at."""
        alone = len(self.positions) == 1 < self.variable.size and self.own
        return f"{self.block}.{self.variable.label(self.positions[0]) if alone else self.variable.name}"

    @property
    def elements(self) -> list[_End]:
        """One by one, each with its own unit."""
        return [_End(self.block, self.variable.at([p]), [p], True) for p in self.positions]

    @property
    def nodes(self) -> tuple[Node, ...]:
        return tuple(Node(self.block, Element(self.variable.name, p)) for p in self.positions)

    @property
    def single(self) -> bool:
        return len(self.positions) == 1


def connect(scenario: Scenario, models: Mapping[str, Model]) -> Wiring:
    """All connections of the scenario. Raises InputError with everything that is wrong."""
    wiring = Wiring()
    taken: dict[Node, str] = {}
    with Problems() as problems:
        delays = _delays(scenario, models, problems)
        for number, text in enumerate(scenario.connections):
            key: Key = ("connections", number)
            with problems.gathered(), scenario.naming(key), naming(Place(text)):
                made, warnings = links(text, models, delays)
                targets = [node for link in made for node in link.target]
                if twice := [node for node in targets if node in taken]:
                    raise InputError(f"{_name(twice[0], models)} already has a source: {taken[twice[0]]}")
                taken.update(dict.fromkeys(targets, text))
                wiring.links += made
                wiring.warnings += [scenario.note(key, warning) for warning in warnings]
        if not problems:
            problems += _undelayed(scenario, delays, taken) + _unconnected(scenario, models, taken)
            wiring.warnings += _unused_starts(scenario, models, taken, delays)
    return wiring


def fed(scenario: Scenario, block: str, ports: Iterable[Variable]) -> list[Variable]:
    """The inputs among these that a scenario feeds: an optional one may be neither connected nor given a value."""
    given = {connection.target.whole for connection in scenario.connections}
    given |= {f"{block}.{name.variable}" for name in scenario.blocks[block].start}
    return [v for v in ports if v.causality == "input" and (not v.optional or f"{block}.{v.name}" in given)]


def links(text: Connection, models: Mapping[str, Model], delays: Mapping[Node, int]) -> tuple[list[Link], list[str]]:
    """A connection as one link, or, where its elements have units of their own, one for each change of unit; and
    warnings.

    Raises InputError, without a place.
    """
    source, target = _end(text.source, models, "output"), _end(text.target, models, "input")
    if source.variable.type != target.variable.type:
        raise InputError(f"{source.name} is {source.variable.type}, {target.name} is {target.variable.type}")
    if source.variable.type == "string":
        raise InputError("text cannot be connected")
    if source.variable.items != target.variable.items:
        raise InputError(
            f"the enumerations differ: {source.name} has {source.variable.items_text}, {target.name} has "
            f"{target.variable.items_text}"
        )
    alike = source.variable.shape == target.variable.shape and len(source.positions) == len(target.positions)
    if not alike and not (source.single and target.single):
        raise InputError(f"the shapes differ: {_shape(source)}, {_shape(target)}")
    delayed = {node in delays for node in target.nodes}
    if len(delayed) != 1:
        raise InputError("either all elements of a connection are delayed or none")
    pairs = list(zip(source.elements, target.elements, strict=True))
    if not (source.variable.units or target.variable.units):
        pairs = [(source, target)]
    groups: dict[tuple[float, float], list[tuple[_End, _End]]] = {}
    warnings: dict[str, None] = {}
    for pair in pairs:
        factor, offset, warning = _conversion(*pair)
        groups.setdefault((factor, offset), []).append(pair)
        warnings.update({warning: None} if warning else {})
    made = [
        Link(
            text,
            tuple(node for end, _ in group for node in end.nodes),
            tuple(node for _, end in group for node in end.nodes),
            *change,
            delayed=True in delayed,
        )
        for change, group in groups.items()
    ]
    return made, list(warnings)


def _end(reference: Reference, models: Mapping[str, Model], causality: str) -> _End:
    block = reference.block
    if block not in models:
        raise InputError(f"there is no block {block!r}{hint(block, models)}")
    variable, positions = models[block].find(block, reference.variable, reference.indices, (causality,))
    if variable.causality != causality:
        article = "an" if variable.causality[0] in "aeio" else "a"
        raise InputError(
            f"{block}.{variable.name} is {article} {variable.causality}; expected an {causality} of {block}"
        )
    return _End(block, variable, positions)


def _conversion(source: _End, target: _End) -> tuple[float, float, str]:
    given, wanted = source.variable.unit, target.variable.unit
    if source.variable.type != "real" or given == wanted:
        return 1.0, 0.0, ""
    if given is None or wanted is None:
        bare, other, unit = (source, target, wanted) if given is None else (target, source, given)
        return 1.0, 0.0, f"{bare.name} has no unit, so that of {other.name}, {unit}, is taken for granted"
    if given.exponents is None or wanted.exponents is None:
        unknown = given if given.exponents is None else wanted
        if given.name == wanted.name:
            return 1.0, 0.0, ""
        fed = f"{source.name} in {given} feeds {target.name} in {wanted} as it is"
        return 1.0, 0.0, f"{fed}, since the FMU does not define the unit {unknown}"
    if not given.fits(wanted):
        raise InputError(f"the units do not fit: {source.name} is in {given}, {target.name} in {wanted}")
    return *given.conversion(wanted), ""


def _delays(scenario: Scenario, models: Mapping[str, Model], problems: Problems) -> dict[Node, int]:
    """Every input that is to be fed with a delay, with its place in the list."""
    delayed: dict[Node, int] = {}
    for number, text in enumerate(scenario.delays):
        with problems.gathered(), scenario.naming(("delays", number)):
            delayed.update(dict.fromkeys(_end(text, models, "input").nodes, number))
    return delayed


def _undelayed(scenario: Scenario, delays: Mapping[Node, int], taken: Mapping[Node, str]) -> list[Problem]:
    idle = {number for node, number in delays.items() if node not in taken}
    return [
        scenario.error(("delays", n), f"{scenario.delays[n]} is fed by no connection that could be delayed")
        for n in sorted(idle)
    ]


def _unconnected(scenario: Scenario, models: Mapping[str, Model], taken: Mapping[Node, str]) -> list[Problem]:
    errors = []
    for block, model in models.items():
        started = {name for key in scenario.blocks[block].start for name in (key, key.variable)}
        started |= {model.aliases[name] for name in started & model.aliases.keys()}
        for variable in model.of("input"):
            free = [p for p in range(variable.size) if Node(block, Element(variable.name, p)) not in taken]
            whole = len(free) == variable.size
            if not free or variable.name in started or (whole and variable.optional):
                continue
            names = variable.name if whole else ", ".join(map(variable.label, free))
            remedy = "a connection, or a value under 'start'"
            if variable.optional:
                remedy += f"; {variable.name} is optional: it may also stay unconnected as a whole"
            text = f"the input {names} is neither connected nor given a value"
            errors.append(scenario.error(("blocks", block), text, remedy=remedy))
    return errors


def _unused_starts(
    scenario: Scenario, models: Mapping[str, Model], taken: Mapping[Node, str], delays: Mapping[Node, int]
) -> list[str]:
    warnings = []
    for block, entry in scenario.blocks.items():
        for name in entry.start:
            variable = models[block].variables.get(name)
            nodes = [Node(block, element) for element in variable.elements] if variable else []
            if nodes and all(node in taken and node not in delays for node in nodes):
                message = f"this value is never seen, since the input is connected: {taken[nodes[0]]}"
                warnings.append(scenario.note(("blocks", block, "start", name), message))
    return warnings


def _name(node: Node, models: Mapping[str, Model]) -> str:
    return f"{node.block}.{models[node.block].variables[node.element.variable].label(node.element.position)}"


def _shape(end: _End) -> str:
    if len(end.positions) == end.variable.size:
        return f"{end.name} is {end.variable.kind}"
    return f"{end.block}.{end.variable.label(end.positions[0])} is one element"
