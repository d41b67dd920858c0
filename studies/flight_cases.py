"""What docs/flight.md flies: scenarios as data, each with a name and the seed that it comes from.

All are scenarios/flight_*.yaml with other start values, or with other blocks in the same places. Every random case
follows from one seed; seeds 1000 to 3999 were used in tuning and are none of these.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from fmus.interface import load
from orchestration.runner.read import read

from . import setup
from .claims import INERTIA, ORBIT, ROOT, SCENARIOS
from .setup import Loop
from .sweep import wrong_inertias
from .vectors import Array, random_rotations

Data = dict[str, Any]

SEEDS = {"nominal": 100_000, "errors": 200_000, "tried": 300_000}
"""The first seed of each set of random cases; case i has the i-th after it."""
RATE_MAX = math.radians(6.0)
J = np.diag(INERTIA)
SHORT, LONG = 1.1 * ORBIT, 3.0 * ORBIT
"""How long a case is flown, s, and how long if it has not settled by then."""
RECORD = ("plant.R_NB", "plant.omega_B", "plant.r_N", "plant.v_N", "plant.h_w")
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

    @property
    def name(self) -> str:
        return f"{self.group}/{self.seed}"


@cache
def _text(scenario: str) -> str:
    return json.dumps(read(ROOT / "scenarios" / f"flight_{scenario}.yaml").data)


def base(scenario: str = "tumble") -> Data:
    """A flight scenario as data that records what is needed, and expects and draws nothing."""
    data: Data = json.loads(_text(scenario))
    for key in ("expect", "figures", "cycle"):
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


def _unit(rng: np.random.Generator) -> Array:
    v = rng.standard_normal(3)
    return np.asarray(v / np.linalg.norm(v))


def tumble(seed: int, errors: bool = False) -> dict[str, Any]:
    """Start values of a random case.

    Attitude uniform on SO(3), direction of the rate uniform, its size uniform in 0 to 6 deg/s, node uniform. Nominal: a
    disturbance of 1e-6 N m. Errors, all together: J 5 to 10% off in each axis, rods that give 0.9, a disturbance of 1e-5 N m,
    noise of 0.01 deg, 1e-5 rad/s and 50 nT, an onboard field 200 nT off in its first three coefficients.
    """
    rng = np.random.default_rng(seed)
    attitude = random_rotations(rng, 1)[..., 0]
    rate = _unit(rng) * RATE_MAX * rng.uniform()
    node = rng.uniform(0.0, 2.0 * math.pi)
    push = _unit(rng)
    J_error = np.diag(np.diag(J) * rng.choice([-1.0, 1.0], 3) * rng.uniform(0.05, 0.1, 3))
    field_error = 200e-9 * _unit(rng)
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
    gains = {"K0": [0.65 * s for s in (0.9, 1.0, 1.1)], "L0": (0.9 * np.eye(3)).tolist()}
    return change(data, {"allocator.hold_fraction": 0.8} | {f"controller.{k}": v for k, v in gains.items()})


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
    group = which if scheme == "planned" else f"{which}, {scheme}"
    return Case(group, node, SCHEMES[scheme](data), (SHORT, LONG) if scheme == "planned" else (LONG,))


def seeds(kind: str, n: int) -> range:
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


def all_cases(n: int) -> list[Case]:
    """Everything that is flown, with n random cases under each condition, and of the smaller sets in proportion."""
    cases = [flight("nominal", s) for s in seeds("nominal", n)]
    cases += [flight("errors", s, errors=True) for s in seeds("errors", n)]
    cases += [manoeuvre(which, node) for which in ("vb", "vc") for node in NODES]
    for scheme in ("tuned", "paper"):
        some = share(n, BESIDE)
        cases += [flight(f"nominal, {scheme}", s, scheme) for s in seeds("nominal", some)]
        cases += [flight(f"errors, {scheme}", s, scheme, True) for s in seeds("errors", some)]
        cases += [manoeuvre(which, node, scheme) for which in ("vb", "vc") for node in NODES]
    cases += [hold(node) for node in HOLD_NODES] + pairings()
    return cases + [t.case(seed) for seed in seeds("tried", share(n, TRIES)) for t in TRIED]


def hold(node: int) -> Case:
    """flight_hold.yaml from a node, deg."""
    return Case(
        "hold", node, change(base("hold"), {"plant.node_longitude": math.radians(node)}), (HOLD_ORBITS * ORBIT,)
    )


# ---------------------------------------------------------------- what else was tried


@dataclass(frozen=True)
class Tried:
    """Nominal tumbles with one thing different."""

    name: str
    said: str
    """What is different, as the page says it."""
    alter: Callable[[Data, np.random.Generator], Any]
    """Changes the scenario in place."""
    errors: bool = False

    def case(self, seed: int) -> Case:
        data = change(base(), tumble(seed, self.errors))
        self.alter(data, np.random.default_rng((seed, 1)))
        return Case(self.name, seed, data, (SHORT,))


def _turned(axes: Iterable[Iterable[float]], angle: float, rng: np.random.Generator) -> Array:
    """Unit rows, each turned by an angle in a random direction."""
    found = []
    for u in np.array([list(row) for row in axes]):
        across = np.cross(u, _unit(rng))
        found.append(math.cos(angle) * u + math.sin(angle) * across / np.linalg.norm(across))
    return np.array(found)


def _fail(*faults: Mapping[str, Any]) -> Callable[[Data, np.random.Generator], Any]:
    return lambda data, _: data.__setitem__("faults", [dict(f) for f in faults])


def _start(**values: Any) -> Callable[[Data, np.random.Generator], Any]:
    return lambda data, _: change(data, {k.replace("__", "."): v for k, v in values.items()})


def _anywhere(data: Data, rng: np.random.Generator) -> None:
    change(data, {"plant.argument_of_latitude": rng.uniform(0.0, 2.0 * math.pi)})


def _products(known: bool) -> Callable[[Data, np.random.Generator], Any]:
    def alter(data: Data, rng: np.random.Generator) -> None:
        new = wrong_inertias(J, 1, int(rng.integers(2**31)), 0.3 if known else 0.1)[..., 0]
        if known:
            change(data, {"plant.J_B": new, "controller.J_B": new})
        else:
            change(data, {"plant.J_error_B": new - J})

    return alter


def _misaligned(data: Data, rng: np.random.Generator) -> None:
    axes = next(v for v in load("plant").of("parameter") if v.name == "rod_axes")
    change(data, {"plant.rod_axes": _turned(np.reshape(axes.start, (3, 3)), math.radians(2.0), rng)})


def _late(data: Data, _: np.random.Generator) -> None:
    """One sample later: at a base step of the sample, so that a delay is as long as it."""
    data["step"] = 0.5
    for block in data["blocks"].values():
        block["every"] = 1
    data["delays"] = ["plant.dipole_cmd", "plant.wheel_torque_cmd"]


def _fast(data: Data, rng: np.random.Generator) -> None:
    change(data, {"plant.omega_B0": math.radians(30.0) * _unit(rng)})


def _eccentric(data: Data, rng: np.random.Generator) -> None:
    """e = 0.02 at the same semi-major axis, from a perigee anywhere on the orbit."""
    node = float(data["blocks"]["plant"]["start"]["node_longitude"])
    place = {"plant.node_longitude": node, "plant.argument_of_latitude": rng.uniform(0.0, 2.0 * math.pi)}
    orbit = scenario_loop().change(place).plant.orbit
    r, v = orbit.position_velocity(0.0)
    e = 0.02
    factor = math.sqrt((1.0 + e) / (1.0 - e))
    change(data, {"plant.orbit_start": "position_velocity", "plant.r_N0": (1.0 - e) * r, "plant.v_N0": factor * v})


@cache
def scenario_loop() -> Loop:
    """The paper's loop, for what its plant's functions tell of orbits."""
    return setup.read(ROOT / SCENARIOS["V.B"]).loop


def _lost(*targets: str) -> Callable[[Data, np.random.Generator], Any]:
    return lambda data, _: without(data, *targets)


def _dipole_alone(data: Data, _: np.random.Generator) -> None:
    change(without(data, "controller.b_B"), {"controller.field_degree": 1})


TRIED = (
    Tried("as nominal", "nothing: the nominal case", lambda data, rng: None),
    Tried("all errors", "all errors together", lambda data, rng: None, errors=True),
    Tried("away from the node", "start anywhere on the orbit", _anywhere),
    Tried("eccentric", "orbit of eccentricity 0.02, start at its perigee, anywhere", _eccentric),
    Tried(
        "products known",
        "inertia with products, moments and axes up to 30% away, known to the controller",
        _products(True),
    ),
    Tried("products unknown", "the same up to 10% away, not known", _products(False)),
    Tried("rods misaligned", "each rod's axis 2° off, not known", _misaligned),
    Tried(
        "taking turns",
        "rods on for 0.7 s of each second, not known",
        _start(plant__rod_period=1.0, plant__rod_duty=0.7),
    ),
    Tried(
        "wheel friction",
        "wheel with 0.05 mN m Coulomb and 10⁻⁷ N m s/rad viscous friction (0.2 mN m at full speed), not known",
        _start(plant__wheel_coulomb_friction=5e-5, plant__wheel_viscous_friction=1e-7),
    ),
    Tried("one sample late", "commands a sample (0.5 s) late, not known", _late),
    *(
        Tried(
            f"rod {i} failed", f"rod {i} gives nothing, not known", _fail({"at": 0.0, "cut": f"plant.dipole_cmd[{i}]"})
        )
        for i in (1, 2, 3)
    ),
    Tried("wheel stuck", "the wheel does not turn, not known", _start(plant__wheel_torque_max=0.0)),
    Tried("no u_applied", "`u_applied` not connected", _lost("controller.u_applied")),
    Tried("no h_w", "`h_w` of the controller not connected", _lost("controller.h_w")),
    Tried("neither", "neither of the two", _lost("controller.u_applied", "controller.h_w")),
    Tried(
        "no feed-forward", "no feed-forward to the allocator", _lost("allocator.dipole_ff", "allocator.wheel_torque_ff")
    ),
    Tried("no b_B", "`b_B` of the controller not connected", _lost("controller.b_B")),
    Tried("dipole on board", "a dipole as onboard field model", _start(controller__field_degree=1)),
    Tried("dipole, no b_B", "a dipole as onboard field model, `b_B` not connected", _dipole_alone),
    Tried(
        "no feed-forward, errors",
        "all errors, no feed-forward to the allocator",
        _lost("allocator.dipole_ff", "allocator.wheel_torque_ff"),
        True,
    ),
    Tried("no u_applied, errors", "all errors, `u_applied` not connected", _lost("controller.u_applied"), True),
    Tried("no h_w, errors", "all errors, `h_w` of the controller not connected", _lost("controller.h_w"), True),
    Tried("30 deg/s", "a start at 30 deg/s", _fast),
)

PAIRINGS = {
    ("controller_planned", "allocator_bounded"): "planned controller, bounded allocator",
    ("controller_planned", "allocator"): "planned controller, the paper's allocator",
    ("controller", "allocator_bounded"): "the paper's controller, bounded allocator",
    ("controller", "allocator"): "the paper's controller and allocator",
}


def pairings() -> list[Case]:
    """V.B from 158 deg E by each pairing; the paper's controller with the gains tuned for SI units."""
    cases = []
    for law, allocator in PAIRINGS:
        data = base("vb")
        if law != "controller_planned":
            tuned(data)
        if allocator != "allocator_bounded":
            fit(data, "allocator", allocator)
        cases.append(Case(f"{law} + {allocator}", 158, data, (LONG,)))
    return cases
