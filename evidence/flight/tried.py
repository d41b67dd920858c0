"""Tumbles with one thing different. Tests: tests/evidence/flight/test_flight.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from design.loop import Loop, read
from fmus.interface import load

from ..paper import INERTIA, SCENARIOS
from .cases import DRAWN, SEEDS, Group, tumbles
from .schemes import Data, base, change, without


@dataclass(frozen=True)
class Tried:
    """Nominal tumbles with one thing different."""

    name: str
    text: str
    """What is different, as the page says it."""
    alter: Callable[[Data], Any] = lambda data: data
    """Changes the scenario in place."""
    draw: Data = field(default_factory=dict, hash=False)
    vary: Callable[[], Data] = dict
    """What is drawn and varied beside what a tumble is."""
    errors: bool = False

    def group(self, runs: int) -> Group:
        """The campaign."""
        data = base()
        usual = tumbles(self.name, SEEDS["tried"], runs, self.errors, data=data)
        self.alter(data)
        return Group(self.name, data, runs, usual.seed, {**DRAWN, **self.draw}, {**usual.vary, **self.vary()})


def _fail(*faults: Mapping[str, Any]) -> Callable[[Data], Any]:
    return lambda data: data.__setitem__("faults", [dict(f) for f in faults])


def _start(**values: Any) -> Callable[[Data], Any]:
    return lambda data: change(data, {k.replace("__", "."): v for k, v in values.items()})


def _lost(*targets: str) -> Callable[[Data], Any]:
    return lambda data: without(data, *targets)


def _dead_and_known(data: Data) -> None:
    _fail({"at": 0.0, "cut": "plant.dipole_cmd[1]"})(data)
    change(data, {"controller.rod_gains0": [0, 1, 1]})


def _by_demand(data: Data) -> None:
    """The wheel follows the demand alone."""
    change(without(data, *FEED_FORWARD), {"allocator.desaturation_time": 1e9, "allocator.wheel_weight": 0.02})


def _late(data: Data) -> None:
    """One sample later: at a base step of the sample, so that a delay is as long as it."""
    data["step"] = 0.5
    for block in data["blocks"].values():
        block["every"] = 1
    data["delays"] = ["plant.dipole_cmd", "plant.wheel_torque_cmd"]


def _dipole_alone(data: Data) -> None:
    change(without(data, "controller.b_B"), {"controller.field_degree": 1})


FEED_FORWARD = ("allocator.dipole_ff", "allocator.wheel_torque_ff")
LOW = {"plant__orbit_radius": 6.771e6, "plant__f107": 230.0, "plant__f107_average": 230.0}
"""Start values of an orbit at 400 km near the maximum of the Sun."""
ANY: Data = {"any": {"sphere": 1.0}}
ANYWHERE: Data = {"along": {"uniform": ["0 deg", "360 deg"]}}
BODY: Data = {"axes": {"rotation": "uniform"}, "size": {"uniform": [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]}}
TURNS: Data = {f"turn{i}": {"sphere": 1.0} for i in (1, 2, 3)}


def body(most: float) -> str:
    """The inertia of a body near J as an expression of BODY: J' = S (1 + most E) S with S = J^(1/2).

    E is symmetric with eigenvalues uniform in [-1, 1] and axes uniform on SO(3), so (1 - most) J <= J' <= (1 + most)
    J: up to 0.25 the greatest moment of J' stays below the sum of the others, as a body's does.
    """
    root = f"diag(sqrt({list(INERTIA)}))"
    return f"{root} @ (diag([1, 1, 1]) + {most} * axes @ diag(size) @ transpose(axes)) @ {root}"


def _turned() -> str:
    """The rods' axes, each 2 deg off in the direction that TURNS draws."""
    axes = next(v for v in load("plant").of("parameter") if v.name == "rod_axes")
    rows = np.reshape(axes.start, (3, 3)).tolist()
    turned = [f"rotation(cross({u}, turn{i}), {math.radians(2.0)}) @ {u}" for i, u in enumerate(rows, 1)]
    return f"[{', '.join(turned)}]"


@cache
def scenario_loop() -> Loop:
    """The paper's loop, for what its plant's functions tell of orbits."""
    return read(SCENARIOS["V.B"]).loop


def _perigee(e: float) -> dict[str, str]:
    """Position and velocity as expressions: at the perigee of an orbit of the same semi-major axis, at `along` from
    its node."""
    orbit = scenario_loop().change({"plant.node_longitude": 0.0, "plant.argument_of_latitude": 0.0}).plant.orbit
    r, v = (np.asarray(x) for x in orbit.position_velocity(0.0))
    normal = np.cross(r, v)
    frame = np.column_stack((r / np.linalg.norm(r), v / np.linalg.norm(v), normal / np.linalg.norm(normal)))
    turned = f"rotation([0, 0, 1], node) @ {frame.tolist()} @ rotation([0, 0, 1], along)"
    near, fast = (1.0 - e) * float(np.linalg.norm(r)), math.sqrt((1.0 + e) / (1.0 - e)) * float(np.linalg.norm(v))
    return {"plant.r_N0": f"{turned} @ [{near}, 0, 0]", "plant.v_N0": f"{turned} @ [0, {fast}, 0]"}


