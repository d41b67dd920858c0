"""The rows of docs/evidence/failures.md as campaigns: the tumbles of docs/evidence/flight.md under all errors, with a
failure that nobody tells of."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from orchestration.campaign.case import Case

from .. import crew
from ..flight.cases import ALARMS, EARLY, LONG, tumbles
from ..flight.schemes import Data, base, change
from ..paper import ORBIT
from ..satellites import classes

SEED = 600
HELD, HOLD = 3000.0, 6000.0
"""s: from HELD on a failure is one in the hold; when most of these come."""
GAIN = 0.9
"""What a rod gives that has not failed."""
ASKED = 1e-8
"""N m: below it nothing is asked of the wheel."""
TABLES = RODS, OTHERS, SENSORS, UNSEARCHED, WHEEL = "rods", "others", "sensors", "unsearched", "wheel"
"""The tables of the page."""


@dataclass(frozen=True)
class Row:
    """Flights with one failure, for three orbits from it on."""

    table: str
    text: str
    """What fails, as the page says it."""
    faults: tuple[Data, ...] = field(hash=False)
    push: float = 1e-5
    """N m: the size of the disturbance torque, constant in the body."""
    flag: str = "rod_failed"
    rod: int = 0
    """Which rod fails; 0: none."""
    start: Mapping[str, Any] = field(default_factory=dict, hash=False)
    """Start values beside those of the tumbles."""
    satellite: str = ""
    """One of docs/evidence/satellites.md with its tumbles; empty: the paper's, on its orbit."""

    @property
    def at(self) -> float:
        """Time of the failure, s."""
        return float(self.faults[0]["at"])

    @property
    def since(self) -> float:
        """From when on the hold counts, s: of rods alone over the third orbit; else from a failure in the hold, or
        from EARLY."""
        if self.table == WHEEL:
            return self.at + 2.0 * ORBIT
        if self.satellite:
            return classes.EARLY
        return self.at if self.at >= HELD else EARLY

    @property
    def end(self) -> float:
        """End of the flight, s: three orbits after the failure, or more."""
        return self.at + (classes.DURATION if self.satellite else LONG)

    @property
    def name(self) -> str:
        """By which the CSV file knows it."""
        return f"{self.table}: {self.text}, {1e6 * self.push:g} uN m"

    def case(self, flights: int) -> Case:
        """The campaign, checked. Raises InputError."""
        data = base("failures")
        group = (
            classes.tumbles(self.satellite, flights, errors=True, data=data)
            if self.satellite
            else tumbles(self.name, SEED, flights, errors=True, data=data)
        )
        data = change(group.scenario, self.start)
        data |= {"faults": [dict(fault) for fault in self.faults], "duration": self.end}
        vary = {**group.vary, "plant.disturbance_torque_B": f"{self.push} * push"}
        campaign = {
            "name": re.sub(r"\W+", "_", self.name),
            "scenario": data,
            "draw": group.draw,
            "vary": {name: {"expression": text} for name, text in vary.items()},
            "runs": flights,
            "seed": group.seed,
            "metrics": [{"name": name, **metric} for name, metric in self._metrics(group.slow).items()],
        }
        return crew.case(campaign, Path(__file__).parent)

    def _metrics(self, slow: float) -> dict[str, Data]:
        angle: Data = {"signal": "judge.attitude_error"}
        rate: Data = {"signal": "judge.rate_error_B", "measure": "norm"}
        from_it, held = {"after": self.at}, {"after": self.since}
        wheel: Data = {"signal": "allocator.wheel_torque_cmd"}
        return {
            "angle": {**angle, "settles": {"below": "5 deg"}},
            "rate": {**rate, "settles": {"below": f"{slow} rad/s"}},
            "within_15": {**angle, "settles": {"below": "15 deg"}, **from_it},
            "within_5": {**angle, "settles": {"below": "5 deg"}, **from_it},
            "given_up": {**wheel, "settles": {"within": f"{ASKED} N.m"}, **from_it},
            "hold_rms": {**angle, "statistic": "rms", **held},
            "hold_max": {**angle, "statistic": "maximum", **held},
            **{name: {"signal": f"controller.{name}", "reaches": {"equals": True}} for name in ALARMS},
            **{f"rod_{i}": {"signal": "controller.failed_rod", "reaches": {"equals": i}} for i in (1, 2, 3)},
        }


def _rod(i: int, gain: float, at: float = 0.0) -> tuple[Data, ...]:
    return ({"at": at, "set": f"plant.rod_gain[{i}] = {gain}"},)


