"""docs/flight.csv: a line a case, from which docs/flight.md and its figures are made."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import markdown
from ..paper import ORBIT, Array
from .cases import Case
from .run import HOLD, Row

GOALS = {"nominal": (0.09, 0.20, 0.01), "errors": (0.10, 0.23, 0.1)}
"""Median and worst time to 5 deg, orbits, and hold error, deg rms."""
COLUMNS = (
    "group seed duration_s settled_5deg_s settled_1deg_s momentum_bound_s initial_rate_deg_s hold_rms_deg wheel_max_mNms "
    "late_rms_deg late_max_deg late_wheel_mNms remark"
).split()


@dataclass(frozen=True)
class Flights:
    """All cases, as they stand in the file."""

    lines: tuple[Mapping[str, str], ...]

    def of(self, group: str) -> list[Mapping[str, str]]:
        """The lines of a group, in the order of their seeds."""
        return [line for line in self.lines if line["group"] == group]

    def column(self, group: str, name: str, empty: float = math.nan) -> Array:
        """Numbers of a group (n,)."""
        return np.array([float(line[name] or empty) for line in self.of(group)])

    def times(self, group: str, degrees: int = 5) -> Array:
        """When they settled, orbits; infinite where they did not."""
        return self.column(group, f"settled_{degrees}deg_s", math.inf) / ORBIT

    def least(self, group: str) -> Array:
        """Their momentum bounds, orbits; NaN beyond the horizon."""
        return self.column(group, "momentum_bound_s") / ORBIT

    def hold_errors(self, group: str) -> Array:
        """Rms angle, deg, over the last seconds of the cases that had settled below 5 deg by then."""
        held = self.column(group, "settled_5deg_s", math.inf) <= self.column(group, "duration_s") - HOLD
        return self.column(group, "hold_rms_deg")[held]


def load(file: Path) -> Flights:
    """The cases of a file that `save` wrote."""
    with file.open(encoding="utf-8", newline="") as text:
        return Flights(tuple(csv.DictReader(text)))


def save(file: Path, cases: Sequence[Case], rows: Mapping[str, Row], bounds: Mapping[str, float | None]) -> None:
    """Writes every case: times in s, errors in deg, wheel momentum in mN m s."""
    with file.open("w", encoding="utf-8", newline="") as text:
        out = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        out.writeheader()
        for case in cases:
            out.writerow(line(case, rows[case.name], bounds.get(case.name)))


def line(case: Case, row: Row, least: float | None) -> dict[str, str]:
    """A case's line; what it has no value for stays empty."""

    def number(key: str, form: str, factor: float = 1.0) -> str:
        return "" if row.get(key) is None else format(factor * row[key], form)

    return {
        "group": case.group,
        "seed": f"{case.seed}",
        "duration_s": number("duration", ".0f"),
        "settled_5deg_s": number("settled5", ".0f"),
        "settled_1deg_s": number("settled1", ".0f"),
        "momentum_bound_s": "" if least is None else f"{least:.1f}",
        "initial_rate_deg_s": number("rate", ".3g", math.degrees(1.0)),
        "hold_rms_deg": number("hold_rms", ".3g", math.degrees(1.0)),
        "wheel_max_mNms": number("wheel_max", ".3g", 1e3),
        "late_rms_deg": number("late_rms", ".3g", math.degrees(1.0)),
        "late_max_deg": number("late_max", ".3g", math.degrees(1.0)),
        "late_wheel_mNms": number("late_wheel", ".3g", 1e3),
        "remark": remark(case, row),
    }


def remark(case: Case, row: Row) -> str:
    """Why a case of GOALS or a pairing has not settled, or was later than the goal."""
    if "failed" in row:
        return f"the run failed: {row['failed']}"
    if case.group not in GOALS and "+" not in case.group:
        return ""
    steered = row.get("steered", 0.0)
    if row["settled5"] is not None and row["settled1"] is not None:
        late = case.group in GOALS and row["settled5"] / ORBIT > GOALS[case.group][1]
        return f"steering took {(steered or 0.0) / ORBIT:.3f} orbit" if late else ""
    end = (
        f"{markdown.degrees(math.degrees(row['end_angle']))} and {row['end_rate']:.1e} rad/s "
        f"at the end of {row['duration'] / ORBIT:.1f} orbits"
    )
    if steered is None:
        return f"still steering the momentum: {end}"
    if row["wheel_full"] > 0.01:
        return f"wheel at its limit for {100.0 * row['wheel_full']:.0f}% of the time: {end}"
    return f"{end}; at most {markdown.degrees(math.degrees(row['hold_max']))} in the last {HOLD:.0f} s"


def quantile(times: Array, q: float) -> float:
    """Of all cases, those that never settle counted as later than all others."""
    return float(np.sort(times)[max(0, math.ceil(q * len(times)) - 1)])


def angle(values: Array, which: Callable[[Array], Any]) -> str:
    """A statistic of angles, deg, as text; a dash where there are none."""
    return markdown.degrees(float(which(values))) if len(values) else "–"
