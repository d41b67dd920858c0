"""What a review is asked for beside the scenario: numbers of flights, statistics, requirements and data of power."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from orchestration import InputError
from orchestration.errors import Problem, hint
from orchestration.quantities import ONE, SECOND, QuantityError, Unit, parse_unit, value_in
from orchestration.scenario.source import Source
from orchestration.scenario.text import read

Tell = Callable[[str, int, int], None]
"""Is given the study, how much of it is done, and of how much."""
RADIAN, DEGREE, WATT = parse_unit("rad"), parse_unit("deg"), parse_unit("W")
METRICS: dict[str, tuple[str, Unit, str]] = {
    "settling_time": ("tumbles", SECOND, "time until the attitude error stays below the goal"),
    "detumbling_time": ("tumbles", SECOND, "time until the rate error stays below 0.1 deg/s"),
    "wheel_momentum": ("tumbles", parse_unit("N.m.s"), "largest momentum of a wheel"),
    "absolute_error": ("tumbles", RADIAN, "largest attitude error in the second half of the flight"),
    "mean_error": ("tumbles", RADIAN, "largest mean of it over a window"),
    "relative_error": ("tumbles", RADIAN, "largest difference from the mean of its window"),
    "drift_error": ("tumbles", RADIAN, "largest difference of the means of two windows"),
    "knowledge_error": ("tumbles", RADIAN, "largest error of the estimated attitude in the second half"),
    "slew_time": ("slews", SECOND, "longest time of the slews, flown on an attitude that is measured to 0.01 deg"),
    "station_error": ("station", RADIAN, "largest attitude error while the station is tracked"),
    "error_after_failure": (
        "failures",
        RADIAN,
        "largest error of the orbit that begins an orbit after any single failure",
    ),
    "torque_margin": ("margins", ONE, "torque of the rods in the weakest field over the largest disturbance"),
    "momentum_margin": ("margins", ONE, "momentum of a wheel over what gathers in an orbit"),
}
"""By name: the study that has it, its unit, and what it is."""
DRAWN = "tumbles"
"""The study of many flights, of which a probability can be shown."""


@dataclass(frozen=True)
class Asked:
    """A requirement of the file."""

    id: str
    text: str
    metric: str
    below: float | None
    above: float | None
    probability: float
    confidence: float
    limit: str
    """As it was written."""
    place: str

    @property
    def wrong(self) -> str:
        """Reason for which it cannot be verified, or ""."""
        if self.metric not in METRICS:
            return f"there is no metric {self.metric!r}{hint(self.metric, METRICS)}"
        return ""


@dataclass(frozen=True)
class Options:
    runs: int = 100
    members: int = 20
    """Flights of the budget with all errors; a fifth of it for each contributor."""
    seed: int = 1
    confidence: float = 0.95
    window: float = 60.0
    drift: float = 600.0
    """s"""
    workers: int = 2
    mass: float | None = None
    requirements: tuple[Asked, ...] = ()
    power: dict[str, float] = field(default_factory=dict)
    """W: `rod` at its largest dipole, `wheel` while it turns, and `efficiency` of its motor."""


def requirements(path: Path) -> tuple[tuple[Asked, ...], dict[str, float]]:
    """Returns what a file of requirements asks for, and its data of power. Raises InputError with the line."""
    source = read(path)
    data = source.data if isinstance(source.data, dict) else {}
    if strange := [name for name in data if name not in ("requirements", "power")]:
        place = replace(source.place((strange[0],)), name="")  # a file that is none may be confidential
        raise InputError(Problem(expected="requirements or power", found="another key", place=place))
    listed = data.get("requirements", [] if "power" in data else None)
    if not isinstance(listed, list):
        raise InputError(source.error((), "expected 'requirements', a list of entries with id, text, metric, below"))
    asked = tuple(_asked(source, i, entry) for i, entry in enumerate(listed))
    ids = [one.id for one in asked]
    if twice := next((i for i, name in enumerate(ids) if name in ids[:i]), None):
        raise InputError(source.error(("requirements", twice, "id"), f"expected another id, {ids[twice]} is taken"))
    power, stated = {}, data.get("power") or {}
    if not isinstance(stated, dict):
        raise InputError(
            source.error(("power",), f"expected rod, wheel or efficiency, each with its value, found {stated}")
        )
    for name, value in stated.items():
        if name not in ("rod", "wheel", "efficiency"):
            raise InputError(source.error(("power", name), "expected rod, wheel or efficiency"))
        with source.naming(("power", name)):
            power[name] = value_in(value, ONE if name == "efficiency" else WATT)
        if not 0.0 < power[name] <= (1.0 if name == "efficiency" else math.inf):
            most = " and at most 1" if name == "efficiency" else ""
            raise InputError(source.error(("power", name), f"expected a number above 0{most}, found {value}"))
    return asked, power


def _asked(source: Source, i: int, entry: Any) -> Asked:
    key = ("requirements", i)
    if not isinstance(entry, dict) or entry.get("id") is None or "metric" not in entry:
        raise InputError(source.error(key, "expected id, text, metric, and below or above"))
    known = {"id", "text", "metric", "below", "above", "probability", "confidence"}
    if strange := [name for name in entry if name not in known]:
        raise InputError(source.error((*key, strange[0]), f"expected one of {', '.join(sorted(known))}"))
    ends = [name for name in ("below", "above") if name in entry]
    if len(ends) != 1:
        raise InputError(source.error(key, "expected exactly one of below and above"))
    metric = str(entry["metric"])
    limit = entry[ends[0]]
    value = None
    if metric in METRICS:
        try:
            value = value_in(limit, METRICS[metric][1])
        except QuantityError as error:
            raise InputError(source.error((*key, ends[0]), str(error))) from None
        unit = METRICS[metric][1]
        limit = f"{limit} {unit.name}" if unit != ONE and str(limit).strip().replace(".", "", 1).isdigit() else limit
        if value <= 0.0 or (unit == RADIAN and value > math.pi):
            most = " and at most 180 deg, which all errors are" if unit == RADIAN else ""
            raise InputError(source.error((*key, ends[0]), f"expected a limit above 0{most}, found {limit}"))
    shares = []
    for name, default in (("probability", 0.95), ("confidence", 0.95)):
        share = entry.get(name, default)
        if not isinstance(share, (int, float)) or not 0.0 < share < 1.0:
            raise InputError(source.error((*key, name), f"expected a number above 0 and below 1, found {share}"))
        shares.append(float(share))
    return Asked(
        str(entry["id"]),
        str(entry.get("text", "")),
        metric,
        value if ends == ["below"] else None,
        value if ends == ["above"] else None,
        shares[0],
        shares[1],
        f"{ends[0]} {limit}",
        source.where(key),
    )
