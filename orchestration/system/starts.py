"""Start values of a scenario: shared ones, those of each block, and what helper inputs (an altitude) stand for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import InputError, Place, Problem, hint, nearest, suggestion
from ..fmu.model import Element, Model, NameUnknown, Variable
from ..quantities import QuantityError
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from .values import Scalar, nested, values_of


@dataclass(frozen=True)
class Start:
    """A value to be set before initialization, as FMI stores it: items of enumerations as numbers."""

    element: Element
    value: Scalar


def resolve(
    scenario: Scenario, models: Mapping[str, Model], known: Mapping[str, list[Start]] | None = None
) -> dict[str, list[Start]]:
    """The start values of each block; `known` are those of blocks that are resolved already.

    Raises InputError with everything that is wrong.
    """
    starts: dict[str, list[Start]] = dict(known or {})
    errors = _untaken(scenario, models) if known is None else []
    beaten, reached = dict[Key, str](), set[Key]()
    for block in [name for name in models if name not in starts]:
        given = _Given(scenario, block, models[block])
        starts[block] = [Start(element, value) for element, value in given.values().items()]
        errors += given.errors
        shared, own = given.layers
        for element, key in shared.keys.items():
            if element in own.values:
                beaten.setdefault(key, block)
            else:
                reached.add(key)
    for key in [key for key in beaten if known is None and key in scenario.source.options and key not in reached]:
        text = f"reaches no block, since {beaten[key]} has a value of its own"
        errors.append(scenario.error(key, text, remedy=f"--set {beaten[key]}.{key[-1]}=..."))
    if errors:
        raise InputError(*dict.fromkeys(errors))
    return starts


def taken(model: Model, name: Name) -> Name | None:
    """Returns what a block calls a shared value: its parameter of this quantity, or of this name; None where it has
    none.
    """
    if name.variable in model.helpers:
        return name
    of = {v.quantity: v for v in model.of("parameter") if v.quantity}
    variable = of.get(name.variable) or model.variables.get(name.variable)
    if variable is None or variable.causality != "parameter" or variable.quantity not in (None, name.variable):
        return None
    return Name(variable.name + name[len(name.variable) :])


def _untaken(scenario: Scenario, models: Mapping[str, Model]) -> list[Problem]:
    """Errors: shared values that no block takes."""
    known = {v.quantity or v.name for model in models.values() for v in model.of("parameter")}
    known |= {name for model in models.values() for name in model.helpers}
    errors = []
    for name, value in scenario.shared.items():
        if not any(taken(model, name) or name.variable in model.lacks for model in models.values()):
            text, remedy = f"no block has a parameter {name.variable!r}{hint(name.variable, known)}", ""
            if name.variable in type(scenario).model_fields:
                text = f"{name.variable} is no parameter but a key of the scenario"
                remedy = f"--{name} '{value}'" if name in TIMES else f"a file that extends it and has {name.variable!r}"
            elif (near := nearest(name.variable, {*known, *TIMES})) in TIMES:
                text, remedy = f"no block has a parameter {name.variable!r}{suggestion(near)}", f"--{near} '{value}'"
            errors.append(scenario.error(("shared", name), text, remedy=remedy))
    return errors


TIMES = ("duration", "step")
"""Keys of a scenario that have an option of their own, and are no start values."""


_Values = Callable[[Name, Any], dict[Element, Scalar]]
_Entry = tuple[Name, Key, Any]


@dataclass
class _Layer:
    """Values that stand in one place: the shared ones, or those of a block."""

    values: dict[Element, Scalar] = field(default_factory=dict)
    keys: dict[Element, Key] = field(default_factory=dict)


class _Given:
    """Start values that a scenario gives a block; errors are collected."""

    def __init__(self, scenario: Scenario, block: str, model: Model) -> None:
        self.scenario, self.block, self.model = scenario, block, model
        self.errors: list[Problem] = []
        self.layers = (_Layer(), _Layer())
        own: Key = ("blocks", block, "start")
        stated, options = scenario.blocks[block].start, scenario.source.options
        shared = [(taken(model, name), ("shared", name), value) for name, value in scenario.shared.items()]
        self._entries: tuple[list[_Entry], list[_Entry]] = (
            # A value that the block states itself need not fit its shape: the axis of one wheel beside those of a set.
            [(name, key, v) for name, key, v in shared if name and (key in options or name not in stated)],
            [(name, (*own, name), value) for name, value in scenario.blocks[block].start.items()],
        )

    def values(self) -> dict[Element, Scalar]:
        for layer, entries in zip(self.layers, self._entries, strict=True):
            for name, key, value in entries:
                if name.variable not in self.model.helpers:
                    self._put(layer, key, name, value, self._plain)
        for helper in self.model.helpers:  # in their order, since one may rest on what another gives
            for layer, entries in zip(self.layers, self._entries, strict=True):
                for name, key, value in entries:
                    if name.variable == helper:
                        self._put(layer, key, name, value, self._helped)
        return self._together()

    def _together(self) -> dict[Element, Scalar]:
        shared, own = self.layers
        return shared.values | own.values

    def _put(self, layer: _Layer, key: Key, name: Name, value: Any, values: _Values) -> None:
        above = self._above(key)
        try:
            given = values(name, value)
            for element in given:
                first = layer.keys.get(element, key)
                if first != key and self._above(first) == above:
                    raise QuantityError(f"has a start value already, by {first[-1]!r}{self._line(first, key)}")
            # An option takes the place of what the file says, and the file that of what files say that it extends.
            kept = {e: value for e, value in given.items() if self._above(layer.keys.get(e, key)) <= above}
            layer.values |= kept
            layer.keys |= dict.fromkeys(kept, key)
        except (QuantityError, NameUnknown) as error:
            self.errors.append(Problem(str(error), place=self._place(key)))

    def _above(self, key: Key) -> int:
        source = self.scenario.source
        return 2 if key in source.options else int(source.files.get(key, source.file) == source.file)

    def _line(self, first: Key, key: Key) -> str:
        source = self.scenario.source
        line, file = source.lines.get(first), source.files.get(first)
        return f", in line {line}{'' if file == source.files.get(key) else f' of {file}'}" if line else ""

    def _place(self, key: Key) -> Place:
        """Returns the place of a value, which ends with the variable's name only where the variable is known."""
        place, name = self.scenario.source.place(key), Name(str(key[-1])).variable
        known = name in self.model.variables or name in self.model.helpers
        return place if known else Place(str(place).removesuffix(f".{key[-1]}"))

    def _plain(self, name: Name, value: Any) -> dict[Element, Scalar]:
        return values_of(self.block, self.model, name, value)

    def _helped(self, name: Name, value: Any) -> dict[Element, Scalar]:
        """The values that a helper input stands for, by the block's own function."""
        helper = self.model.helpers[name.variable]
        if name.indices:
            raise QuantityError(f"{name.variable} is given as a whole, found {name!r}")
        variable = helper.variable
        alone = Model(self.model.name, {variable.name: variable})
        own = nested(variable, list(values_of(self.block, alone, name, value).values()))
        in_force = {**self.model.starts, **self._together()}
        parameters = {v.name: in_words(v, in_force) for v in self.model.of("parameter") if v.elements[0] in in_force}
        try:
            derived = helper.function(own, parameters)
        except ValueError as error:
            raise QuantityError(str(error)) from None
        values: dict[Element, Scalar] = {}
        for given, number in derived.items():
            values |= values_of(self.block, self.model, Name(given), number)
        return values


def in_words(variable: Variable, values: Mapping[Element, Any]) -> Any:
    """A parameter's value in force: nested lists of its shape, items of enumerations by their names."""
    names = {number: item for item, number in variable.items}
    return nested(variable, [names.get(values[element], values[element]) for element in variable.elements])
