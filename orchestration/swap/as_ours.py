"""Theirs as a block of our interface: its variables, and on which inputs its outputs depend."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from ..fmu.model import Element, Model
from .findings import Fit, may_stay_unconnected


def model(fitted: Fit) -> Model:
    """Theirs as a block of our interface: our names, units and shapes, and under their own names what only they have."""
    variables = {
        name: replace(link.ours, optional=may_stay_unconnected(fitted, link)) for name, link in fitted.links.items()
    }
    variables |= {name: ours for name, ours in fitted.ignored.items() if ours.causality != "output"}
    variables |= {variable.name: variable for variable in fitted.extra}
    back: dict[Element, list[Element]] = {}
    for link in fitted.links.values():
        if link.ours.causality == "input":
            for row, element in enumerate(link.theirs):
                columns = range(link.ours.size) if link.A is None else np.flatnonzero(link.A[row]).tolist()
                back.setdefault(element, []).extend(Element(link.ours.name, column) for column in columns)
    for variable in fitted.extra:
        back.update((element, [element]) for element in variable.elements)

    def ours_of(declared: Mapping[Element, frozenset[Element] | None]) -> dict[Element, frozenset[Element] | None]:
        deps: dict[Element, frozenset[Element] | None] = {}
        for link in fitted.links.values():
            if link.ours.causality == "output":
                for row in range(link.ours.size):
                    columns = range(len(link.theirs)) if link.B is None else np.flatnonzero(link.B[row]).tolist()
                    deps[Element(link.ours.name, row)] = _union((declared.get(link.theirs[j]) for j in columns), back)
        for variable in fitted.extra:
            if variable.causality == "output":
                deps.update((element, _union([declared.get(element)], back)) for element in variable.elements)
        return deps

    theirs = fitted.theirs
    return Model(theirs.name, variables, ours_of(theirs.feedthrough), ours_of(theirs.initial), theirs.guid, theirs.tool)


def _union(
    parts: Iterable[frozenset[Element] | None], back: Mapping[Element, list[Element]]
) -> frozenset[Element] | None:
    """The inputs of ours behind these of theirs; None as soon as one is not declared."""
    fitted: set[Element] = set()
    for part in parts:
        if part is None:
            return None
        for element in part:
            fitted.update(back.get(element, ()))
    return frozenset(fitted)
