"""What each group of constants is flown on: flights in which its constants count."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from orchestration.campaign.case import read_campaign

from ..flight.cases import SEEDS, Group, drawn, tumbles
from ..flight.schemes import Data, base, change
from ..flight.tried import TRIED
from ..paper import ORBIT, ROOT
from ..satellites.classes import tumbles as tumbles_of_satellite
from .loop import FROZEN_ATTITUDE, FROZEN_FIELD, Flight, parameters, tumbles_of

WHEEL, GIVEN_UP, ATTITUDE, FIELD = 3, 4, 5, 6
"""Alarms behind those of the rods, in the order of loop.c."""
IN_HOLD, UNTIL, JUDGED, SOON = 1000.0, 1800.0, 1200.0, 700.0
"""s: when a part fails in the hold; the end of a flight with a failure, and from when its hold is judged; the end where none is."""
LOW, NEAR = math.radians(15.0), 6771e3
"""Inclination, rad; radius of an orbit with strong drag, m."""
FRICTION = {"plant.wheel_coulomb_friction": 5e-5, "plant.wheel_viscous_friction": 1e-7}
WHEEL_NOISE, RATE_NOISE = {"sensors.wheel_momentum_noise": 1e-5}, {"sensors.rate_noise": 1e-4}
FAST = {"plant.omega_B0": [math.radians(25.0) * x / 3.0 for x in (2.0, -1.0, 2.0)]}


@dataclass(frozen=True)
class Failure:
    """What fails in a tumble under all errors, and the alarms that it is to raise; by default nothing, and none."""

    expected: tuple[int, ...] = ()
    changes: Data = field(default_factory=dict)
    at: float = 0.0
    frozen: int = 0
    before: Data = field(default_factory=dict)
    """Start values of the flight itself."""
    held: bool = True
    """Whether the hold is judged; else the flight ends sooner."""


def _rod(number: int, gain: float, at: float = 0.0) -> Failure:
    return Failure((number,), {"plant.rod_gain": [gain if i == number else 0.9 for i in range(3)]}, at)


def _field(size: float) -> Failure:
    return Failure((FIELD,), {"sensors.field_bias_B": [size * x / 3.0 for x in (2.0, -1.0, 2.0)]}, IN_HOLD)


def _drags(torque: float) -> Failure:
    return Failure((WHEEL,), {"plant.wheel_coulomb_friction": torque}, held=False)


_STUCK = Failure((WHEEL, GIVEN_UP), {"plant.wheel_torque_max": 0.0}, held=False)
RODS = (
    *(_rod(i, gain) for gain in (0.0, 0.5) for i in range(3)),
    _rod(0, -0.9),
    _rod(0, 0.0, IN_HOLD),
    _rod(1, 0.0, IN_HOLD),
    Failure(),
    Failure(before=FAST, held=False),
    Failure(before=FAST, held=False),
)
SENSORS = (
    *(Failure((ATTITUDE,), at=at, frozen=FROZEN_ATTITUDE) for at in (100.0, IN_HOLD)),
    *(Failure((FIELD,), at=at, frozen=FROZEN_FIELD) for at in (100.0, IN_HOLD)),
    *map(_field, (12e-6, 3.6e-6, 2.9e-6, 2.5e-6)),
    *(Failure(before={"controller.field_degree": degree}) for degree in (1, 2)),
)
MOTOR = (
    _drags(1.5e-3),
    _drags(2e-3),
    _STUCK,
    _STUCK,
    *(Failure(before=before, held=False) for before in (FRICTION, WHEEL_NOISE)),
)


def _tumbles(kind: str, runs: int) -> Group:
    return tumbles(kind, SEEDS[kind], runs, errors=kind == "errors")


def _campaign(name: str, runs: int) -> list[Data]:
    return drawn(read_campaign(ROOT / "scenarios" / "campaigns" / f"{name}.yaml"), runs)


def _acquisition(runs: int) -> list[Flight]:
    return [Flight(given) for given in tumbles_of(_tumbles("nominal", runs))]


def _hold(runs: int) -> list[Flight]:
    return [Flight(given, until=2.0 * ORBIT, hold=ORBIT) for given in tumbles_of(_tumbles("errors", runs))]


def _small(runs: int) -> list[Flight]:
    group = tumbles_of_satellite("1U", runs, errors=True)
    return [Flight(given, until=1.5 * ORBIT, hold=0.5 * ORBIT, rate=group.slow) for given in tumbles_of(group)]


def _much_drag(runs: int) -> list[Flight]:
    """The first tumbles of docs/evidence/flight.md at 400 km with ten times the drag, with their hold from `early` on."""
    group = next(t for t in TRIED if t.name == "drag").group(runs)
    return [whole(group, each) for each in group.drawn()]


def _below(satellite: str, start: str, limit: float) -> Callable[[int], list[Flight]]:
    """The first tumbles of a satellite with this start value below a limit, half of them under all errors."""

    def flights(runs: int) -> list[Flight]:
        found = []
        for errors in (False, True):
            group = tumbles_of_satellite(satellite, 100, errors)
            low = [drawn for drawn in group.drawn() if drawn[start] < limit][: runs // 2]
            found += [whole(group, each) for each in low]
        return found

    return flights


def whole(group: Group, tumble: Data) -> Flight:
    """A drawn tumble, flown as long as docs/evidence/satellites.md has it, with its hold from `early` on."""
    given = parameters({**group.scenario, "duration": group.duration}, tumble)
    return Flight(given, until=group.duration, hold=group.early, rate=group.slow)


def _estimate(runs: int) -> list[Flight]:
    """With friction; every second wheel's momentum is measured with noise, every third rate with ten times the noise told."""
    flights = []
    for i, values in enumerate(_campaign("free_errors", runs)):
        noise = (WHEEL_NOISE if i % 2 else {}) | (RATE_NOISE if i % 3 == 2 else {})
        given = parameters(base(), values, FRICTION, noise)
        flights.append(Flight(given, until=0.8 * ORBIT, hold=0.3 * ORBIT))
    return flights


