"""The data of a report's three-dimensional view: motion, vectors, orbit and marks, few enough rows for a page.

What a scenario does not say is taken from the interfaces of the project's own blocks, as far as it was recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fmu.interfaces import view as of_interface
from ..fmu.model import Floats, Variable
from ..quantities import ONE, Unit, shown
from ..rotation import matrix, quaternions
from ..scenario.references import Reference
from ..scenario.view import GHOSTS, ViewEntry
from . import phases
from .arrays import Arrays, few
from .data import RunData
from .parts import around, directions, there, value_of
from .phases import Band, Condition

ROWS = 2000
"""Instants that a view keeps at most, equally far apart; between them the page interpolates."""
_AXES = {"x": 0, "y": 1, "z": 2}
_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


def view(result: RunData, arrays: Arrays) -> dict[str, Any] | None:
    """Returns what the page's view draws; None where the scenario has no attitude to be seen."""
    entry = entry_of(result)
    if entry is None or len(result.time) < 2:
        return None
    rows = chosen(result.time)
    parameters = result.manifest.get("parameters", {})
    attitude = _quaternions(result[entry.attitude][rows])
    return {
        "name": entry.attitude.block,
        "time": arrays.add(result.time[rows]),
        "attitude": arrays.add_short(attitude),
        **{
            name: arrays.add_short(_quaternions(result[ghost][rows])) if isinstance(ghost, Reference) else ghost
            for name in GHOSTS
            for ghost in [getattr(entry, name)]
        },
        "position": None if entry.position is None else arrays.add(result[entry.position][rows].astype(float).ravel()),
        "sun": None if entry.sun is None else arrays.add_short(result[entry.sun][rows]),
        "earth": None if entry.epoch is None else _earth_angle(str(value_of(entry.epoch, parameters))),
        "body": _body(entry, parameters),
        "axes": [
            {"name": f"{name} {i + 1}" if len(rows_) > 1 else name, "kind": name, "direction": direction}
            for name, axes in entry.axes.items()
            for rows_ in [there(result, axes, parameters)]
            for i, direction in enumerate(rows_)
        ],
        "vectors": [
            {
                "name": arrow.name,
                "frame": arrow.frame,
                "shown": arrow.shown,
                "unit": unit,
                "of": next(
                    (kind for kind, axes in entry.axes.items() if arrow.along is not None and axes == arrow.along), None
                ),
                "values": arrays.add_short(values[rows]),
                "largest": float(np.sqrt((values * values).sum(axis=1)).max()),
            }
            for arrow in entry.vectors
            for unit, values in [_vector(result, arrow.signal, arrow.along, parameters)]
            if values.any()
        ],
        "phases": _marks(result, entry),
        **around(result, parameters),
    }


def beside(shown: dict[str, Any] | None, former: dict[str, Any] | None, names: Sequence[str]) -> dict[str, Any] | None:
    """Returns what a view of two flights draws, the second one as a ghost of the first; None where one has no view."""
    return shown and former and {**shown, "former": former, "names": list(names)}


def chosen(time: Floats) -> NDArray[np.intp]:
    """Returns which samples a view keeps."""
    n = len(time)
    return np.linspace(0, n - 1, min(n, ROWS)).round().astype(np.intp)


def entry_of(result: RunData) -> ViewEntry | None:
    """Returns what the scenario says of its view, or else the interfaces of its blocks."""
    return result.scenario.view or _default(result)


def _default(result: RunData) -> ViewEntry | None:
    """Returns what the interfaces of the blocks say, as far as it was recorded."""
    found: dict[str, Any] = {"vectors": [], "axes": {}}
    parameters = result.manifest.get("parameters", {})
    for block, stated in result.scenario.blocks.items():
        own = of_interface(stated.interface or result.models[block].name)

        def there(name: str, block: str = block) -> bool:
            return f"{block}.{name}" in result

        for key in ("attitude", "planned", "estimated", "position", "sun", "phase"):
            if key in own and key not in found and there(own[key]):
                found[key] = f"{block}.{own[key]}"
                if key == "phase":
                    found["phases"] = own.get("phases", [])
        given = parameters.get(block, {})
        if (goal := _goal(result, block, own, given)) is not None:
            found.setdefault("desired", goal)
        if own.get("epoch") in given:
            found.setdefault("epoch", f"{block}.{own['epoch']}")
        body = {key: f"{block}.{name}" if name in given else name for key, name in own.get("body", {}).items()}
        if body and all(name in given for key, name in own["body"].items() if key != "sides"):
            found["body"] = body
        for name, axes in own.get("axes", {}).items():
            if (rows := _named(block, axes, given)) is not None:
                found["axes"][name] = rows
        for arrow in own.get("vectors", ()):
            along = _named(block, arrow.get("along"), given)
            if there(arrow["signal"]) and (along is not None or "along" not in arrow):
                found["vectors"].append({**arrow, "signal": f"{block}.{arrow['signal']}", "along": along})
    if "attitude" not in found:
        return None
    return ViewEntry.model_validate(found)


