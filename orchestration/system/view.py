"""The three-dimensional view that a scenario states, held against its blocks: which elements it needs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from ..errors import Problems
from ..fmu.model import Model, Variable
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..scenario.view import GHOSTS, ViewEntry
from . import signals
from .wiring import Node

Shapes = tuple[tuple[int, ...], ...]


def check(scenario: Scenario, models: Mapping[str, Model]) -> list[Node]:
    """The elements of the signals that the view needs. Raises InputError, which names the place in the scenario."""
    needed: list[Node] = []
    if scenario.view is None:
        return needed
    with Problems() as problems:
        for key, reference, shapes in _signals(scenario.view):
            with problems.gathered():
                variable, nodes = signals.find(scenario, key, reference, models)
                shape = () if reference.indices else variable.shape
                if shapes and shape not in shapes:
                    text, remedy = f"{reference} is {variable.kind}", "another signal"
                    expected = " or ".join("a scalar" if s == () else f"the shape {list(s)}" for s in shapes)
                    problems.append(scenario.error(key, text, expected=expected, remedy=remedy))
                needed += nodes
        for key, reference, expected, fits in _parameters(scenario.view):
            model = models.get(reference.block)
            own = model.variables.get(reference.variable) if model else None
            if own is None or own.causality != "parameter":
                text = f"there is no parameter {reference}"
                problems.append(scenario.error(key, text, expected="a parameter of a block"))
            elif not fits(own) or reference.indices:
                problems.append(scenario.error(key, f"{reference} is {own.kind}", expected=expected))
    return needed


def _signals(view: ViewEntry) -> Iterator[tuple[Key, Reference, Shapes]]:
    """Each signal of a view: where it stands, and the shapes that it may have; any where none is listed."""
    yield ("view", "attitude"), view.attitude, ((3, 3), (4,))
    one: dict[str, Shapes] = dict.fromkeys(GHOSTS, ((3, 3), (4,)))
    one |= {"position": ((3,),), "sun": ((3,),), "phase": ((),)}
    for name, allowed in one.items():
        reference = getattr(view, name)
        if isinstance(reference, Reference):
            yield ("view", name), reference, allowed
    for i, arrow in enumerate(view.vectors):
        rows = arrow.along if isinstance(arrow.along, list) else None
        shapes: Shapes = ((3,),) if arrow.along is None else ()
        if rows is not None:
            shapes = ((len(rows),), ()) if len(rows) == 1 else ((len(rows),),)
        yield ("view", "vectors", i, "signal"), arrow.signal, shapes


def _parameters(view: ViewEntry) -> Iterator[tuple[Key, Reference, str, Callable[[Variable], bool]]]:
    """Each parameter of a view: where it stands, and what it must be, in words and as a check."""
    found: list[tuple[Key, object, str, Callable[[Variable], bool]]] = [
        (("view", "epoch"), view.epoch, "text", lambda v: v.type == "string"),
        (("view", "body", "axis"), view.body.axis, "text", lambda v: v.type in ("string", "enumeration")),
    ]
    for key in ("length", "width"):
        one = lambda v: v.type == "real" and v.size == 1  # noqa: E731
        found.append((("view", "body", key), getattr(view.body, key), "a number", one))
    axes: list[tuple[Key, object]] = [(("view", "axes", name), rows) for name, rows in view.axes.items()]
    axes += [(("view", "vectors", i, "along"), arrow.along) for i, arrow in enumerate(view.vectors)]
    for place, rows in axes:
        found.append((place, rows, "directions, [3] or [n, 3]", lambda v: v.type == "real" and v.shape[-1:] == (3,)))
    for place, value, expected, fits in found:
        if isinstance(value, Reference):
            yield place, value, expected, fits
