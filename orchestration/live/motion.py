"""How a page's worker makes the phases and the three-dimensional view of a flight from the recorded columns."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..results import parts, phases, view
from ..results.data import RunData
from ..results.phases import Condition
from ..scenario.references import Reference
from ..scenario.view import GHOSTS


def motion(native: RunData, shown: dict[str, Any]) -> dict[str, Any]:
    """Returns what the worker takes for the view; `shown` is that of the native run: a flight has the same vectors."""
    entry = view.entry_of(native)
    assert entry is not None
    names = {vector["name"] for vector in shown["vectors"]}
    parameters = native.manifest.get("parameters", {})
    holds = [
        Condition(f"{hold.name} held", native.columns[native.places(hold.signal)[0]], 1.0, -1)
        for hold in native.scenario.holds
        if hold.signal in native
    ]
    return {
        "rows": view.chosen(native.time).tolist(),
        "signals": {
            name: native.places(signal) if isinstance(signal, Reference) else signal
            for name in ("attitude", *GHOSTS, "position", "sun")
            for signal in [getattr(entry, name)]
        },
        "vectors": [
            {
                "columns": native.places(arrow.signal),
                "factor": view.unit_of(native.variable(arrow.signal))[1],
                "along": None if arrow.along is None else parts.directions(arrow.along, parameters),
            }
            for arrow in entry.vectors
            if arrow.name in names
        ],
        "marks": columns(native, [*view.conditions(native, entry), *holds]),
        "still": [] if native.scenario.phases else phases.bands(native),
    }


def columns(native: RunData, conditions: Iterable[Condition]) -> list[dict[str, Any]]:
    """Returns conditions with the column that each looks at."""
    places = {node: i for i, node in enumerate(native.columns)}
    return [{"name": c.name, "column": places[c.signal], "value": c.value, "colour": c.colour} for c in conditions]
