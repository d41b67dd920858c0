"""Ports and parameters of a block's interface, element by element as FMI sees them. Tests: tests/fmus/test_rules.py."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

FLAVOURS = ("native", "python")
Causality = Literal["input", "output", "parameter"]
Type = Literal["real", "integer", "boolean", "string", "enumeration"]
Scalar = float | int | bool | str
STEPS = ("whole", "at least one")


class InterfaceError(ValueError):
    """An interface file is wrong; the message names file and variable."""


@dataclass(frozen=True)
class Element:
    """One scalar FMI variable: an element of a `Variable`."""

    name: str
    value_reference: int
    start: Scalar | None
    """As FMI stores it: an enumeration's is its one-based item number. None for outputs."""


@dataclass(frozen=True)
class Variable:
    """A port or parameter as a whole: scalar, vector or matrix."""

    name: str
    causality: Causality
    type: Type
    variability: str
    description: str
    shape: tuple[int, ...]
    units: tuple[str | None, ...]
    """Of each element."""
    display_unit: str | None
    nominals: tuple[float | None, ...]
    """The size that is usual, of each element; None means 1."""
    frame: str | None
    start: Any
    """Nested lists of the given shape, or a scalar; an enumeration's is its item's name."""
    min: float | None
    max: float | None
    items: tuple[str, ...]
    elements: tuple[Element, ...]
    depends_on: tuple[str, ...] = ()
    initially_depends_on: tuple[str, ...] = ()
    optional: bool = False
    """An input that may stay unconnected; its start then says so."""
    quantity: str | None = None
    """Of a parameter: the quantity that it states, the same in every block of a loop."""
    steps: str | None = None
    """Of a parameter that is a time: how many steps of its block it has to be, one of `STEPS`."""
    each: str | None = None
    """The set of parts, such as "wheel", of which each one has this variable."""
    gives: str = ""
    """Of a helper input: the parameter that follows from it."""
    of_shell: bool = False
    """A parameter that the FMU's shell acts on; the block's own structures do not have it."""

    @property
    def bounds(self) -> tuple[float | None, float | None]:
        """The least and the largest value that the block takes; those of an input are told to tools only."""
        if self.type == "enumeration":
            return 1, len(self.items)
        return (None, None) if self.causality == "input" else (self.min, self.max)

    @property
    def unit(self) -> str | None:
        """In words: the unit of all elements, or, where they differ, those of the elements in their order."""
        return self.units[0] if len(set(self.units)) == 1 else ", ".join(unit or "1" for unit in self.units)

    @property
    def value_references(self) -> list[int]:
        return [element.value_reference for element in self.elements]


@dataclass(frozen=True)
class Cycle:
    """Duration of one of what a scenario counts, such as an orbit of the plant."""

    by: str
    """The parameter, an enumeration, whose item says which expression holds."""
    periods: dict[str, str]
    """By item: an expression of parameters in SI units, s."""
    uses: frozenset[str]
    """The parameters on which the period depends."""


@dataclass(frozen=True)
class Interface:
    """All variables of a block, in the order of the file; value references count their elements from 0."""

    name: str
    description: str
    stop: float
    step: float
    variables: dict[str, Variable]
    source: str = field(repr=False, default="")
    """The text of the TOML file."""
    terminals: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Variables that are wired together, by the name of their terminal."""
    equations: tuple[tuple[str, str], ...] = ()
    """Formulas, each with its meaning, for the documentation page."""
    limits: tuple[str, ...] = ()
    """Sentences for the documentation page."""
    flavours: tuple[str, ...] = FLAVOURS
    """Those that the block has."""
    helpers: dict[str, Variable] = field(default_factory=dict)
    """Inputs of scenarios that stand for start values; no FMU has them."""
    cycles: dict[str, Cycle] = field(default_factory=dict)
    """By the name that a scenario's `cycle` has."""
    code: str = ""
    """The block whose code it runs: another one where this is the interface for a set of parts."""
    sets: dict[str, int] = field(default_factory=dict)
    """How many parts each set of the file has in this interface at most, by the set's name."""
    derivatives: bool = False
    """Whether its FMU of FMI 3.0 gives directional and adjoint derivatives."""
    view: dict[str, Any] = field(default_factory=dict)
    """The part of this block in a three-dimensional view of a loop, as the file has it."""

    def of(self, causality: Causality) -> list[Variable]:
        """Those of the block itself: not what its shell has."""
        return [v for v in self.variables.values() if v.causality == causality and not v.of_shell]

    @cached_property
    def elements(self) -> dict[str, tuple[Variable, Element]]:
        """Every scalar variable by its FMI name."""
        return {e.name: (v, e) for v in self.variables.values() for e in v.elements}

    def feedthrough(self, variable: Variable, position: int) -> list[Element]:
        """The inputs on which element `position` (from 0) of an output depends directly."""
        return list(self._resolve(variable.depends_on, variable, position))

    def initial_dependencies(self, variable: Variable, position: int) -> list[Element]:
        """The inputs and parameters on which element `position` of an output depends initially."""
        return list(self._resolve(variable.initially_depends_on, variable, position))

    def _resolve(self, names: tuple[str, ...], output: Variable, position: int) -> Iterator[Element]:
        i = position // output.shape[1] if len(output.shape) == 2 else position
        for name in names:
            base, _, index = name.partition("[")
            known = self.variables[base]
            if index == "i]":
                yield known.elements[position]
            elif index == "i,:]":
                yield from known.elements[i * known.shape[1] : (i + 1) * known.shape[1]]
            elif index == ":,i]":
                yield from known.elements[i :: known.shape[1]]
            else:
                yield from known.elements
