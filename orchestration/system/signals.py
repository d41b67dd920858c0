"""Names of signals in a scenario: which elements they mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from fnmatch import fnmatchcase
from typing import Protocol, Unpack

from ..errors import Fields, InputError, Problem, Problems, hint
from ..fmu.model import TYPES, Element, Model, Variable
from ..fmu.names import escaped
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .wiring import Node


class Places(Protocol):
    """Object that knows where each part of a file stands: a scenario, or the source of another file."""

    def error(self, key: Key, text: str = "", **fields: Unpack[Fields]) -> Problem:
        """Returns an error at the place of a key."""

    def naming(self, key: Key) -> AbstractContextManager[None]:
        """Places at a key the errors of what stands or is named there."""


def find(places: Places, key: Key, reference: Reference, models: Mapping[str, Model]) -> tuple[Variable, list[Node]]:
    """The elements that one reference means. Raises InputError at the given place."""
    block = reference.block
    if block not in models:
        raise InputError(places.error(key, f"there is no block {block!r}{hint(block, models)}"))
    with places.naming(key):
        variable, positions = models[block].find(block, reference.variable, reference.indices)
    if variable.type not in TYPES:
        raise InputError(places.error(key, f"{reference} is text, which cannot be recorded"))
    return variable.at(positions), [Node(block, Element(variable.name, position)) for position in positions]


def flag(places: Places, key: Key, reference: Reference, models: Mapping[str, Model]) -> Node:
    """Returns the element that a reference to one boolean means. Raises InputError at the given place."""
    variable, nodes = find(places, key, reference, models)
    if variable.type != "boolean" or len(nodes) != 1:
        raise InputError(places.error(key, f"expected one boolean, but {reference} is {variable.kind}"))
    return nodes[0]


def recorded(scenario: Scenario, models: Mapping[str, Model]) -> list[Node]:
    """All elements that `record.signals` asks for, in order; by default all outputs of all blocks."""
    nodes: dict[Node, None] = {}
    if scenario.record.signals is None:
        for block, model in models.items():
            nodes.update((Node(block, e), None) for v in model.of("output") if v.type in TYPES for e in v.elements)
    elif not scenario.record.signals and scenario.source.file is not None:
        message = "must not be empty; without it all outputs of all blocks are recorded"
        raise InputError(scenario.error(("record", "signals"), message))
    with Problems() as problems:
        for number, reference in enumerate(scenario.record.signals or ()):
            key: Key = ("record", "signals", number)
            with problems.gathered():
                matches = (
                    _matching(scenario, key, reference, models)
                    if not isinstance(reference, Reference)
                    else find(scenario, key, reference, models)[1]
                )
                nodes.update(dict.fromkeys(matches))
    return list(nodes)


def flags(models: Mapping[str, Model]) -> list[Node]:
    """All boolean outputs: recorded whatever was asked for, so that no flag is overlooked in the manifest."""
    return [
        Node(block, element)
        for block, model in models.items()
        for variable in model.of("output")
        if variable.type == "boolean"
        for element in variable.elements
    ]


def _matching(scenario: Scenario, key: Key, pattern: str, models: Mapping[str, Model]) -> list[Node]:
    """The outputs whose names match `block.*`, `*.omega_*` and the like."""
    literal = re.sub(r"([\[\]?])", r"[\1]", pattern)  # only the star is special
    matches = [
        Node(block, element)
        for block, model in models.items()
        for variable in model.of("output")
        if variable.type in TYPES and fnmatchcase(f"{block}.{variable.name}", literal)
        for element in variable.elements
    ]
    if not matches:
        raise InputError(scenario.error(key, f"no output matches {pattern!r}"))
    return matches


def label(node: Node, models: Mapping[str, Model]) -> str:
    """Its name in results: `plant.R_NB[1][2]`, free of commas."""
    return f"{node.block}.{escaped(models[node.block].variables[node.element.variable].label(node.element.position))}"


def names(nodes: Iterable[Node], models: Mapping[str, Model]) -> list[str]:
    """Names of the variables of which all elements are among the nodes, and of single elements of the others."""
    nodes = dict.fromkeys(nodes)
    whole: dict[str, None] = {}
    for node in nodes:
        variable = models[node.block].variables[node.element.variable]
        complete = all(Node(node.block, element) in nodes for element in variable.elements)
        whole[f"{node.block}.{escaped(variable.name)}" if complete else label(node, models)] = None
    return list(whole)
