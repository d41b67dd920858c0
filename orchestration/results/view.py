"""The data of a report's three-dimensional view: motion, vectors, orbit and marks, few enough rows for a page.

What a scenario does not say is taken from the interfaces of the project's own blocks, as far as it was recorded.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..fmu.interfaces import view as of_interface
from ..fmu.model import Floats
from ..quantities import ONE
from ..rotation import matrix, quaternion
from ..scenario.references import Reference
from ..scenario.view import ViewEntry
from .arrays import Arrays, few
from .data import RunData

ROWS = 2000
"""Instants that a view keeps at most, equally far apart; between them the page interpolates."""
_AXES = {"x": 0, "y": 1, "z": 2}
_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


def view(result: RunData, arrays: Arrays) -> dict[str, Any] | None:
    """What the page's view draws; None where the scenario has no attitude to be seen."""
    entry = result.scenario.view or _default(result)
    if entry is None or len(result.time) < 2:
        return None
    n = len(result.time)
    rows = np.unique(np.linspace(0, n - 1, min(n, ROWS)).round().astype(int))
    parameters = result.manifest.get("parameters", {})
    attitude = _quaternions(result[entry.attitude][rows])
    desired = entry.desired
    return {
        "name": entry.attitude.block,
        "time": arrays.add(result.time[rows]),
        "attitude": arrays.add_short(attitude),
        "desired": arrays.add_short(_quaternions(result[desired][rows])) if isinstance(desired, Reference) else desired,
        "position": None if entry.position is None else arrays.add(result[entry.position][rows].astype(float).ravel()),
        "sun": None if entry.sun is None else arrays.add_short(result[entry.sun][rows]),
        "earth": None if entry.epoch is None else _earth_angle(str(_value(entry.epoch, parameters))),
        "body": _body(entry, parameters),
        "axes": [
            {"name": f"{name} {i + 1}" if len(directions) > 1 else name, "kind": name, "direction": direction}
            for name, axes in entry.axes.items()
            for directions in [_directions(axes, parameters)]
            for i, direction in enumerate(directions)
        ],
        "vectors": [
            {
                "name": arrow.name,
                "frame": arrow.frame,
                "shown": arrow.shown,
                "unit": unit,
                "values": arrays.add_short(values[rows]),
                "largest": float(np.sqrt((values * values).sum(axis=1)).max()),
            }
            for arrow in entry.vectors
            for unit, values in [_vector(result, arrow.signal, arrow.along, parameters)]
        ],
        "phases": _phases(result, entry),
    }


def _default(result: RunData) -> ViewEntry | None:
    """What the interfaces of the blocks say, as far as it was recorded."""
    found: dict[str, Any] = {"vectors": [], "axes": {}}
    parameters = result.manifest.get("parameters", {})
    for block, stated in result.scenario.blocks.items():
        own = of_interface(stated.interface or result.models[block].name)

        def there(name: str, block: str = block) -> bool:
            return f"{block}.{name}" in result

        for key in ("attitude", "position", "sun", "phase"):
            if key in own and key not in found and there(own[key]):
                found[key] = f"{block}.{own[key]}"
                if key == "phase":
                    found["phases"] = own.get("phases", [])
        given = parameters.get(block, {})
        goal = own.get("desired")
        if goal == "lvlh" and given.get(own["lvlh_by"]) == "lvlh":
            found.setdefault("desired", goal)
        elif goal is not None and there(goal):
            found["desired"] = f"{block}.{goal}"
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
    return ViewEntry.model_validate(found) if "attitude" in found else None


def _named(block: str, axes: Any, given: Mapping[str, Any]) -> Any:
    """Axes of an interface as a scenario states them; None where the block has no such parameter."""
    if isinstance(axes, str):
        return f"{block}.{axes}" if axes in given else None
    return axes


def _value(value: Any, parameters: Mapping[str, Mapping[str, Any]]) -> Any:
    """The value of a parameter that a reference names, or what is no reference itself."""
    return parameters[value.block][value.variable] if isinstance(value, Reference) else value


def _directions(axes: Any, parameters: Mapping[str, Any]) -> list[list[float]]:
    """Unit vectors along axes, one a row."""
    rows = np.atleast_2d(np.array(_value(axes, parameters), float))
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return (rows / np.where(length > 0.0, length, 1.0)).tolist()


def _body(entry: ViewEntry, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The prism with a largest extent of 1."""
    length, width = (float(_value(getattr(entry.body, key), parameters)) for key in ("length", "width"))
    axis = str(_value(entry.body.axis, parameters))
    largest = max(length, width)
    return {
        "length": length / largest,
        "width": width / largest,
        "axis": _AXES.get(axis, 0),
        "sides": entry.body.sides,
    }


def _vector(result: RunData, signal: Reference, along: Any, parameters: Mapping[str, Any]) -> tuple[str, Floats]:
    """A vector's unit, and its components (n, 3) in that unit."""
    variable = result.variable(signal)
    unit = variable.display_unit or variable.unit or ONE
    factor, _ = (variable.unit or ONE).conversion(unit)
    values = factor * result[signal].reshape(len(result.time), -1).astype(float)
    if along is not None:
        values = values @ np.array(_directions(along, parameters))
    return "" if unit.name in ("", "1") else str(unit), np.where(np.isfinite(values), values, 0.0)


def _quaternions(values: NDArray[Any]) -> Floats:
    """Unit quaternions (n, 4), scalar first, neighbours in one half; zeros where there is no attitude."""
    rows = values.reshape(len(values), -1).astype(float)
    known = np.isfinite(rows).all(axis=1) & rows.any(axis=1)
    found = np.zeros((len(rows), 4))
    near: list[float] | None = None
    for i, row in zip(np.flatnonzero(known).tolist(), rows[known].tolist(), strict=True):
        near = found[i] = quaternion(row if len(row) == 9 else matrix(row), near)
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


def _phases(result: RunData, entry: ViewEntry) -> list[dict[str, Any]]:
    """What is marked on the time slider: the phases, and the times of the holds."""
    end = float(result.time[-1])
    found: list[dict[str, Any]] = []
    if entry.phase is not None:
        values = result[entry.phase].astype(int).ravel()
        names = {number: item for item, number in result.variable(entry.phase).items}
        names |= dict(enumerate(entry.phases, start=1))
        begins = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist()]
        ends = [*begins[1:], len(values) - 1]
        colours = {value: i for i, value in enumerate(dict.fromkeys(values[begins].tolist()))}
        found += [
            {
                "name": names.get(int(values[a]), str(values[a])),
                "colour": colours[int(values[a])],
                "from": float(result.time[a]),
                "to": float(result.time[b]),
            }
            for a, b in zip(begins, ends, strict=True)
        ]
    for hold in result.holds:
        spans = few([(a, end if b is None else b) for a, b in hold.spans])
        found += [{"name": f"{hold.name} held", "colour": -1, "from": a, "to": b} for a, b in spans]
    return found
