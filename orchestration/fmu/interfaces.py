"""The interface that a block has to keep: one of the project's own, read as data, or that of a reference FMU."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

from fmus.block import start_values
from fmus.interface import BLOCKS, INTERFACES, LOOP, SETS, load

from ..errors import InputError, hint
from ..paths import located
from ..quantities import ONE, QuantityError, Unit, parse_unit
from .archive import open_fmu
from .model import Element, Helper, Model, Variable, shared

__all__ = ["Interface", "is_path", "own", "place", "reference"]


@dataclass(frozen=True)
class Interface:
    """A block's interface."""

    name: str
    model: Model
    starts: Mapping[Element, Any]
    """Start values; items of enumerations as numbers."""
    needed: frozenset[str] = frozenset()
    """Outputs that these take in by their names, and cannot do without."""
    others: Mapping[str, Model] = field(default_factory=dict)
    """The other blocks of the loop in which it stands, one in each place."""


def is_path(text: str) -> bool:
    """Returns whether this names a file, and no block of the project."""
    return text.endswith(".fmu") or "/" in text or "\\" in text


def own() -> tuple[str, ...]:
    """The names of the project's own interfaces."""
    return BLOCKS


def reference(name: str, folder: Path) -> Interface:
    """The interface of this name, or of the FMU at this path. Raises InputError."""
    if is_path(name):
        fmu = open_fmu(located(name, folder).resolve())
        return Interface(fmu.model.name, fmu.model, fmu.model.starts)
    if name not in own():
        ending = hint(name, own())
        raise InputError(f"this project has no interface {name!r}{ending}; the path of a reference FMU ends in .fmu")
    interface = load(name)
    loop = {block: load(block) for block in LOOP if block != place(name)}
    taken = {v.name for other in loop.values() for v in other.of("input") if not v.optional}
    needed = frozenset(v.name for v in interface.of("output") if v.name in taken)
    others = {block: replace(_model(other), starts=_starts(other)) for block, other in loop.items()}
    return Interface(name, _model(interface), _starts(interface), needed, others)


def _starts(interface: Any) -> dict[Element, Any]:
    return {
        Element(variable.name, position): element.start
        for variable in interface.variables.values()
        for position, element in enumerate(variable.elements)
        if element.start is not None
    }


@cache
def pages() -> Mapping[str, Mapping[str, Any]]:
    """Returns what a page that flies offers of blocks with the project's own interfaces, by their names."""
    own_ = tomllib.loads((INTERFACES / "pages.toml").read_text("utf-8"))
    parts = {block: (own_.get(block, {}), own_.get(SETS[block][0] if block in SETS else "", {})) for block in BLOCKS}
    return {b: {key: [*x.get(key, ()), *y.get(key, ())] for key in {**x, **y}} for b, (x, y) in parts.items()}


def view(block: str) -> Mapping[str, Any]:
    """Returns what a three-dimensional view takes of a block with one of the project's own interfaces; nothing of any
    other.
    """
    return load(block).view if block in own() else {}


def in_steps(block: str) -> dict[str, str]:
    """The parameters of one of the project's own interfaces that are times of so many steps: "whole" or "at least
    one"."""
    return {v.name: v.steps for v in load(block).of("parameter") if v.steps} if block in own() else {}


def helpers(block: str) -> dict[str, Helper]:
    """The helper inputs of one of the project's own interfaces; none of any other."""
    declared = load(block).helpers.values() if block in own() else ()
    return {v.name: Helper(_variable(v), v.gives, partial(start_values, block, v.name)) for v in declared}


def with_inputs(model: Model, block: str) -> Model:
    """A model with the helper inputs and cycles of this interface."""
    return replace(model, helpers=helpers(block), cycles=load(block).cycles if block in own() else {})


def place(block: str) -> str:
    """Returns where a block stands in the loop: `allocator_bounded` in the place of `allocator`."""
    return block.partition("_")[0]


def _model(interface: Any) -> Model:
    variables = {variable.name: _variable(variable) for variable in interface.variables.values()}
    place = {
        element.value_reference: Element(variable.name, position)
        for variable in interface.variables.values()
        for position, element in enumerate(variable.elements)
    }
    direct: dict[Element, frozenset[Element] | None] = {}
    initial: dict[Element, frozenset[Element] | None] = {}
    for variable in interface.of("output"):
        for position in range(len(variable.elements)):
            element = Element(variable.name, position)
            feeds = interface.feedthrough(variable, position)
            first = interface.initial_dependencies(variable, position)
            direct[element] = frozenset(place[e.value_reference] for e in feeds)
            inputs = (place[e.value_reference] for e in first)
            initial[element] = frozenset(e for e in inputs if variables[e.variable].causality == "input")
    return Model(interface.name, variables, direct, initial)


def _variable(variable: Any) -> Variable:
    unit, apart = shared([_named(name) if variable.type == "real" else None for name in variable.units])
    limits = range(len(variable.elements))
    return Variable(
        name=variable.name,
        causality=variable.causality,
        type=variable.type,
        shape=variable.shape,
        references=tuple(variable.value_references),
        variability=variable.variability,
        unit=unit,
        units=apart,
        display_unit=_named(variable.display_unit) if variable.display_unit else None,
        minima=tuple(-float("inf") if variable.min is None else float(variable.min) for _ in limits),
        maxima=tuple(float("inf") if variable.max is None else float(variable.max) for _ in limits),
        nominal=min(nominal or 1.0 for nominal in variable.nominals),
        items=tuple((item, number) for number, item in enumerate(variable.items, start=1)),
        description=variable.description,
        optional=variable.optional,
        frame=variable.frame,
        quantity=variable.quantity,
    )


def _named(unit: str | None) -> Unit:
    try:
        return parse_unit(unit) if unit else ONE
    except QuantityError:  # an interface may name what only its own FMU defines
        return Unit(unit or "", None)
