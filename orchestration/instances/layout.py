"""Where the elements of a block lie in what one Get or Set of FMI exchanges, which takes an array of FMI 3.0 as a
whole."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..fmu.model import TYPES, Element, Floats, Model
from ..fmu.types import Native
from .calls import Exchange, Part, follow


class Layout(NamedTuple):
    """Some elements of one type of FMI in one call."""

    references: list[int]
    slots: list[int]
    """Where each element is in FMI's buffer."""
    length: int
    """Values in the buffer."""
    arrays: dict[str, int]
    """Where each array begins there."""

    @classmethod
    def of(cls, model: Model, elements: Sequence[Element]) -> Layout:
        if model.prefix == "fmi2":  # without arrays
            scalars = [model.variables[name].references[position] for name, position in elements]
            return cls(scalars, list(range(len(scalars))), len(scalars), {})
        references: list[int] = []
        slots: list[int] = []
        arrays: dict[str, int] = {}
        first: dict[tuple[str, int], int] = {}
        length = 0
        for element in elements:
            variable = model.variables[element.variable]
            part = 0 if variable.is_array else element.position
            if (element.variable, part) not in first:
                first[element.variable, part] = length
                references.append(variable.references[part])
                if variable.is_array:
                    arrays[element.variable] = length
                length += variable.size if variable.is_array else 1
            slots.append(first[element.variable, part] + element.position - part)
        return cls(references, slots, length, arrays)


class Arrays:
    """The values that arrays have been set to: who sets some elements has to set the others with them."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._held: dict[str, NDArray[Any]] = {}

    def into(self, layout: Layout, buffer: NDArray[Any]) -> dict[str, NDArray[Any]]:
        """Each array's stretch in the buffer, which is given the values that were set last, or the start values."""
        parts: dict[str, NDArray[Any]] = {}
        for name, first in layout.arrays.items():
            variable = self._model.variables[name]
            if name not in self._held:
                self._held[name] = np.array(self._starts(name), buffer.dtype)
            parts[name] = buffer[first : first + variable.size]
            parts[name][:] = self._held[name]
        return parts

    def _starts(self, name: str) -> list[Any]:
        return [self._model.starts.get(element, 0) for element in self._model.variables[name].elements]

    def reset(self) -> None:
        """Holds the start values again."""
        for name, held in self._held.items():
            held[:] = self._starts(name)

    def keep(self, parts: dict[str, NDArray[Any]]) -> None:
        """Takes over values that have been set."""
        for name, part in parts.items():
            self._held[name][:] = part

    def share(self, parts: dict[str, NDArray[Any]]) -> None:
        """Holds the values in these stretches from now on."""
        self._held |= parts


def exchanges(
    verb: str,
    model: Model,
    elements: Sequence[Element],
    live: Sequence[int],
    values: Floats,
    function: Callable[[str], Any],
    arrays: Arrays | None = None,
) -> list[Exchange]:
    """A Get or Set for each type of FMI that occurs; `elements` and `live` as in `block.Block.wire`.

    `function` finds one of FMI's by its name. `arrays` are those that are set.
    """
    groups: dict[Native, list[int]] = {}
    for place, element in enumerate(elements):
        groups.setdefault(model.native(element), []).append(place)
    counts = [sum(len(places) for native, places in groups.items() if native.type == kind) for kind in TYPES]
    ends = dict(zip(TYPES, np.cumsum([0, *counts[:-1]]) + live, strict=True))
    made = []
    for native, places in groups.items():
        members = [elements[place] for place in places]
        layout = Layout.of(model, members)
        some = Layout.of(model, members[: bisect_left(places, ends[native.type])])
        where, slots = np.array(places, np.int64), np.array(layout.slots, np.int64)
        direct = native.code == "f8" and follow(where) and layout.slots == list(range(layout.length))
        buffer = values[places[0] : places[-1] + 1] if direct else np.zeros(layout.length, native.code)
        if arrays is not None:
            arrays.share(arrays.into(layout, buffer))
        name = f"{model.prefix}{verb}{native.function}"
        parts = (Part(len(it.references), it.length, len(it.slots)) for it in (some, layout))
        called = name, function(name), native, verb == "Set", np.array(layout.references, np.uint32)
        made.append(Exchange(*called, members, values, where, slots, buffer, direct, *parts))
    return made
