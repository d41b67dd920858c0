"""What else docs/flight.md flies: tumbles with one thing different; and the list of all cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from fmus.interface import load

from .. import setup
from ..paper import SCENARIOS, Array
from ..samples import wrong_inertias
from ..setup import Loop
from .cases import (
    BESIDE,
    HOLD_NODES,
    LONG,
    NODES,
    SHORT,
    TRIES,
    Case,
    Data,
    J,
    base,
    change,
    flight,
    hold,
    manoeuvre,
    pairings,
    seeds,
    share,
    tumble,
    unit,
    without,
)


@dataclass(frozen=True)
class Tried:
    """Nominal tumbles with one thing different."""

    name: str
    text: str
    """What is different, as the page says it."""
    alter: Callable[[Data, np.random.Generator], Any]
    """Changes the scenario in place."""
    errors: bool = False

    def case(self, seed: int) -> Case:
        data = change(base(), tumble(seed, self.errors))
        self.alter(data, np.random.default_rng((seed, 1)))
        return Case(self.name, seed, data, (SHORT,))

    def on(self, seed: int) -> Case:
        """The same flown on to three orbits."""
        return replace(self.case(seed), group=f"{self.name} flown on", lengths=(LONG,), late=SHORT)


def _turned(axes: Iterable[Iterable[float]], angle: float, rng: np.random.Generator) -> Array:
    """Unit rows, each turned by an angle in a random direction."""
    found = []
    for u in np.array([list(row) for row in axes]):
        across = np.cross(u, unit(rng))
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
        new = wrong_inertias(J, 1, int(rng.integers(2**31)), 0.3 if known else 0.1)[0]
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
    change(data, {"plant.omega_B0": math.radians(30.0) * unit(rng)})


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
    return setup.read(SCENARIOS["V.B"]).loop


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
    Tried("dipole no b_B", "a dipole as onboard field model, `b_B` not connected", _dipole_alone),
    Tried(
        "no feed-forward errors",
        "all errors, no feed-forward to the allocator",
        _lost("allocator.dipole_ff", "allocator.wheel_torque_ff"),
        True,
    ),
    Tried("no u_applied errors", "all errors, `u_applied` not connected", _lost("controller.u_applied"), True),
    Tried("no h_w errors", "all errors, `h_w` of the controller not connected", _lost("controller.h_w"), True),
    Tried("30 deg/s", "a start at 30 deg/s", _fast),
)

FLOWN_ON = ("rod 1 failed", "rod 2 failed")
"""A rod that gives nothing: some of the cases that have settled are flown on."""


def tried(n: int) -> list[Case]:
    """The cases of TRIED, in proportion to n random cases of the study, and those of FLOWN_ON."""
    few = seeds("tried", share(n, TRIES))
    on = [t for t in TRIED if t.name in FLOWN_ON]
    return [t.case(seed) for seed in few for t in TRIED] + [t.on(seed) for seed in few[: share(n, 10)] for t in on]


def all_cases(n: int) -> list[Case]:
    """Everything that is flown, with n random cases under each condition, and of the smaller sets in proportion."""
    cases = [flight("nominal", s) for s in seeds("nominal", n)]
    cases += [flight("errors", s, errors=True) for s in seeds("errors", n)]
    cases += [manoeuvre(which, node) for which in ("vb", "vc") for node in NODES]
    for scheme in ("tuned", "paper"):
        some = share(n, BESIDE)
        cases += [flight(f"nominal {scheme}", s, scheme) for s in seeds("nominal", some)]
        cases += [flight(f"errors {scheme}", s, scheme, True) for s in seeds("errors", some)]
        cases += [manoeuvre(which, node, scheme) for which in ("vb", "vc") for node in NODES]
    cases += [hold(node) for node in HOLD_NODES] + pairings()
    return cases + tried(n)
