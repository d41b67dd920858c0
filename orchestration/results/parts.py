"""Parts of a satellite and its surroundings that a view draws as the interfaces of the blocks name them: axes of rods
and wheels, cones of sensors, stations on the ground.

Tests: tests/orchestration/results/test_view_data.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..fmu.interfaces import pages
from ..scenario.references import Reference
from .data import RunData

NEVER = 1e-9
"""rad/s: a sensor that gives nothing above so small a rate is not there."""


def around(result: RunData, parameters: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Returns the cones of sensors and the stations on the ground that the interfaces of the blocks name."""
    used = {(str(connection.source.block), connection.source.variable) for connection in result.scenario.connections}
    found: dict[str, list[dict[str, Any]]] = {"cones": [], "stations": []}
    for block, stated in result.scenario.blocks.items():
        own = pages().get(stated.interface or result.models[block].name, {})
        given = parameters.get(block, {})
        for cone in own.get("cones", ()):
            gives = given.get(cone.get("rate"), math.inf) or math.inf  # beyond this rate it gives nothing; 0: at any
            if (block, cone["of"]) in used and cone["axis"] in given and gives > NEVER:
                angle = float(given[cone["angle"]]) or cone["default"]
                (direction,) = directions(given[cone["axis"]], parameters)
                found["cones"].append({"name": cone["name"], "direction": direction, "angle": angle})
        for station in own.get("stations", ()):
            latitude, longitude = (float(given.get(station[key], 0.0)) for key in ("latitude", "longitude"))
            if latitude or longitude:
                at = {"latitude": latitude, "longitude": longitude, "elevation": station["elevation"]}
                found["stations"].append({"name": station["name"], **at})
    return found


def there(result: RunData, axes: Any, parameters: Mapping[str, Any]) -> list[list[float]]:
    """Returns unit vectors along the axes of the parts that are there: a block may have fewer than it has axes for."""
    rows = directions(axes, parameters)
    if not isinstance(axes, Reference):
        return rows
    stated = result.scenario.blocks[axes.block]
    counts = pages().get(stated.interface or result.models[axes.block].name, {}).get("counts", ())
    given = parameters.get(axes.block, {})
    numbers = [int(given[each["count"]]) for each in counts if each["axis"] == axes.variable and each["count"] in given]
    return rows[: numbers[0]] if numbers else rows


def value_of(stated: Any, parameters: Mapping[str, Mapping[str, Any]]) -> Any:
    """Returns the value of a parameter that a reference names, or what is no reference itself."""
    return parameters[stated.block][stated.variable] if isinstance(stated, Reference) else stated


def directions(axes: Any, parameters: Mapping[str, Any]) -> list[list[float]]:
    """Returns unit vectors along axes, one a row."""
    rows = np.atleast_2d(np.array(value_of(axes, parameters), float))
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return (rows / np.where(length > 0.0, length, 1.0)).tolist()
