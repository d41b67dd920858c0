"""What docs/flight.md flies: scenarios as data, each with a name and the seed that it comes from.

All are scenarios/flight_*.yaml with other start values, or with other blocks in the same places. Every random case
follows from one seed; seeds 1000 to 3999 were used in tuning and are none of these.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from fmus.interface import load
from orchestration.runner.read import read

from ..paper import INERTIA, ORBIT, ROOT, Array, constants
from ..samples import random_rotations

Data = dict[str, Any]

SEEDS = {"nominal": 100_000, "errors": 200_000, "tried": 300_000}
"""The first seed of each set of random cases; case i has the i-th after it."""
RATE_MAX = math.radians(6.0)
J = np.diag(INERTIA)
SHORT, LONG = 1.1 * ORBIT, 3.0 * ORBIT
"""How long a case is flown, s, and how long if it has not settled by then."""
RECORD = ("judge.attitude_error", "judge.rate_error_B", "plant.h_w")
TUNED = {"K0": [5.53e-3, 6.14e-3, 6.75e-3], "L0": (0.273 * np.eye(3)).tolist()}
"""Gains of law [8] in SI units with the bounded allocator: the best of `python -m studies flight-tune`."""


@dataclass(frozen=True)
class Case:
    """One flight."""

    group: str
    seed: int
    """That of a random case; for V.B and V.C the longitude of the node, deg."""
    data: Data = field(hash=False)
    """The scenario."""
    lengths: tuple[float, ...] = (SHORT, LONG)
    """Durations, s: the first, and those after it where the case has not settled."""
    late: float | None = None
    """What the errors are after this time, s, is told apart."""

    @property
    def name(self) -> str:
        return f"{self.group}/{self.seed}"


@cache
def _text(scenario: str) -> str:
    return json.dumps(read(ROOT / "scenarios" / f"flight_{scenario}.yaml").data)


def base(scenario: str = "tumble") -> Data:
    """A flight scenario as data that records what is needed, and expects and draws nothing."""
    data: Data = json.loads(_text(scenario))
    for key in ("expect", "figures"):
        data.pop(key, None)
    data["record"] = {"interval": 1.0, "signals": [*RECORD, "controller.phase"]}
    return data


def change(data: Data, changes: Mapping[str, Any]) -> Data:
    """Start values by `block.parameter`, set in place."""
    for name, value in changes.items():
        block, _, parameter = name.partition(".")
        data["blocks"][block].setdefault("start", {})[parameter] = (
            value.tolist() if isinstance(value, np.ndarray) else value
        )
    return data


NO_ERRORS: dict[str, Any] = {
    "plant.J_error_B": np.zeros((3, 3)),
    "plant.rod_gain": [1.0, 1.0, 1.0],
    "sensors.attitude_noise": 0.0,
    "sensors.rate_noise": 0.0,
    "sensors.field_noise": 0.0,
    "controller.field_error": [0.0, 0.0, 0.0],
}


def unit(rng: np.random.Generator) -> Array:
    """A direction (3,), uniform on the sphere."""
    v = rng.standard_normal(3)
    return np.asarray(v / np.linalg.norm(v))


def tumble(seed: int, errors: bool = False) -> dict[str, Any]:
    """Start values of a random case.

    Attitude uniform on SO(3), direction of the rate uniform, its size uniform in 0 to 6 deg/s, node uniform. Nominal: a
    disturbance of 1e-6 N m. Errors, all together: J 5 to 10% off in each axis, rods that give 0.9, a disturbance of 1e-5 N m,
    noise of 0.01 deg, 1e-5 rad/s and 50 nT, an onboard field 200 nT off in its first three coefficients.
    """
    rng = np.random.default_rng(seed)
    attitude = random_rotations(rng, 1)[0]
    rate = unit(rng) * RATE_MAX * rng.uniform()
    node = rng.uniform(0.0, 2.0 * math.pi)
    push = unit(rng)
    J_error = np.diag(np.diag(J) * rng.choice([-1.0, 1.0], 3) * rng.uniform(0.05, 0.1, 3))
    field_error = 200e-9 * unit(rng)
    start = {"plant.Q0": attitude, "plant.omega_B0": rate, "plant.node_longitude": node, "sensors.seed": seed}
    if not errors:
        return {**start, **NO_ERRORS, "plant.disturbance_torque_B": 1e-6 * push}
    return {
        **start,
        "plant.J_error_B": J_error,
        "plant.rod_gain": [0.9, 0.9, 0.9],
        "plant.disturbance_torque_B": 1e-5 * push,
        "sensors.attitude_noise": math.radians(0.01),
        "sensors.rate_noise": 1e-5,
        "sensors.field_noise": 50e-9,
        "controller.field_error": field_error,
    }


def without(data: Data, *targets: str) -> Data:
    """Takes out the connections to these inputs, `block.input` with all its elements; in place."""
    data["connections"] = [
        c for c in data["connections"] if c.split("->")[1].strip().partition("[")[0] not in set(targets)
    ]
    return data


def fit(data: Data, block: str, fmu: str, every: int | None = None) -> Data:
    """Puts another of the project's blocks in a block's place, with the connections that both ends have; in place."""
    entry = {"fmu": fmu, "every": every or data["blocks"][block]["every"]}
    ports = {v.name for v in load(fmu).variables.values() if v.causality != "parameter"}
    known = {v.name for v in load(fmu).of("parameter")}
    entry["start"] = {k: v for k, v in data["blocks"][block].get("start", {}).items() if k in known}
    data["blocks"][block] = entry

    def there(end: str) -> bool:
        owner, _, port = end.strip().partition("[")[0].partition(".")
        return owner != block or port in ports

    data["connections"] = [c for c in data["connections"] if all(map(there, c.split("->")))]
    if "phase" not in ports and block == "controller":
        data["record"]["signals"] = list(RECORD)
    return data


def papers(data: Data) -> Data:
    """The paper's scheme with its gains in SI units, at 10 Hz as in its reproduction."""
    fit(data, "controller", "controller", 1)
    fit(data, "allocator", "allocator", 1)
    data["blocks"]["sensors"]["every"] = 1
    gains = {k: v for k, v in constants(mass=1.0).items() if k in ("controller.K0", "controller.L0")}
    return change(data, {"allocator.hold_fraction": 0.8} | gains)


