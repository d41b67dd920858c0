"""docs/evidence/flight.csv: a line for each flight, from the datasets of the campaigns; docs/evidence/flight.md and
its figures are made from it. Tests: tests/evidence/flight/test_page.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestration.campaign.flying.rows import Rows

from .. import files, markdown
from ..paper import ORBIT, Array
from .cases import ALARMS, HOLD, Group

COLUMNS = (
    "group run node_deg duration_s settled_5deg_s settled_1deg_s early_5deg_s momentum_bound_s initial_rate_deg_s "
    "hold_rms_deg wheel_max_mNms later_rms_deg later_max_deg later_wheel_mNms told told_s remark"
).split()


@dataclass(frozen=True)
class Flights:
    """All flights, as they stand in the file."""

    lines: tuple[Mapping[str, str], ...]

    def of(self, group: str) -> list[Mapping[str, str]]:
        """The lines of a group, in the order of their runs."""
        return [line for line in self.lines if line["group"] == group]

    def column(self, group: str, name: str, empty: float = math.nan) -> Array:
        """Numbers of a group (n,)."""
        return np.array([float(line[name] or empty) for line in self.of(group)])

    def times(self, group: str, degrees: int = 5) -> Array:
        """Returns when they settled, orbits; infinite where they did not."""
        return self.column(group, f"settled_{degrees}deg_s", math.inf) / ORBIT

    def least(self, group: str) -> Array:
        """Their momentum bounds, orbits; NaN beyond the horizon."""
        return self.column(group, "momentum_bound_s") / ORBIT

    def lost(self, group: str) -> Array:
        """Returns which were settled below 5 deg at EARLY and lost it again (n,)."""
        return np.isfinite(self.column(group, "early_5deg_s")) & ~np.isfinite(self.times(group))

    def told(self, group: str) -> Array:
        """Returns when the planned controller first said that a part had failed, s, in those flights where it did."""
        return self.column(group, "told_s")[[bool(line["told"]) for line in self.of(group)]]

    def hold_errors(self, group: str) -> Array:
        """Rms angle, deg, over the last HOLD seconds of the flights that are settled below 5 deg."""
        return self.column(group, "hold_rms_deg")[np.isfinite(self.times(group))]


def load(file: Path) -> Flights:
    """The flights of a file that `save` wrote. Raises InputError for one of another form."""
    return Flights(tuple(files.read(file, COLUMNS, "make flight")))


def save(file: Path, flown: Sequence[tuple[Group, Rows]], bounds: Mapping[str, Sequence[float | None]]) -> None:
    """Writes every flight: times in s, errors in deg, wheel momentum in mN m s."""
    files.write(
        file,
        COLUMNS,
        (line for group, rows in flown for line in lines(group, rows, bounds.get(group.name, [None] * len(rows)))),
    )


def lines(group: Group, rows: Rows, bounds: Sequence[float | None]) -> list[dict[str, str]]:
    """A group's lines; what a flight has no value for stays empty."""
    metrics = {m["name"]: rows.numbers(m["name"]) for m in rows.manifest["metrics"]}
    metrics["node"] = rows.numbers("plant.node_longitude")
    reasons = rows.reasons()
    found = []
    for i, (index, least) in enumerate(zip(rows.index, bounds, strict=True)):
        m = {name: float(values[i]) for name, values in metrics.items()}
        numbers = {
            "node_deg": (math.degrees(m["node"]), ".4g"),
            "duration_s": (group.duration, ".0f"),
            "settled_5deg_s": (settled(group, m, 5), ".0f"),
            "settled_1deg_s": (settled(group, m, 1), ".0f"),
            "early_5deg_s": (max(m["early_angle_5"], m["early_rate"]), ".0f"),
            "momentum_bound_s": (math.nan if least is None else least, ".1f"),
            "initial_rate_deg_s": (math.degrees(m["initial_rate"]), ".3g"),
            "hold_rms_deg": (math.degrees(m["hold_rms"]), ".3g"),
            "wheel_max_mNms": (1e3 * m["wheel_max"], ".3g"),
            "later_rms_deg": (math.degrees(m["later_rms"]), ".3g"),
            "later_max_deg": (math.degrees(m["later_max"]), ".3g"),
            "later_wheel_mNms": (1e3 * m["later_wheel"], ".3g"),
        }
        told = [name for name in ALARMS if math.isfinite(m.get(name, math.inf))]
        numbers["told_s"] = (min((m[name] for name in told), default=math.inf), ".0f")
        line = {name: format(value, form) if math.isfinite(value) else "" for name, (value, form) in numbers.items()}
        text = f"the run failed: {reasons[int(index)]}" if rows.failed[i] else remark(group, m)
        found.append({"group": group.name, "run": f"{index}", **line, "told": " ".join(told), "remark": text})
    return found


def settled(group: Group, m: Mapping[str, float], degrees: int) -> float:
    """From when on a flight with these metrics is settled, s; infinite where it is not for at least HOLD up to its end.

    One that was settled below 5 deg at `group.early` and lost it again counts as not settled, whatever follows.
    """
    lost = max(m["early_angle_5"], m["early_rate"]) < math.inf and max(m["angle_5"], m["rate"]) > group.early
    time = max(m[f"angle_{degrees}"], m["rate"])
    return math.inf if lost or time > group.duration - HOLD else time


def remark(group: Group, m: Mapping[str, float]) -> str:
    """Returns why a random tumble or a pairing has not settled, from its metrics."""
    if (group.name not in ("nominal", "errors") and "+" not in group.name) or math.isfinite(settled(group, m, 1)):
        return ""
    steered = m.get("steered", 0.0)
    end = (
        f"{markdown.degrees(math.degrees(m['end_angle']))} and {m['end_rate']:.1e} rad/s "
        f"at the end of {group.duration / ORBIT:.1f} orbits"
    )
    if not math.isfinite(steered):
        return f"still steering the momentum: {end}"
    if m["wheel_full"] > 0.01:
        return f"wheel at its limit for {100.0 * m['wheel_full']:.0f}% of the time: {end}"
    return f"{end}; at most {markdown.degrees(math.degrees(m['hold_max']))} in the last {HOLD:.0f} s"


def quantile(times: Array, q: float) -> float:
    """Returns a quantile of all cases, those that never settle counted as later than all others."""
    return float(np.sort(times)[max(0, math.ceil(q * len(times)) - 1)])


def angle(values: Array, which: Callable[[Array], Any]) -> str:
    """A statistic of angles, deg, as text; a dash where there are none."""
    return markdown.degrees(float(which(values))) if len(values) else "–"