def _failing(failures: tuple[Failure, ...]) -> Callable[[int], list[Flight]]:
    """The first failures, each in a tumble of its own."""

    def flights(runs: int) -> list[Flight]:
        group = _tumbles("errors", runs)
        found = []
        for failure, values in zip(failures, group.drawn(), strict=False):
            given, failed = (
                parameters(group.scenario, values, failure.before, changes) for changes in ({}, failure.changes)
            )
            until, hold = (UNTIL, JUDGED) if failure.held else (SOON, math.inf)
            found.append(Flight(given, failed, failure.frozen, failure.at, failure.expected, until, hold))
        return found

    return flights


def _rods_alone(runs: int) -> list[Flight]:
    stuck = change(base(), {"plant.wheel_torque_max": 0.0})
    return [
        Flight(parameters(stuck, values), until=1.6 * ORBIT, hold=1.1 * ORBIT, angle=math.radians(15.0), rate=math.inf)
        for values in _campaign("stuck_wheel", runs)
    ]


@dataclass(frozen=True)
class Cases:
    """The flights of a group, how many, and what they are measured by (measures.py)."""

    flights: Callable[[int], list[Flight]]
    runs: int
    measures: tuple[str, ...]


GROUPS = {
    "acquisition": Cases(_acquisition, 40, ("settled",)),
    "hold": Cases(_hold, 10, ("hold",)),
    "small satellite": Cases(_small, 2, ("hold",)),
    "low inclination": Cases(_below("50 kg, wheel along (1, 2, 2)/3", "plant.inclination", LOW), 12, ("hold",)),
    "much drag": Cases(_much_drag, 12, ("hold", "sound")),
    "strong drag": Cases(_below("3U", "plant.orbit_radius", NEAR), 12, ("hold", "sound")),
    "estimate": Cases(_estimate, 10, ("settled", "hold", "sound")),
    "failed rods": Cases(_failing(RODS), len(RODS), ("found", "sound", "hold")),
    "failed sensors": Cases(_failing(SENSORS), len(SENSORS), ("found", "sound", "hold")),
    "failed wheel": Cases(_failing(MOTOR), len(MOTOR), ("found", "sound")),
    "rods alone": Cases(_rods_alone, 6, ("settled", "hold")),
}
