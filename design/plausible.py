"""Whether a satellite's values fit each other, before anything is flown.

A finding has a number, the bound and what to change. Nothing is refused: what is unusual may be meant.
Longer than 250 lines: each comparison with its words.
Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
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

from .loop import parameters

PLANTS = ("plant", "plant_wheels")
FIELD, RADIUS = 3.0e-5, 6371.2e3
"""T and m: the Earth's dipole field at its equator, twice as strong at the poles (IGRF-14 rounded)."""
DENSITY = (10.0, 6000.0)
"""kg/m3, of a homogeneous body with this inertia: an empty hull, and near that of steel."""
TURNS = (3.0, 1000.0)
"""s, in which rods turn the body by a radian: 16 for a 1U, 170 for 500 kg."""
SPIN_UP, HOLDS = (2.0, 2000.0), (0.05, 60.0)
"""s in which a motor fills its wheel; deg/s of the body that a full wheel holds."""
SMALL, DIPOLES = 25.0, (0.5, 1.0)
"""kg of a small satellite; A m2 of a rod for each kg of it, and of a larger one: 0.03 to 0.15 of CubeSats, 0.75 of the
paper's."""
DISC = 0.1
"""Of the mass: a disc as wide as the body, beyond whose inertia a wheel is none that fits."""
NOISY = 2.0
"""Largest change of a wheel's momentum by its noise from sample to sample, beside what the rods give in that time."""
WEAK = 0.1
"""Of the strongest rod's dipole: below it a rod counts as none."""
APART = 10.0
"""deg, at least: between a rod and the plane of the two others."""
SPEEDS = (500.0, 50_000.0)
"""rpm of a full wheel."""
SHARE = 0.3
"""Of the rods' torque that disturbances may take: across the field is a part of all directions only."""
LONG, LEVER, NONE = 1.5, 0.25, 1e-8
"""Length over width of a long body; offset of the centre of mass over the size; N m s below which a wheel is none."""
WHEEL = "@"
"""Stands for the name of a wheel."""


@dataclass(frozen=True)
class Finding:
    what: str
    """With its number."""
    bound: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.what}; expected {self.bound}; {self.remedy}"


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
            flows = [
                p.air.flow(t)
                for t in np.linspace(0.0, 2.0 * math.pi * math.sqrt(radius**3 / p.gravitational_parameter), 24)
            ]
            pressure = max(0.5 * density * float(flow @ flow) for flow, density in flows)
            causes["drag"] = p.drag_factor * p.drag_coefficient * pressure * shadow * arm
        if p.solar_pressure:
            longest = 0.5 * float(np.linalg.norm(self.size))
            push = PRESSURE * shadow
            causes["sunlight"] = push * ((1.0 + p.solar_specular) * arm + p.solar_diffuse * longest)
        return causes


def findings(scenario: Scenario, mass: float | None = None) -> list[Finding]:
    """Returns what is not plausible of the satellite of a scenario; `mass` in kg, else that of the scenario's `data`.

    Raises InputError.
    """
    return list(_compared(satellite(scenario, mass)))


def notes(scenario: Scenario) -> list[str]:
    """Returns the findings as notes of a run; a scenario without a satellite has none."""
    if not any(entry.fmu in PLANTS for entry in scenario.blocks.values()):
        return []
    return [f"not plausible: {finding}" for finding in findings(scenario)]


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
    goals = _goals(scenario)
    return Satellite(
        p, sensors, max([*periods, *entries], default=0.0), min(goals, default=None), mass or scenario.data.mass
    )


def _goals(scenario: Scenario) -> list[float]:
    """The limits, rad, that expectations have for an attitude error that is always below them."""
    limits = []
    for entry in scenario.expect:
        always = getattr(entry, "always", None)
        below = getattr(always, "below", None)
        if below is not None and str(entry.signal).endswith("attitude_error") and str(entry.signal).startswith("judge"):
            limits.append(value_in(below, parse_unit("rad")))
    return limits


def _compared(s: Satellite) -> Iterator[Finding]:
    yield from _of_inertia(s)
    yield from _of_body(s)
    yield from _of_rods(s)
    yield from _of_wheels(s)
    yield from _of_no_wheel(s)
    yield from _of_sensors(s)