def _goal(result: RunData, block: str, own: Mapping[str, Any], given: Mapping[str, Any]) -> str | None:
    """Returns the desired attitude of a controller: what is connected to its input, else what its parameter says."""
    desired = own.get("desired", {})
    for connection in result.scenario.connections:
        if str(connection.target) == f"{block}.{desired.get('input')}":
            return str(connection.source) if str(connection.source) in result else None
    return "lvlh" if desired and given.get(desired["parameter"]) == "lvlh" else None


def _named(block: str, axes: Any, given: Mapping[str, Any]) -> Any:
    """Returns axes of an interface as a scenario states them; None where the block has no such parameter."""
    if isinstance(axes, str):
        return f"{block}.{axes}" if axes in given else None
    return axes


def _body(entry: ViewEntry, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the prism with a largest extent of 1."""
    length, width = (float(value_of(getattr(entry.body, key), parameters)) for key in ("length", "width"))
    axis = str(value_of(entry.body.axis, parameters))
    largest = max(length, width)
    return {"length": length / largest, "width": width / largest, "axis": _AXES.get(axis, 0), "sides": entry.body.sides}


def unit_of(variable: Variable) -> tuple[Unit, float]:
    """Returns the unit in which a vector is shown, and what its values are multiplied by."""
    unit = variable.display_unit or variable.unit or ONE
    return unit, (variable.unit or ONE).conversion(unit)[0]


def _vector(result: RunData, signal: Reference, along: Any, parameters: Mapping[str, Any]) -> tuple[str, Floats]:
    """Returns a vector's unit, and its components (n, 3) in that unit."""
    unit, factor = unit_of(result.variable(signal))
    values = factor * result.rows(signal)
    if along is not None:
        values = values @ np.array(directions(along, parameters))
    return shown(unit), np.where(np.isfinite(values), values, 0.0)


def _quaternions(values: NDArray[Any]) -> Floats:
    """Returns unit quaternions (n, 4), scalar first, neighbours in one half; zeros where there is no attitude."""
    rows = values.reshape(len(values), -1).astype(float)
    known = np.isfinite(rows).all(axis=1) & rows.any(axis=1)
    found = np.zeros((len(rows), 4))
    found[known] = quaternions(
        rows[known] if rows.shape[1] == 9 else np.array([matrix(q) for q in rows[known].tolist()])
    )
    return found


def _earth_angle(epoch: str) -> float | None:
    """Greenwich mean sidereal time at the epoch, rad; None where it is no date. UTC is taken for UT1.

    Constant and linear term of IAU 1982 in Vallado's form: an error of 1e-5 rad within decades of 2000.
    """
    try:
        at = datetime.fromisoformat(epoch)
    except ValueError:
        return None
    days = (at.replace(tzinfo=at.tzinfo or UTC) - _J2000).total_seconds() / 86400.0
    return float(np.radians((280.46061837 + 360.98564736629 * days) % 360.0))


def conditions(result: RunData, entry: ViewEntry) -> list[Condition]:
    """Returns what is marked on the time slider while a signal has a value: the scenario's phases, else those of
    `phase`.
    """
    if result.scenario.phases is not None:
        return phases.conditions(result)
    if entry.phase is None or result.scenario.timeline:
        return []
    names = {number: item for item, number in result.variable(entry.phase).items}
    names |= dict(enumerate(entry.phases, start=1))
    names |= {value: str(value) for value in np.unique(result[entry.phase].astype(int)).tolist() if value not in names}
    (node,) = (result.columns[place] for place in result.places(entry.phase))
    return [Condition(name, node, float(value), i) for i, (value, name) in enumerate(sorted(names.items()))]


def _marks(result: RunData, entry: ViewEntry) -> list[Band]:
    """Returns what is marked on the time slider: the phases, and the times of the holds."""
    end = float(result.time[-1])
    found = phases.bands(result) or phases.lasting(result, conditions(result, entry))
    for hold in result.holds:
        spans = few([(a, end if b is None else b) for a, b in hold.spans])
        found += [Band(f"{hold.name} held", a, b, -1) for a, b in spans]
    return found
