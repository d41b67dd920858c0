"""docs/evidence/satellites.csv: a line for each flight; docs/evidence/satellites.md is made from it.
Tests: tests/evidence/satellites/test_page.py."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchestration.campaign.flying.rows import Rows

from .. import files
from ..flight.cases import ALARMS
from ..paper import Array
from .classes import ALL, EARLY, settled

FILE = "satellites.csv"
CONDITIONS = {"nominal": False, "errors": True}
NAMES = {"nominal": "nominal", "errors": "all errors"}
"""What the page calls them."""
STEEP = 30.0
"""deg, an inclination from which the field turns well along the orbit."""
RADIUS = 6371.0
"""km, from which heights count."""
COLUMNS = (
    "satellite condition run inclination_deg height_km rate_deg_s settled_5deg_s settled_1deg_s early_s later_max_deg "
    "hold_rms_deg wheel_share told remark"
).split()


@dataclass(frozen=True)
class Flights:
    """All flights, as they stand in the file."""

    lines: tuple[Mapping[str, str], ...]

    def of(self, satellite: str, condition: str) -> list[Mapping[str, str]]:
        """The lines of a satellite under a condition, in the order of their runs."""
        return [line for line in self.lines if (line["satellite"], line["condition"]) == (satellite, condition)]


def column(lines: Sequence[Mapping[str, str]], name: str, empty: float = math.nan) -> Array:
    """A column as numbers (n,)."""
    return np.array([float(line[name] or empty) for line in lines])


def are_lost(lines: Sequence[Mapping[str, str]]) -> Array:
    """Returns which were settled at EARLY and left again (n,), also if they settled once more."""
    return np.isfinite(column(lines, "early_s")) & (settled_at_end(lines) > EARLY)


def settled_at_end(lines: Sequence[Mapping[str, str]]) -> Array:
    """From when on they are settled to the end, s (n,); infinite for never."""
    return column(lines, "settled_5deg_s", math.inf)


def settling_times(lines: Sequence[Mapping[str, str]]) -> Array:
    """Returns when they settle, s (n,); infinite for those that never do or are lost again."""
    return np.where(are_lost(lines), math.inf, settled_at_end(lines))


def load(file: Path) -> Flights:
    """The flights of a file that `save` wrote. Raises InputError for one of another form."""
    return Flights(tuple(files.read(file, COLUMNS, "python -m evidence satellites")))


def save(file: Path, flown: Mapping[tuple[str, str], Rows]) -> None:
    """Writes every flight of the datasets, by satellite and condition."""
    files.write(file, COLUMNS, (line for (name, kind), rows in flown.items() for line in _lines(name, kind, rows)))


def _lines(satellite: str, condition: str, rows: Rows) -> list[dict[str, str]]:
    value = {metric["name"]: rows.numbers(metric["name"]) for metric in rows.manifest["metrics"]}
    times = settled(value["angle_5"], value["rate"])
    numbers = {
        "inclination_deg": (np.degrees(rows.numbers("plant.inclination")), ".3g"),
        "height_km": (rows.numbers("plant.orbit_radius") / 1e3 - RADIUS, ".0f"),
        "rate_deg_s": (np.degrees(value["initial_rate"]), ".3g"),
        "settled_5deg_s": (times, ".0f"),
        "settled_1deg_s": (settled(value["angle_1"], value["rate"]), ".0f"),
        "early_s": (np.maximum(value["early_angle_5"], value["early_rate"]), ".0f"),
        "later_max_deg": (np.degrees(value["later_max"]), ".3g"),
        "hold_rms_deg": (np.degrees(value["hold_rms"]), ".3g"),
        "wheel_share": (value["wheel_max"] / ALL[satellite].wheel_momentum_max, ".3g"),
    }
    reasons = rows.reasons()
    found = []
    for i, index in enumerate(rows.index.tolist()):
        line = {name: format(v[i], form) if math.isfinite(v[i]) else "" for name, (v, form) in numbers.items()}
        told = " ".join(name for name in ALARMS if math.isfinite(value[name][i]))
        remark = f"the run failed: {reasons[index]}" if rows.failed[i] else ""
        found.append(
            {"satellite": satellite, "condition": condition, "run": f"{index}", **line, "told": told, "remark": remark}
        )
    return found


Tumble = tuple[str, str, str]
"""Satellite, condition and run."""


def tumble_of(line: Mapping[str, str]) -> Tumble:
    """Whose flight a line is."""
    return line["satellite"], line["condition"], line["run"]


def not_settled(flights: Flights) -> list[Tumble]:
    """Those that do not settle, or are lost again."""
    never = np.isinf(settling_times(flights.lines))
    return [tumble_of(line) for line, left in zip(flights.lines, never, strict=True) if left]