def _of_inertia(s: Satellite) -> Iterator[Finding]:
    moments = np.linalg.eigvalsh(s.J)
    shown = ", ".join(f"{m:.4g}" for m in np.linalg.eigvalsh(s.p.J_B))
    if moments[2] > moments[0] + moments[1]:
        yield Finding(
            f"J_B has the principal moments {shown} kg.m2; the largest is {moments[2] / (moments[0] + moments[1]):.3g} "
            "times the sum of the two others",
            "at most 1, as of any body",
            "check the signs of the products and the units",
        )
        return
    across = (s.size @ s.size - s.size**2).tolist()  # a2 + b2 about each axis
    least, most = DENSITY
    if s.mass is None:
        density = s.heavy / float(s.size.prod())
        if not least <= density <= most:
            yield Finding(
                f"J_B of {shown} kg.m2 in a body of {_size(s.size)} is that of {s.heavy:.3g} kg, {density:.3g} kg/m3",
                f"{least:g} to {most:g} kg/m3",
                f"check the units ({_unit(density, least, most)}), or body_width and body_length; "
                "deployed parts may be meant",
            )
        return
    density = s.mass / float(s.size.prod())
    if not least <= density <= most:
        grams = least <= 1e-3 * density <= most
        yield Finding(
            f"{s.mass:g} kg in a body of {_size(s.size)} is {density:.3g} kg/m3",
            f"{least:g} to {most:g} kg/m3",
            f"check the units{' (in g it would fit)' if grams else ''}, or body_width and body_length",
        )
    for name, moment, square in zip("xyz", np.diag(s.J).tolist(), across, strict=True):
        bound = s.mass * square / 4.0  # all of it in the farthest edges
        if not 0.02 * bound <= moment <= bound:
            yield Finding(
                f"the moment of inertia about {name} is {moment:.4g} kg.m2",
                f"{0.02 * bound:.3g} to {bound:.3g} kg.m2 of {s.mass:g} kg within {_size(s.size)}",
                f"check the units ({_unit(moment, 0.02 * bound, bound)}); deployed parts may be meant",
            )


def _unit(value: float, least: float, most: float) -> str:
    """The unit by whose mistake a value may be beyond its bounds."""
    for name, factor in (("g.m2", 1e-3), ("kg.cm2", 1e-4), ("kg.mm2", 1e-6)):
        for scaled, said in (
            (value * factor, f"in {name} it would fit"),
            (value / factor, f"it may be meant in kg.m2, not {name}"),
        ):
            if least <= scaled <= most:
                return said
    return "no unit of inertia explains it"


def _size(size: Array) -> str:
    return " by ".join(f"{x:.3g}" for x in size) + " m"


def _of_body(s: Satellite) -> Iterator[Finding]:
    p, moments = s.p, np.diag(s.p.J_B)
    along = AXES.index(p.body_axis)
    ratio = p.body_length / p.body_width
    others = np.delete(moments, along)
    if (ratio > LONG and moments[along] > others.min()) or (ratio < 1.0 / LONG and moments[along] < others.max()):
        kind = "long" if ratio > LONG else "flat"
        best = AXES[int(moments.argmin() if ratio > LONG else moments.argmax())]
        yield Finding(
            f"body_axis {p.body_axis} of a {kind} body, {_size(s.size)}, has the moment of inertia "
            f"{moments[along]:.4g} kg.m2, "
            f"the others {others[0]:.4g} and {others[1]:.4g}",
            f"the {'least' if kind == 'long' else 'largest'} about it",
            f"body_axis: {best}?",
        )
    share = np.abs(p.center_of_mass_B) / s.size
    if share.max() > LEVER:
        worst = int(share.argmax())
        yield Finding(
            f"center_of_mass_B is {1e3 * p.center_of_mass_B[worst]:.3g} mm off the middle along {AXES[worst]}, "
            "where the body is "
            f"{1e3 * s.size[worst]:.3g} mm long",
            f"at most {LEVER:g} of it",
            "it counts from the middle, in m",
        )
    if (rate := float(np.degrees(np.linalg.norm(p.omega_B0)))) > 60.0:
        yield Finding(f"omega_B0 is {rate:.3g} deg/s", "at most 60 deg/s", "numbers without a unit are rad/s")


