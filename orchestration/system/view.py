"""The three-dimensional view that a scenario states, held against its blocks: which elements it needs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..errors import InputError
from ..fmu.model import Model
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..scenario.view import GHOSTS, ViewEntry
from . import signals
from .wiring import Node


def check(scenario: Scenario, models: Mapping[str, Model]) -> list[Node]:
    """The elements of the signals that the view needs. Raises InputError, which names the place in the scenario."""
    needed: list[Node] = []
    errors: list[str] = []
    for key, reference, shapes in _signals(scenario.view) if scenario.view else ():
        try:
            variable, nodes = signals.find(scenario, key, reference, models)
        except InputError as error:
            errors += error.messages
            continue
        shape = () if reference.indices else variable.shape
        if shapes and shape not in shapes:
            expected = " or ".join("a scalar" if s == () else f"the shape {list(s)}" for s in shapes)
            errors.append(
                scenario.error(key, f"{reference} is {variable.kind}; expected {expected}; remedy: another signal")
            )
        needed += nodes
    for key, reference in _parameters(scenario.view) if scenario.view else ():
        model = models.get(reference.block)
        if model is None or reference.variable not in model.variables:
            errors.append(scenario.error(key, f"there is no {reference}; expected a parameter of a block"))
    if errors:
        raise InputError(*errors)
    return needed


def _signals(view: ViewEntry) -> Iterator[tuple[Key, Reference, tuple[tuple[int, ...], ...]]]:
    """Each signal of a view: where it stands, and the shapes that it may have; any where none is listed."""
    yield ("view", "attitude"), view.attitude, ((3, 3), (4,))
    vectors: tuple[tuple[int, ...], ...] = ((3,),)
    shapes = {**dict.fromkeys(GHOSTS, ((3, 3), (4,))), "position": vectors, "sun": vectors, "phase": ((),)}
    for name, allowed in shapes.items():
        reference = getattr(view, name)
        if isinstance(reference, Reference):
            yield ("view", name), reference, allowed
    for i, arrow in enumerate(view.vectors):
        rows = arrow.along if isinstance(arrow.along, list) else None
        shapes: tuple[tuple[int, ...], ...] = ((3,),) if arrow.along is None else ()
        if rows is not None:
            shapes = ((len(rows),), ()) if len(rows) == 1 else ((len(rows),),)
        yield ("view", "vectors", i, "signal"), arrow.signal, shapes


def _parameters(view: ViewEntry) -> Iterator[tuple[Key, Reference]]:
    """Each parameter of a view, and where it stands."""
    named: dict[Key, object] = {("view", "epoch"): view.epoch}
    named |= {("view", "body", key): getattr(view.body, key) for key in ("length", "width", "axis")}
    named |= {("view", "axes", name): rows for name, rows in view.axes.items()}
    named |= {("view", "vectors", i, "along"): arrow.along for i, arrow in enumerate(view.vectors)}
    return ((key, value) for key, value in named.items() if isinstance(value, Reference))
