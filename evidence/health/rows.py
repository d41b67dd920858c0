"""One part that fails, as a campaign: the tumbles of scenarios/campaigns/estimated.yaml and its like, from any place on
the orbit, so that a failure comes in light and in eclipse. Tests: tests/evidence/health/test_rows.py."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from orchestration.campaign.case import Case

from .. import crew
from ..paper import ORBIT, ROOT
from .verdict import BOUND, ERROR, HOLD, LATE, RATE, REST, TUMBLE

Data = dict[str, Any]
AFTER = 1.5 * ORBIT
"""s from the failure to the end."""
SEED = 700
SENSORS = ("gyro", "magnetometer", "GNSS", "star_tracker", "sun_sensors")
"""As the output `health` counts them."""


@dataclass(frozen=True)
class Actuators:
    """Actuators that are left."""

    rods: tuple[int, ...]
    """Those that work, 0 to 2."""
    wheel: bool = True
    stuck: int | None = None
    """The rod that is stuck on at STUCK_SHARE."""


@dataclass(frozen=True)
class Row:
    """Flights in which one part fails."""

    campaign: str
    """Of scenarios/campaigns: whose satellite and draws."""
    text: str
    """What fails, and when."""
    at: float
    faults: tuple[Data, ...] = field(hash=False)
    part: str = ""
    """Which part is to be named; empty: none."""
    actuators: Actuators | None = None
    """What is left of them, where that may not suffice for a hold."""

    @property
    def parts(self) -> tuple[str, ...]:
        """All that have failed and may be named."""
        also = {"rods 1 and 2": "rod_2", "wheel stuck": "wheel_friction", "wheel friction": "wheel"}
        return (self.part, *(part for text, part in also.items() if text in self.text)) if self.part else ()

    @property
    def pair(self) -> bool:
        """Returns whether two parts fail, which is flown and reported, without a goal."""
        return "rods 1 and 2" in self.text

    @property
    def name(self) -> str:
        return f"{self.campaign}: {self.text}"

    def case(self, flights: int) -> Case:
        """The campaign, checked. Raises InputError."""
        angle: Data = {"signal": ERROR, "unit": "deg"}
        told = self.at if self.faults else 0.0
        begins, recovered = ("tumble", LATE) if self.at == TUMBLE else ("hold", REST)
        campaign = {
            "extends": str(ROOT / "scenarios" / "campaigns" / f"{self.campaign}.yaml"),
            "name": re.sub(r"\W+", "_", self.name),
            "scenario": {
                "extends": str(ROOT / "scenarios" / f"flight_{SETS[self.campaign]}.yaml"),
                "duration": self.at + AFTER,
                "faults": [dict(fault) for fault in self.faults],
            },
            "draw": {"place": {"uniform": ["0 deg", "360 deg"]}},
            "vary": {"plant.argument_of_latitude": {"expression": "place"}},
            "runs": flights,
            "seed": SEED,
            "metrics": [
                {"name": "held", "python": f"verdict:held_{begins}", "signals": [ERROR, BOUND]},
                {"name": "rate", "python": f"verdict:rate_{begins}", "signals": [RATE, BOUND]},
                {
                    "name": "spin",
                    "signal": RATE,
                    "measure": "norm",
                    "statistic": "maximum",
                    "unit": "deg/s",
                    "after": self.at + recovered,
                },
                {"name": "largest", "statistic": "maximum", "after": self.at + recovered, **angle},
                {"name": "last", "statistic": "final", **angle},
                *({"name": name, "after": told, **metric} for name, metric in named(self.campaign).items()),
            ],
            "requirements": [],
            "keep": {},
        }
        return crew.case(campaign, Path(__file__).parent)


def named(campaign: str = "estimated") -> dict[str, Data]:
    """Returns when each part is named: metrics by the part; friction where half of what grows is estimated."""
    rods: dict[str, Data] = {
        f"rod_{i}": {"signal": "controller.failed_rod", "reaches": {"equals": i}} for i in (1, 2, 3)
    }
    sensors: dict[str, Data] = {
        name: {"signal": f"estimator.health[{i + 1}]", "reaches": {"above": 1.5}} for i, name in enumerate(SENSORS)
    }
    wheel: Data = {"signal": "controller.wheel_failed", "reaches": {"equals": True}}
    telemetry: Data = {"signal": "controller.h_w_frozen", "reaches": {"equals": True}}
    friction: Data = {"signal": "controller.wheel_friction_estimate", "reaches": {"above": 5.0 * FRICTION[campaign]}}
    return {**rods, **sensors, "wheel": wheel, "wheel_telemetry": telemetry, "wheel_friction": friction}


def _both(campaign: str, text: str, part: str, *faults: Data, left: Actuators | None = None) -> tuple[Row, Row]:
    """The failure in the tumble and in the hold; times of the faults count from it."""

    def at(begin: float) -> tuple[Data, ...]:
        return tuple({**f, **{k: begin + f[k] for k in ("at", "until") if k in f}} for f in faults)

    return (
        Row(campaign, f"{text}, in the tumble", TUMBLE, at(TUMBLE), part, left),
        Row(campaign, f"{text}, in the hold", HOLD, at(HOLD), part, left),
    )


def _set(text: str, at: float = 0.0, until: float | None = None) -> Data:
    return {"at": at, "set": f"plant.{text}"} | ({} if until is None else {"until": until})


def _sensor(kind: str, signal: str, element: int | None = None, **more: Any) -> Data:
    return {"at": 0.0} | {kind: f"sensors.{signal}_measured" + (f"[{element}]" if element else "")} | more


def _drift(signal: str, by: float) -> tuple[Data, ...]:
    """A bias of each axis that grows in twelve steps, each too small for a jump."""
    grown = [_sensor("bias", signal, at=50.0 * k, by=[by * (k + 1) / 12.0] * 3) for k in range(12)]
    return tuple(fault | ({"until": fault["at"] + 50.0} if k < 11 else {}) for k, fault in enumerate(grown))


def _held(command: str) -> Data:
    """As by a computer that stops."""
    return {"at": 0.0, "until": 120.0, "freeze": f"allocator.{command}"}


STUCK_SHARE = 0.2
SATELLITE = {"estimated": "paper_50kg", "estimated_star_tracker": "paper_50kg", "cubesat": "cubesat_3u"}
SETS = {"estimated": "estimated", "estimated_star_tracker": "star_tracker", "cubesat": "cubesat"}
"""The scenario of each campaign, flight_*.yaml."""
_LARGE, _SMALL = ("[2.887, 2.887, -2.887]", "[0, 0, 5]"), ("[0.06, 0, 0]", "[0, 0, 0.06]")
DIPOLES = {"estimated": _LARGE, "estimated_star_tracker": _LARGE, "cubesat": _SMALL}
"""A m2: 20% of rod 1 along its axis, and of rod 3."""
FRICTION = {"estimated": 2e-5, "estimated_star_tracker": 2e-5, "cubesat": 2e-6}
"""N m by which the wheel's friction grows each 100 s, ten times."""
ROWS: tuple[Row, ...] = (
    *(Row(which, "nothing", HOLD, ()) for which in SETS),
    *(
        row
        for which in SETS
        for rows in (
            _both(which, "rod 1 dead", "rod_1", _set("rod_gain[1] = 0")),
            _both(which, "rod 2 reversed", "rod_2", _set("rod_gain[2] = -1")),
            _both(which, "rod 3 gives half", "rod_3", _set("rod_gain[3] = 0.5")),
            _both(
                which,
                "rod 1 stuck on at 20%",
                "rod_1",
                _set("rod_gain[1] = 0"),
                _set(f"residual_dipole_B = {DIPOLES[which][0]}"),
                left=Actuators((1, 2), stuck=0),
            ),
            _both(
                which,
                "rod 3 stuck on at 20%",
                "rod_3",
                _set("rod_gain[3] = 0"),
                _set(f"residual_dipole_B = {DIPOLES[which][1]}"),
                left=Actuators((0, 1), stuck=2),
            ),
            _both(
                which,
                "rod 1 dead for 60 s of each 120 s",
                "rod_1",
                *(_set("rod_gain[1] = 0", 120.0 * k, 120.0 * k + 60.0) for k in range(9)),
            ),
            _both(which, "magnetometer frozen", "magnetometer", _sensor("freeze", "b_B")),
            _both(which, "magnetometer with a bias of 12 uT", "magnetometer", _sensor("bias", "b_B", by=[7e-6] * 3)),
            _both(which, "magnetometer drifts by 12 uT in 600 s", "magnetometer", *_drift("b_B", 7e-6)),
            _both(which, "gyro frozen", "gyro", _sensor("freeze", "omega_B")),
            _both(which, "gyro with a bias of 0.5 deg/s", "gyro", _sensor("bias", "omega_B", by=[5e-3] * 3)),
            _both(which, "gyro drifts by 0.5 deg/s in 600 s", "gyro", *_drift("omega_B", 5e-3)),
            _both(which, "Sun sensors frozen", "sun_sensors", _sensor("freeze", "sun_B")),
            _both(which, "GNSS frozen for 600 s, but counting", "GNSS", _sensor("freeze", "r_N", until=600.0)),
            _both(which, "wheel stuck", "wheel", _set("wheel_torque_max = 0"), left=Actuators((0, 1, 2), wheel=False)),
            _both(
                which,
                "rods 1 and 2 dead",
                "rod_1",
                _set("rod_gain[1] = 0"),
                _set("rod_gain[2] = 0"),
                left=Actuators((2,)),
            ),
            _both(
                which,
                "wheel friction grows for 1000 s",
                "wheel_friction",
                *(_set(f"wheel_coulomb_friction = {(k + 1) * FRICTION[which]:g}", 100.0 * k) for k in range(10)),
            ),
            _both(which, "wheel telemetry frozen", "wheel_telemetry", _sensor("freeze", "h_w")),
            _both(which, "one axis of the gyro dead", "gyro", _sensor("cut", "omega_B", element=1)),
            _both(which, "commands held for 120 s", "", *(_held(f"{kind}_cmd") for kind in ("dipole", "wheel_torque"))),
        )
        for row in rows
    ),
    *_both(
        "estimated_star_tracker",
        "star tracker frozen for 1200 s",
        "star_tracker",
        _sensor("freeze", "R_NB", until=1200.0),
    ),
)
