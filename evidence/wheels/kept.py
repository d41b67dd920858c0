"""docs/evidence/wheels.csv: a line for each flight; docs/evidence/wheels.md is made from it.
Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

import plant
from orchestration.campaign.flying.rows import Rows

from .. import files
from ..flight.cases import HOLD
from ..health.stuck_on import INTERVAL, held, least_angle
from ..optimum.kept import Line
from ..paper import ROOT, Array
from ..satellites.classes import CLASSES
from .bound import plants
from .cases import CONDITIONS, DURATION, ORBIT, Flights

FILE = "wheels.csv"
LEAST = ROOT / "docs" / "evidence" / "wheels_optimum.csv"
REMEDY = "python -m evidence wheels"


@dataclass(frozen=True)
class Flown:
    """A flight: deg, deg/s and s; inf where it does not settle, NaN for a run that failed or no bound within an
    hour and 40 minutes."""

    satellite: str
    condition: str
    run: int
    inclination: float
    rate: float
    settled_5: float
    settled_1: float
    hold_rms: float
    hold_max: float
    wheel_share: float
    least_time: float
    found: float
    """When the last of the wheels that fail was found, s."""
    others: int
    """Wheels that do not fail and were reported."""
    least_angle: float
    """Of rods alone: the least largest angle of an orbit and a half from the hold's begin on that any use of them
    allows, deg (evidence/health/stuck_on.py)."""

    @property
    def settled(self) -> bool:
        return math.isfinite(self.settled_5)


def flown_of(flights: Flights, rows: Rows, bounds: Sequence[float | None]) -> Iterable[Flown]:
    """The flights of a campaign, with the least time of each where it is known."""
    value = {metric["name"]: rows.numbers(metric["name"]) for metric in rows.manifest["metrics"]}

    def until(angle: str) -> Array:
        times = np.nan_to_num(np.maximum(value[angle], value["rate"]), nan=math.inf)
        return np.where(times <= DURATION - HOLD, times, math.inf)

    five, one = until("angle_5"), until("angle_1")
    drawn = flights.drawn(max(rows.index.tolist()) + 1)
    wheel, lost = rows.numbers("wheel"), CONDITIONS[flights.condition].lost
    rods_alone, never = lost == flights.wheels, np.full(len(rows.index), math.nan)
    of_runs = plants(flights, len(drawn)) if rods_alone else []
    for i, run in enumerate(rows.index.tolist()):
        yield Flown(  # settled within the last HOLD counts as never
            flights.satellite,
            flights.condition,
            run,
            math.degrees(drawn[run]["plant.inclination"]),
            math.degrees(value["initial_rate"][i]),
            five[i],
            one[i],
            math.degrees(value["hold_rms"][i]),
            math.degrees(value["hold_max"][i]),
            value["wheel_max"][i] / CLASSES[flights.satellite].wheel_momentum_max,
            math.nan if run >= len(bounds) or bounds[run] is None else float(bounds[run] or 0.0),
            *found_in([value.get(f"found_{k}", never)[i] for k in range(4)], int(wheel[i]), lost, flights.wheels),
            _by_rods(of_runs[run]) if rods_alone else math.nan,
        )


def _by_rods(p: plant.Parameters) -> float:
    satellite, field = held(p, range(3), p.disturbance_torque_B.tolist(), wheel=False, begin=DURATION - ORBIT)
    return math.degrees(least_angle(satellite, field, np.zeros(3), INTERVAL))


def found_in(times: Sequence[float], wheel: int, lost: int, wheels: int) -> tuple[float, int]:
    """Returns when the last wheel that fails was reported, s, and how many others were; `times`: of each."""
    fail = {(wheel + k) % wheels for k in range(lost)}
    late = [math.inf if math.isnan(times[k]) else times[k] for k in fail]
    return max(late, default=math.nan), sum(math.isfinite(times[k]) for k in range(wheels) if k not in fail)


@dataclass(frozen=True)
class Least(Line):
    """The least time of a nominal tumble, by numerical optimal control."""

    satellite: str


def load_least() -> list[Least]:
    return files.load_if_any(Least, LEAST, f"{REMEDY} --part optimum")


def save_least(found: Iterable[Least]) -> None:
    order = list(CLASSES)
    files.save(Least, LEAST, sorted(found, key=lambda line: (order.index(line.satellite), line.run)))
