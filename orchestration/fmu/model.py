"""What a block offers: its variables as vectors and matrices, and which output depends on which input.

description.py makes this of an FMU's modelDescription.xml; tests make it by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fmus.variables import Cycle

from ..errors import InputError, hint
from ..quantities import ONE, Unit
from .names import unescaped
from .types import Native, Type

Floats = NDArray[np.float64]
DTYPES: dict[str, type[np.generic]] = {
    "real": np.float64,
    "integer": np.int64,
    "enumeration": np.int64,
    "boolean": np.bool_,
}
"""The types that are exchanged and recorded, and NumPy's of the values that a result hands out."""
TYPES = tuple(DTYPES)
"""In the order in which a block's `wire` is given them."""


class Element(NamedTuple):
    """One scalar: the element at `position` (from 0, row by row) of a variable."""

    variable: str
    position: int


@dataclass(frozen=True)
class Variable:
    """A scalar, vector or matrix; the FMU's scalars `x[1]`, `x[2]` ... are the elements of `x`."""

    name: str
    causality: str
    type: Type = "real"
    shape: tuple[int, ...] = ()
    references: tuple[int, ...] = (0,)
    """FMI's value reference of each element; of an array of FMI 3.0, the one of the whole."""
    native: Native | None = None
    """FMI's type; None where no FMU stands behind it."""
    variability: str = "continuous"
    unit: Unit | None = None
    """Of all elements; where theirs differ, a list of their names, which fits its like only."""
    units: tuple[Unit | None, ...] = ()
    """Of each element, where they differ; else empty."""
    display_unit: Unit | None = None
    minima: tuple[float, ...] = ()
    maxima: tuple[float, ...] = ()
    """Limits of each element, infinite where there are none; empty for none at all."""
    nominal: float = 1.0
    """The usual size of its elements, the smallest of theirs; 1 in its unit where the FMU declares none, as FMI has
    it."""
    items: tuple[tuple[str, int], ...] = ()
    """Names and values of an enumeration."""
    description: str = ""
    first_index: tuple[int, ...] = ()
    """What FMI calls the first element: 1 or 0 in each dimension; 1 by default."""
    optional: bool = False
    """An input that may stay unconnected at its own start value, as its FMU says."""
    frame: str | None = None
    """The frame of its components, where an interface of the project names one; FMI has no place for it."""
    quantity: str | None = None
    """Of a parameter: the quantity that it states. All blocks of a loop should be given the same value of it."""

    @cached_property
    def size(self) -> int:
        return math.prod(self.shape)

    @property
    def dtype(self) -> Any:
        """NumPy's type of its values in a result; records hold all as doubles."""
        return DTYPES[self.type]

    @cached_property
    def elements(self) -> list[Element]:
        return [Element(self.name, position) for position in range(self.size)]

    @cached_property
    def is_array(self) -> bool:
        """Returns whether it is an array of FMI 3.0, which is exchanged in one piece."""
        return len(self.references) < self.size

    @property
    def items_text(self) -> str:
        """An enumeration's items for a message."""
        return ", ".join(f"{name} ({value})" for name, value in self.items) or "none"

    def at(self, positions: Sequence[int]) -> Variable:
        """The same with the unit of the elements at these positions."""
        if not self.units:
            return self
        unit, units = shared([self.units[position] for position in positions])
        return replace(self, unit=unit, units=units)

    def label(self, position: int) -> str:
        """The element's name, free of commas: `R_NB[1][2]`."""
        index = []
        for length in reversed(self.shape):
            position, i = divmod(position, length)
            index.append(i)
        first = self.first_index or (1,) * len(self.shape)
        return self.name + "".join(f"[{i + one}]" for i, one in zip(reversed(index), first, strict=True))

    @property
    def kind(self) -> str:
        """Type and shape in words: "a real [3, 3]"."""
        article = "an" if self.type[0] in "ie" else "a"
        return f"{article} {self.type} {list(self.shape) if self.shape else 'scalar'}"


def shared(units: Sequence[Unit | None]) -> tuple[Unit | None, tuple[Unit | None, ...]]:
    """`unit` and `units` of a variable whose elements have these."""
    if len(set(units)) == 1:
        return units[0], ()
    return Unit(", ".join("no unit" if unit is None else str(unit) for unit in units), None), tuple(units)


class NameUnknown(InputError):
    """The block has no such variable or element."""


