"""Theirs as a block of our interface: its variables, and on which inputs its outputs depend."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .. import rotation
from ..fmu.interfaces import with_inputs
from ..fmu.model import Element, Model
from .findings import Fit, Link, may_stay_unconnected


def held(theirs: Model, fitted: Fit) -> Model:
    """Theirs, with its own start values, as a block that is held to our interface: with our quantities and helper
    inputs."""
    ours = fitted.reference.model.variables
    alike = {n: replace(v, quantity=ours[n].quantity if n in ours else v.quantity) for n, v in theirs.variables.items()}
    seen = replace(theirs, variables=alike)
    if not fitted.identical:
        seen = replace(model(fitted), starts=_starts(theirs, fitted), left_out=_left_out(fitted))
    lacks = frozenset(name for name, variable in fitted.missing.items() if variable.causality == "parameter")
    return replace(with_inputs(seen, fitted.reference.name), lacks=lacks)


def _left_out(fitted: Fit) -> dict[str, str]:
    """Outputs of ours that it does not have, each with the reason as a message goes on after its name."""
    outputs = [(name, v) for name, v in {**fitted.missing, **fitted.ignored}.items() if v.causality == "output"]
    known = {*fitted.theirs.variables, *fitted.links}
    return {
        name: "under 'ignore' in the mapping, so there is no such output; remedy: map it"
        if name in fitted.ignored
        else "an output that its FMU lacks; remedy: map it"
        for name, _ in outputs
        if name not in known
    }


def _starts(theirs: Model, fitted: Fit) -> dict[Element, Any]:
    """Their start values, by our elements."""
    starts = {e: theirs.starts[e] for v in fitted.extra for e in v.elements if e in theirs.starts}
    for link in fitted.links.values():
        if link.ours.causality != "output" and all(element in theirs.starts for element in link.theirs):
            values = in_ours(link, [theirs.starts[element] for element in link.theirs])
            starts |= dict(zip(link.ours.elements, values or (), strict=False))
    return starts


def in_ours(link: Link, theirs: list[Any]) -> list[Any] | None:
    """Values of theirs as ours; None where they cannot be told."""
    if link.ours.type != "real":
        return theirs
    if link.A is None or link.c is None:
        try:
            return in_ours_matrix(link, theirs)
        except ValueError:
            return None
    if link.turned:
        return None
    with np.errstate(invalid="ignore"):  # of an FMU's start that is infinite
        values: list[Any] | None = None if link.B is None else (link.B @ (np.array(theirs, float) - link.c)).tolist()
    return values


def in_ours_matrix(link: Link, theirs: Sequence[float]) -> list[float]:
    """Our rotation matrix, of a quaternion or three numbers of theirs. Raises ValueError where they are none."""
    if link.rotation:
        R = rotation.of_three([x * link.unit for x in theirs], link.rotation)
    else:
        R = rotation.matrix([theirs[3], *theirs[:3]] if link.scalar_last else theirs)
    return rotation.transposed(R) if link.inverse else R


def model(fitted: Fit) -> Model:
    """Theirs as a block of our interface: our names, units and shapes; under their own names what only they have."""
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
                columns = range(link.ours.size) if link.turned else columns
                back.setdefault(element, []).extend(Element(link.ours.name, column) for column in columns)
                if link.turned:
                    back[element].extend(fitted.reference.model.variables[link.turned].elements)
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