def _frozen(signal: str, at: float, until: float | None = None) -> tuple[Data, ...]:
    fault: Data = {"at": at, "freeze": f"sensors.{signal}"}
    return (fault if until is None else {**fault, "until": until},)


def _biased(size: float) -> tuple[Data, ...]:
    """T, the same along each axis of the body."""
    return ({"at": HELD, "bias": "sensors.b_B_measured", "by": [size / math.sqrt(3.0)] * 3},)


def _wheel(parameter: str, value: float, at: float = 0.0) -> tuple[Data, ...]:
    return ({"at": at, "set": f"plant.wheel_{parameter} = {value}"},)


def _drags(text: str, torque: float, at: float = 0.0) -> Row:
    return Row(SENSORS, text, _wheel("coulomb_friction", torque, at), 1e-5, "wheel_failed")


def _stuck(text: str, push: float, *more: Data, at: float = 0.0, momentum: float = 0.0) -> Row:
    faults = (*_wheel("torque_max", 0.0, at), *more)
    return Row(WHEEL, text, faults, push, "wheel_failed", start={"plant.h_w0": momentum})


def _other(satellite: str, i: int, how: str) -> Row:
    push = classes.ALL[satellite].disturbance(errors=True)
    return Row(OTHERS, f"{satellite}: rod {i} {how}", _rod(i, _GAINS[how]), push, rod=i, satellite=satellite)


_CALM: Data = {"at": ORBIT, "set": "plant.disturbance_torque_B = [0, 0, 0]"}
_GAINS = {"dead": 0.0, "gives half": 0.5 * GAIN, "reversed": -GAIN}
ROWS = (
    *(
        Row(RODS, f"rod {i} {how}, from the start", _rod(i, gain), push, rod=i)
        for how, gain in _GAINS.items()
        for i in (1, 2, 3)
        for push in (1e-6, 1e-5)
    ),
    *(Row(RODS, f"rod {i} dies after 6000 s, in the hold", _rod(i, 0.0, HOLD), rod=i) for i in (1, 2, 3)),
    _other("1U", 1, "dead"),
    _other("3U", 1, "dead"),
    _other("3U", 3, "gives half"),
    _other("6U", 2, "dead"),
    _other("12U", 2, "reversed"),
    _other("12U, wheel along e3", 1, "dead"),
    _other("150 kg", 3, "dead"),
    _other("500 kg", 1, "dead"),
    _other("50 kg, flat", 2, "dead"),
    _other("50 kg, elongated", 3, "reversed"),
    Row(
        SENSORS,
        "attitude frozen for 600 s, after 300 s",
        _frozen("R_NB_measured", 300.0, 900.0),
        flag="attitude_frozen",
    ),
    Row(
        SENSORS,
        "attitude frozen for 600 s in the hold",
        _frozen("R_NB_measured", HOLD, HOLD + 600.0),
        flag="attitude_frozen",
    ),
    Row(SENSORS, "attitude frozen for good in the hold", _frozen("R_NB_measured", HOLD), flag="attitude_frozen"),
    Row(SENSORS, "field frozen for good after 100 s", _frozen("b_B_measured", 100.0), flag="field_failed"),
    Row(SENSORS, "field frozen for good in the hold", _frozen("b_B_measured", HOLD), flag="field_failed"),
    *(
        Row(SENSORS, f"field with a bias of {size} µT after 3000 s", _biased(1e-6 * size), flag="field_failed")
        for size in (12, 6, 3.6, 2.9, 1.9, 1.0)
    ),
    _drags("wheel drags with 1.5 mN m from the start", 1.5e-3),
    _drags("wheel drags with 1.5 mN m in the hold", 1.5e-3, HOLD),
    _drags("wheel drags with 0.3 mN m from the start", 3e-4),
    _drags("wheel drags with 0.3 mN m in the hold", 3e-4, HOLD),
    *(
        Row(UNSEARCHED, f"rod {i} {how}", _rod(i, gain), push, rod=i, start={"controller.find_failures": False})
        for how, gain in _GAINS.items()
        for i in (1, 2, 3)
        for push in ((1e-6, 1e-5) if how == "dead" else (1e-5,))
    ),
    _stuck("stuck from the start", 1e-6),
    _stuck("stuck from the start", 1e-5),
    _stuck("stuck from the start, without a disturbance", 0.0),
    _stuck("stuck from the start with 1 mN m s", 0.0, momentum=1e-3),
    _stuck("stuck after 6000 s, in the hold", 1e-6, at=HOLD),
    _stuck("stuck from the start, the disturbance for one orbit", 1e-5, _CALM),
)