@dataclass(frozen=True)
class Helper:
    """An input for engineers, such as an altitude, that stands for start values of parameters."""

    variable: Variable
    gives: str
    """The parameter that follows from it."""
    function: Callable[[Any, Mapping[str, Any]], Mapping[str, Any]]
    """Its value and the parameters in force, to the parameter with its value. Raises ValueError."""


@dataclass(frozen=True)
class Model:
    """A kind of block."""

    name: str
    variables: dict[str, Variable]
    feedthrough: dict[Element, frozenset[Element] | None] = field(default_factory=dict)
    """The inputs on which an output depends directly; None where the FMU does not say."""
    initial: dict[Element, frozenset[Element] | None] = field(default_factory=dict)
    """The same in initialization."""
    guid: str = ""
    tool: str = ""
    fmi: str = "2.0"
    """The version of FMI."""
    aliases: Mapping[str, str] = field(default_factory=dict)
    """Further names of variables (FMI 3.0)."""
    left_out: Mapping[str, str] = field(default_factory=dict)
    """What is not exchanged, by its name, and why (FMI 3.0)."""
    starts: Mapping[Element, Any] = field(default_factory=dict)
    """Values of inputs and parameters where a scenario gives none, as far as they are known."""
    helpers: Mapping[str, Helper] = field(default_factory=dict)
    """In the order in which they are to be worked out."""
    cycles: Mapping[str, Cycle] = field(default_factory=dict)
    """What a scenario's `cycle` of these names counts, where the block's parameters say how long it lasts."""
    needed: frozenset[str] = frozenset()
    """Outputs that a law in Python has to give, since other blocks take them in."""
    lacks: frozenset[str] = frozenset()
    """Parameters of the interface to which it is held that it does not have."""

    @property
    def prefix(self) -> str:
        """Prefix of the names of FMI's functions."""
        return f"fmi{self.fmi[0]}"

    def named(self, name: str) -> Variable | None:
        """The variable of this name or alias."""
        return self.variables.get(self.aliases.get(name, name))

    def native(self, element: Element) -> Native:
        """FMI's type of an element of an FMU."""
        native = self.variables[element.variable].native
        assert native is not None, "of an FMU"
        return native

    def of(self, *causalities: str) -> list[Variable]:
        return [v for v in self.variables.values() if v.causality in causalities]

    @cached_property
    def inputs(self) -> list[Element]:
        return [element for variable in self.of("input") for element in variable.elements]

    def find(
        self, block: str, name: str, index: tuple[int, ...] = (), of: Sequence[str] = (), kind: str = ""
    ) -> tuple[Variable, list[int]]:
        """The variable and the positions that a reference means. Raises NameUnknown, which names the nearest.

        A name may be written as `escaped` has it. The error offers those `of` causalities, and calls them `kind`;
        without a name of the block it speaks of another team's FMU.
        """
        name = name if name in self.variables else unescaped(name)
        name = self.aliases.get(name, name)
        listed = ",".join(map(str, index))
        for exact in (
            name + listed.join("[]").replace(",", "]["),
            f"{name}[{listed}]",
            f"{name}[{listed.replace(',', ', ')}]",
        ):
            if index and exact in self.variables:
                return self.variables[exact], [0]
        whole = f"{block}.{name}" if block else name
        if name in self.left_out:
            raise NameUnknown(f"{whole} is {self.left_out[name]}")
        if name not in self.variables:
            names = [v.name for v in self.variables.values() if not of or v.causality in of]
            names += self.helpers if "parameter" in of else ()
            kind = kind or " or ".join(of) or "variable"
            raise NameUnknown(f"{block or 'their FMU'} has no {kind} {name!r}{hint(name, names)}")
        variable = self.variables[name]
        if not index:
            return variable, list(range(variable.size))
        first = variable.first_index or (1,) * len(variable.shape)
        if len(index) != len(variable.shape):
            raise NameUnknown(f"{whole} is {variable.kind}; an element of it has {len(variable.shape)} indices")
        position = 0
        for i, one, length in zip(index, first, variable.shape, strict=True):
            if not one <= i < one + length:
                raise NameUnknown(f"{whole} is {variable.kind}; index {i} is outside {one} to {one + length - 1}")
            position = position * length + i - one
        return variable, [position]


def unit_of(variable: Variable) -> Unit:
    """Its unit, or the unit one."""
    return variable.unit or ONE
