"""A satellite as a scenario states it, and what is derived from its values.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

import plant
from orchestration import InputError, Scenario
from orchestration.quantities import parse_unit, value_in
from orchestration.session.open import open_scenario
from plant.drag import AXES, octagonal_cylinder
from plant.so3 import Array
from plant.solar_pressure import PRESSURE

from ..lasting import RADIAN
from ..loop import parameters

BLIND = 1e-6
"""rad/s: a star tracker that gives no attitude above it is none."""
ESTIMATORS, DYNAMICS = ("estimator", "estimator_wheels"), 2
"""Kinds of block, and the item of `rate_source` that takes no gyro."""
PLANTS = ("plant", "plant_wheels")
FIELD, RADIUS = 3.0e-5, 6371.2e3
"""T and m: the Earth's dipole field at its equator, twice as strong at the poles (IGRF-14 rounded)."""


@dataclass(frozen=True)
class Satellite:
    """The plant of a scenario with what is compared with it."""

    p: plant.Parameters
    sensors: dict[str, Any]
    """Start values of the sensors by name, in SI units; empty without sensors."""
    control_period: float
    """s; 0 where it is not known."""
    goal: float | None
    """rad: the tightest limit of an attitude error among the expectations."""
    mass: float | None
    without_gyro: bool = False
    """Whether the estimator has none, or loses it by a fault of the scenario."""
    measures_attitude: bool = False
    """Whether the estimator is given an attitude, as of a star tracker."""

    torque_told: float = 0.0
    """N m: over RADIAN, of which the estimator is told as a random walk of the momentum."""

    @cached_property
    def period(self) -> float:
        """s, of the orbit."""
        return 2.0 * math.pi * math.sqrt(self.p.orbit.semi_major_axis**3 / self.p.gravitational_parameter)

    @cached_property
    def J(self) -> Array:
        """(3,3) kg m2. A scenario in which all moments are per unit of mass says so by its factor on drag."""
        return self.p.J_B / self.p.drag_factor if 0.0 < self.p.drag_factor < 1.0 else self.p.J_B

    @cached_property
    def size(self) -> Array:
        """(3,) m: the body's extent along its axes."""
        return np.array([self.p.body_length if a == self.p.body_axis else self.p.body_width for a in AXES])

    @cached_property
    def heavy(self) -> float:
        """kg: the mass, or that of a homogeneous body with this inertia."""
        across = self.size @ self.size - self.size**2
        return self.mass or float((12.0 * np.diag(self.J) / across).mean())

    @property
    def field(self) -> float:
        """T: the least of the dipole's field along the orbit."""
        return FIELD * (RADIUS / self.p.orbit.semi_major_axis) ** 3

    @property
    def rods(self) -> float:
        """N m: the torque of the weakest rod, or of all where it is none, across the least field."""
        return float(self.p.dipole_limit.max()) * self.field

    @property
    def turned(self) -> float:
        """s: T, in which rods turn the body by a radian in the field near the poles (docs/how/planned-scales.md)."""
        mean = min(np.trace(self.p.J_B) / 3.0, 10.0 * float(np.linalg.eigvalsh(self.p.J_B)[0]))
        return math.sqrt(max(mean, 0.0) / (2.0 * self.rods)) if self.rods > 0.0 else math.inf

    def disturbances(self) -> dict[str, float]:
        """Returns the largest torque, N m, of each cause at any attitude along the orbit."""
        p = self.p
        radius = p.orbit.semi_major_axis
        moments = np.linalg.eigvalsh(p.J_B)
        plates = octagonal_cylinder(p.body_width, p.body_length, p.body_axis)
        shadow = float(plates.areas.sum()) / 2.0  # no shadow of a convex body is larger
        arm = float(np.linalg.norm(p.center_of_mass_B))
        causes = {"constant": float(np.linalg.norm(p.disturbance_torque_B))}
        causes["residual dipole"] = float(np.linalg.norm(p.residual_dipole_B)) * 2.0 * self.field
        if p.gravity_gradient:
            causes["gravity gradient"] = 1.5 * p.gravitational_parameter / radius**3 * float(moments[2] - moments[0])
        if p.drag:
            flows = [p.air.flow(t) for t in np.linspace(0.0, self.period, 24)]
            pressure = max(0.5 * density * float(flow @ flow) for flow, density in flows)
            causes["drag"] = p.drag_factor * p.drag_coefficient * pressure * shadow * arm
        if p.solar_pressure:
            longest = 0.5 * float(np.linalg.norm(self.size))
            push = PRESSURE * shadow
            causes["sunlight"] = push * ((1.0 + p.solar_specular) * arm + p.solar_diffuse * longest)
        return causes

    def lasting(self) -> dict[str, float]:
        """Returns what disturbs at the attitude that is held, too, N m."""
        return {name: value for name, value in self.disturbances().items() if name != "gravity gradient"}