def _of_rods(s: Satellite) -> Iterator[Finding]:
    least, most = TURNS
    if not least <= s.turned <= most:
        yield Finding(
            f"rods of {s.p.dipole_max:g} A.m2 turn this body by a radian in {s.turned:.3g} s",
            f"{least:g} to {most:g} s",
            f"dipole_max is too {'small' if s.turned > most else 'large'} for J_B, by {_times(s.turned, least, most)}",
        )
    dipole, bound = float(s.p.dipole_limit.max()), DIPOLES[s.heavy > SMALL]
    if dipole > bound * s.heavy:
        yield Finding(
            f"a rod gives {dipole:.3g} A.m2 in a body of {s.heavy:.3g} kg",
            f"at most {bound:g} A.m2 for each kg",
            "check the unit and the point of dipole_max",
        )
    weak = np.flatnonzero(s.p.dipole_limit < WEAK * s.p.dipole_limit.max()) + 1
    if len(weak):
        yield Finding(
            f"rod {', '.join(map(str, weak))} gives at most {s.p.dipole_limit.min():.3g} A.m2, the strongest "
            f"{s.p.dipole_limit.max():.3g} A.m2",
            f"at least {WEAK:g} of it",
            "check rod_limits: one rod gives torque about one axis at a time, two leave one to the field that turns",
        )
    across = np.abs(np.linalg.det(s.p.rods_to_body)) / np.array(
        [np.linalg.norm(np.cross(*np.delete(s.p.rods_to_body.T, i, axis=0))) for i in range(3)]
    )
    if (apart := math.degrees(math.asin(min(float(across.min()), 1.0)))) < APART:
        yield Finding(
            f"rod {int(across.argmin()) + 1} is {apart:.3g} deg from the plane of the two others",
            f"{APART:g} deg or more",
            "check rod_axes: across that plane the rods give next to nothing",
        )
    if s.control_period > 0.2 * s.turned:
        yield Finding(
            f"the control acts every {s.control_period:g} s",
            f"at most a fifth of the {s.turned:.3g} s in which the rods turn the body",
            f"--set step={_rounded(0.02 * s.turned)} s and a control_period of five steps",
        )
    causes = s.disturbances()
    total = sum(causes.values())
    if total > SHARE * s.rods:
        yield Finding(
            f"disturbances are up to {total:.3g} N.m ({_parts(causes)}), the rods give {s.rods:.3g} N.m in the weakest "
            "field",
            f"at most {SHARE:g} of them",
            "a larger dipole_max, or a smaller disturbance",
        )
    normal = 90.0 - abs(90.0 - math.degrees(s.p.orbit.inclination))
    if normal < 10.0:
        yield Finding(
            f"the orbit is inclined by {normal:.3g} deg, and the field hardly turns along it",
            "10 deg or more",
            "rods give no torque about the orbit's normal for long: a wheel has to hold what gathers there",
        )


def _lasting(s: Satellite) -> dict[str, float]:
    """Returns what disturbs at the attitude that is held, too, N m."""
    return {name: value for name, value in s.disturbances().items() if name != "gravity gradient"}


def _parts(causes: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.2g}" for name, value in sorted(causes.items(), key=lambda c: -c[1]))


def _rounded(value: float) -> str:
    return f"{value:.1g}"


def _times(value: float, least: float, most: float) -> str:
    """A factor on a dipole, by whose root the time goes."""
    return f"{(value / most) ** 2:.2g} times" if value > most else f"{(least / value) ** 2:.2g} times"