def tuned(data: Data, gains: Mapping[str, Any] = TUNED) -> Data:
    """Law [8] with gains tuned for SI units and the bounded allocator without feed-forward."""
    fit(data, "controller", "controller")
    return change(data, {f"controller.{k}": v for k, v in gains.items()})


SCHEMES: dict[str, Callable[[Data], Data]] = {"planned": lambda data: data, "tuned": tuned, "paper": papers}


def flight(group: str, seed: int, scheme: str = "planned", errors: bool = False) -> Case:
    """A random case by one of SCHEMES."""
    data = change(base(), tumble(seed, errors))
    return Case(group, seed, SCHEMES[scheme](data), (SHORT, LONG) if scheme == "planned" else (LONG,))


def manoeuvre(which: str, node: int, scheme: str = "planned") -> Case:
    """V.B ("vb") or V.C ("vc") from a node, deg."""
    data = change(base(which), {"plant.node_longitude": math.radians(node)})
    group = which if scheme == "planned" else f"{which} {scheme}"
    return Case(group, node, SCHEMES[scheme](data), (SHORT, LONG) if scheme == "planned" else (LONG,))


def seeds(kind: str, n: int) -> range:
    """The seeds of n cases of one of SEEDS."""
    return range(SEEDS[kind], SEEDS[kind] + n)


NODES = range(0, 360, 10)
HOLD_NODES = range(8, 360, 60)
HOLD_ORBITS = 20
BESIDE = 200
"""How many of the random cases the other schemes fly."""
TRIES = 50


def share(n: int, full: int) -> int:
    """How many of a set that has `full` with 1000 random cases, with n of them."""
    return min(n, max(2, full * n // 1000))


def hold(node: int) -> Case:
    """flight_hold.yaml from a node, deg."""
    data = change(base("hold"), {"plant.node_longitude": math.radians(node)})
    return Case("hold", node, data, (HOLD_ORBITS * ORBIT,), late=ORBIT)


PAIRINGS = {
    ("controller_planned", "allocator_bounded"): "planned controller, bounded allocator",
    ("controller_planned", "allocator"): "planned controller, the paper's allocator",
    ("controller", "allocator_bounded"): "the paper's controller, bounded allocator",
    ("controller", "allocator"): "the paper's controller and allocator",
}


def pairings() -> list[Case]:
    """V.B from 158 deg E by each of PAIRINGS; the paper's controller with the gains tuned for SI units."""
    cases = []
    for law, allocator in PAIRINGS:
        data = base("vb")
        if law != "controller_planned":
            tuned(data)
        if allocator != "allocator_bounded":
            fit(data, "allocator", allocator)
        cases.append(Case(f"{law} + {allocator}", 158, data, (LONG,)))
    return cases