def satellite(scenario: Scenario, mass: float | None = None) -> Satellite:
    """Returns the satellite of a scenario with a block `plant` or `plant_wheels`. Raises InputError."""
    opened = open_scenario(scenario)
    by_kind = {entry.fmu: name for name, entry in reversed(scenario.blocks.items())}
    block = next((block for block in PLANTS if block in by_kind), None)
    if block is None:
        raise InputError(
            scenario.error(("blocks",), "expected a block with 'fmu: plant' or 'fmu: plant_wheels', found none")
        )

    def starts(kind: str) -> dict[tuple[str, int], Any]:
        name = by_kind.get(kind)
        return {(s.element.variable, s.element.position): s.value for s in opened.plan.starts[name]} if name else {}

    try:
        p: plant.Parameters = parameters(block, starts(block), plant)
        _ = p.gmst0  # of the epoch, a text that the block reads once it is initialized
    except ValueError as error:
        key = ("shared", "epoch") if "epoch" in scenario.shared else ("blocks", by_kind[block])
        raise InputError(scenario.error(key, str(error).removeprefix("epoch: "))) from None
    sensors: dict[str, Any] = {}
    for (variable, _), value in (starts("plant_sensors") | starts("plant_sensors_wheels")).items():
        if isinstance(value, (int, float)):
            sensors[variable] = max(abs(value), sensors.get(variable, 0.0))
    periods = [
        v for kind in by_kind for (name, _), v in starts(kind).items() if name in ("control_period", "command_period")
    ]
    entries = [entry.every * scenario.step for entry in scenario.blocks.values()]
    estimator = next((by_kind[kind] for kind in ESTIMATORS if kind in by_kind), "")
    told = {name: value for kind in ESTIMATORS for (name, _), value in starts(kind).items()}
    gyro = told.get("rate_source") != DYNAMICS and _given(scenario, estimator, "omega_B_measured")
    tracker = _given(scenario, estimator, "R_NB_measured") and sensors.get("attitude_rate_max", 1.0) > BLIND
    return Satellite(
        p,
        sensors,
        max([*periods, *entries], default=0.0),
        goal(scenario),
        mass or scenario.data.mass,
        bool(estimator) and not gyro,
        bool(estimator) and tracker,
        float(told.get("momentum_random_walk", 0.0)) / math.sqrt(RADIAN),
    )


def _given(scenario: Scenario, block: str, port: str) -> bool:
    """Returns whether an input is connected, and no fault cuts or freezes what it is given."""
    sources = [c.source for c in scenario.connections if (c.target.block, c.target.variable) == (block, port)]
    away = [fault.cut or fault.freeze for fault in scenario.faults]
    lost = {(name.block, name.variable) for name in away if name is not None}
    return bool(sources) and not lost & {(block, port), *((s.block, s.variable) for s in sources)}


def goal(scenario: Scenario) -> float | None:
    """Returns the tightest limit, rad, below which expectations want an attitude error always."""
    limits = []
    for entry in scenario.expect:
        always = getattr(entry, "always", None)
        below = getattr(always, "below", None)
        if below is not None and str(entry.signal).endswith("attitude_error") and str(entry.signal).startswith("judge"):
            limits.append(value_in(below, parse_unit("rad")))
    return min(limits, default=None)