def _of_wheels(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of the wheels; what is the same of several is said once."""
    found: dict[Finding, list[int]] = {}
    for number, (wheel, axis) in enumerate(zip(s.p.wheel_list, s.p.wheel_axes, strict=True), start=1):
        if wheel.momentum_max >= NONE:
            for finding in _of_wheel(s, wheel, axis):
                found.setdefault(finding, []).append(number)
    for finding, numbers in found.items():
        listed = ", ".join(map(str, numbers))
        name = "the wheel" if not s.p.is_set else f"wheel {listed}" if len(numbers) == 1 else f"each of wheels {listed}"
        yield replace(finding, what=finding.what.replace(WHEEL, name))


def _of_wheel(s: Satellite, wheel: Any, axis: Array) -> Iterator[Finding]:
    """Yields what is found of a wheel, which is called WHEEL."""
    period = 2.0 * math.pi * math.sqrt(s.p.orbit.semi_major_axis**3 / s.p.gravitational_parameter)
    gathered = _lasting(s)
    spin_up = wheel.momentum_max / wheel.torque_max if wheel.torque_max > 0.0 else math.inf
    if not SPIN_UP[0] <= spin_up <= SPIN_UP[1]:
        yield Finding(
            f"{WHEEL} is full after {spin_up:.3g} s of its largest torque",
            f"{SPIN_UP[0]:g} to {SPIN_UP[1]:g} s",
            f"check the units of wheel_torque_max ({wheel.torque_max:g} N.m) and wheel_momentum_max "
            f"({wheel.momentum_max:g} N.m.s)",
        )
    held = math.degrees(wheel.momentum_max / float(axis @ s.p.J_B @ axis))
    if not HOLDS[0] <= held <= HOLDS[1]:
        yield Finding(
            f"{WHEEL}, full, turns the body at {held:.3g} deg/s about its axis",
            f"{HOLDS[0]:g} to {HOLDS[1]:g} deg/s",
            "check wheel_momentum_max against J_B",
        )
    rpm = wheel.momentum_max / wheel.inertia * 30.0 / math.pi
    if not SPEEDS[0] <= rpm <= SPEEDS[1]:
        yield Finding(
            f"{WHEEL}, full, turns at {rpm:.3g} rpm",
            f"{SPEEDS[0]:g} to {SPEEDS[1]:g} rpm",
            f"check wheel_inertia ({wheel.inertia:g} kg.m2) against wheel_momentum_max ({wheel.momentum_max:g} N.m.s)",
        )
    if wheel.inertia > (fits := 0.5 * DISC * s.heavy * (0.5 * float(s.size.min())) ** 2):
        yield Finding(
            f"{WHEEL} has an inertia of {wheel.inertia:.3g} kg.m2",
            f"at most {fits:.2g} kg.m2 of a disc as wide as the body with {DISC:g} of its {s.heavy:.3g} kg",
            f"check wheel_inertia ({_unit(wheel.inertia, 1e-4 * fits, fits)})",
        )
    emptied = wheel.momentum_max / s.rods if s.rods > 0.0 else math.inf
    if not 1.0 <= emptied <= 0.5 * period:
        which = "weak for the wheel" if emptied > 1.0 else "strong for it"
        yield Finding(
            f"the rods take the momentum of {WHEEL} away in {emptied:.3g} s",
            f"1 s to half an orbit, {0.5 * period:.0f} s",
            f"the rods are too {which}: check dipole_max and wheel_momentum_max",
        )
    if (steady := 0.25 * period * sum(gathered.values())) > wheel.momentum_max and emptied <= 0.5 * period:
        yield Finding(
            f"disturbances gather up to {steady:.3g} N.m.s in a quarter of an orbit, {WHEEL} holds "
            f"{wheel.momentum_max:g} N.m.s",
            "less than it holds",
            "the rods have to unload it all the time: a larger wheel or a smaller disturbance",
        )


def _of_no_wheel(s: Satellite) -> Iterator[Finding]:
    """Rods give no torque along the field: while it turns, gravity or the body's inertia has to bear what acts there.

    docs/evidence/satellites.md: of 100 tumbles with a sixth of the bound and drag 61 stay below 15 deg, with 1.6
    times it 2.
    """
    if s.goal is None or any(wheel.momentum_max >= NONE for wheel in s.p.wheel_list):
        return
    acting = _lasting(s)
    bound = 2.0 * float(np.trace(s.p.J_B)) / 3.0 * s.p.gravitational_parameter / s.p.orbit.semi_major_axis**3
    if (total := sum(acting.values())) > bound:
        yield Finding(
            f"there is no wheel, and disturbances are up to {total:.2g} N.m ({_parts(acting)})",
            f"at most {bound:.2g} N.m, twice the mean moment of inertia times the square of the orbit's rate",
            f"rods alone seldom stay within {math.degrees(s.goal):.3g} deg: a wheel, a smaller residual dipole or a "
            "higher orbit",
        )


def _of_sensors(s: Satellite) -> Iterator[Finding]:
    told = s.sensors.get("wheel_momentum_noise", 0.0) / s.control_period if s.control_period > 0.0 else 0.0
    if told > NOISY * s.rods > 0.0:
        yield Finding(
            f"the noise of the wheel's momentum from one control period to the next is {told:.2g} N.m, the rods give "
            f"{s.rods:.2g} N.m",
            f"at most {NOISY:g} times as much",
            "wheel_momentum_noise is the error of the wheel's speed that is told times its inertia: check both",
        )
    if not s.sensors or s.goal is None:
        return
    if s.sensors.get("attitude_noise", 0.0) > 0.0 and s.sensors.get("attitude_rate_max", 1.0) > 1e-6:
        known = math.hypot(s.sensors["attitude_noise"], s.sensors.get("attitude_bias_B", 0.0))
        by = "attitude_noise"
    elif s.sensors.get("field_noise", 0.0) > 0.0:
        known = (s.sensors["field_noise"] + s.sensors.get("field_bias_B", 0.0)) / s.field + s.sensors.get(
            "field_scale", 0.0
        )
        by = "noise, bias and scale of the magnetometer"
    else:
        return
    if s.goal < known:
        yield Finding(
            f"an attitude error of {math.degrees(s.goal):.3g} deg is expected",
            f"above the {math.degrees(known):.3g} deg of {by}",
            "another goal, or other sensors, such as --set 'sensors=star tracker'",
        )