TRIED = (
    Tried("as nominal", "nothing: the nominal case"),
    Tried("all errors", "all errors together", errors=True),
    Tried(
        "away from the node",
        "start anywhere on the orbit",
        draw=ANYWHERE,
        vary=lambda: {"plant.argument_of_latitude": "along"},
    ),
    Tried(
        "beside LVLH",
        "a target turned from LVLH at random (`R_d0`)",
        draw={"beside": {"rotation": "uniform"}},
        vary=lambda: {"controller.R_d0": "beside", "judge.R_d0": "beside"},
    ),
    Tried(
        "eccentric",
        "eccentricity of 0.02, start at any perigee",
        _start(plant__orbit_start="position_velocity"),
        ANYWHERE,
        lambda: _perigee(0.02),
    ),
    Tried(
        "products known",
        "inertia with products, up to 25% away, known",
        draw=BODY,
        vary=lambda: {"plant.J_B": body(0.25), "controller.J_B": body(0.25)},
    ),
    Tried(
        "products unknown",
        "inertia up to 10% away, not known",
        draw=BODY,
        vary=lambda: {"plant.J_error_B": f"{body(0.1)} - diag({list(INERTIA)})"},
    ),
    Tried(
        "rods misaligned", "each rod's axis 2° off, not known", draw=TURNS, vary=lambda: {"plant.rod_axes": _turned()}
    ),
    Tried(
        "taking turns",
        "rods on for 0.7 s of each second, not known",
        _start(plant__rod_period=1.0, plant__rod_duty=0.7),
    ),
    Tried(
        "wheel friction",
        "wheel friction of 0.2 mN m at full speed, not known",
        _start(plant__wheel_coulomb_friction=5e-5, plant__wheel_viscous_friction=1e-7),
    ),
    Tried("rate noise", "noise of 5·10⁻⁴ rad/s on the rate, not known", _start(sensors__rate_noise=5e-4)),
    Tried(
        "rate noise known",
        "noise of 5·10⁻⁴ rad/s on the rate, known",
        _start(sensors__rate_noise=5e-4, controller__rate_noise=5e-4),
    ),
    Tried(
        "rate bias",
        "a bias of 10⁻⁴ rad/s on the rate",
        draw=ANY,
        vary=lambda: {"sensors.rate_bias_B": "1e-4 * any"},
    ),
    Tried(
        "residual dipole",
        "a residual dipole of 1.25 A m²",
        draw=ANY,
        vary=lambda: {"plant.residual_dipole_B": "1.25 * any"},
    ),
    Tried("low orbit", "400 km, F10.7 of 230", _start(**LOW)),
    Tried("low orbit errors", "400 km, F10.7 of 230, all errors together", _start(**LOW), errors=True),
    Tried("drag", "400 km, F10.7 of 230, ten times the drag (0.06 mN m)", _start(plant__drag_factor=10.0, **LOW)),
    Tried(
        "drag unsearched",
        "the same, no search for failures (`find_failures` false)",
        _start(plant__drag_factor=10.0, controller__find_failures=False, **LOW),
    ),
    Tried("one sample late", "commands a sample (0.5 s) late, not known", _late),
    *(
        Tried(
            f"rod {i} failed", f"rod {i} gives nothing, not known", _fail({"at": 0.0, "cut": f"plant.dipole_cmd[{i}]"})
        )
        for i in (1, 2, 3)
    ),
    Tried("rod 1 known", "rod 1 gives nothing, known (`rod_gains0`)", _dead_and_known),
    Tried(
        "rod 3 limited",
        "rod 3 gives 10 A m² at most, known (`rod_limits`)",
        lambda data: change(
            data, {f"{block}.rod_limits": [1, 1, 0.4] for block in ("plant", "controller", "allocator")}
        ),
    ),
    Tried("rod 3 limited unknown", "rod 3 gives 10 A m² at most, not known", _start(plant__rod_limits=[1, 1, 0.4])),
    Tried("wheel stuck", "the wheel does not turn, not known", _start(plant__wheel_torque_max=0.0)),
    Tried("no u_applied", "`u_applied` not connected", _lost("controller.u_applied")),
    Tried("no h_w", "`h_w` of the controller not connected", _lost("controller.h_w")),
    Tried("neither", "neither `u_applied` nor `h_w` connected", _lost("controller.u_applied", "controller.h_w")),
    Tried("no feed-forward", "no feed-forward to the allocator", _lost(*FEED_FORWARD)),
    Tried("no b_B", "`b_B` of the controller not connected", _lost("controller.b_B")),
    Tried("dipole on board", "a dipole as onboard field model", _start(controller__field_degree=1)),
    Tried("dipole no b_B", "a dipole as onboard field model, `b_B` not connected", _dipole_alone),
    Tried("no feed-forward errors", "all errors, no feed-forward to the allocator", _lost(*FEED_FORWARD), errors=True),
    Tried(
        "no feed-forward by demand errors",
        "all errors, no feed-forward, the allocator follows the demand alone (`desaturation_time` 10⁹ s, "
        "`wheel_weight` 0.02)",
        _by_demand,
        errors=True,
    ),
    Tried("no u_applied errors", "all errors, `u_applied` not connected", _lost("controller.u_applied"), errors=True),
    Tried("no h_w errors", "all errors, `h_w` of the controller not connected", _lost("controller.h_w"), errors=True),
    Tried(
        "30 deg/s",
        "a start at 30 deg/s",
        vary=lambda: {"plant.omega_B0": f"{math.radians(30.0)} * omega / norm(omega)"},
    ),
)
