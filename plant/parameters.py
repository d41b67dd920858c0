"""Parameters of the plant and what follows from them alone.

Longer than 250 lines: each of the plant's parameters is a field here, and its check stands beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from . import atmosphere, geomagnetic, orbit, tables, time_scales
from .attitude import COMPOSITIONS, Body
from .drag import AXES, Drag, octagonal_cylinder
from .rods import Turns
from .so3 import Array, from_quaternion, project
from .sun import Sun
from .surroundings import Environment
from .wheel import Wheel

DRIFT_PASSES = 6
"""Each leaves about a thousandth of the last one's error."""

ROD_GAIN_MAX = 2.0
ROD_PERIOD_MIN = 1e-3
"""s."""

LOWEST_PERIGEE = orbit.WGS84_RADIUS + 100e3
"""m; below it the orbit is no orbit."""


@dataclass(frozen=True)
class Parameters:
    """Start values of the plant; units, frames and limits are those of fmus/interfaces/plant.toml."""

    J_B: Array
    J_error_B: Array
    wheel_inertia: float
    wheel_axis: Array
    wheel_momentum_max: float
    wheel_torque_max: float
    wheel_viscous_friction: float
    wheel_coulomb_friction: float
    dipole_max: float
    rod_axes: Array
    rod_gain: Array
    rod_period: float
    rod_duty: float
    residual_dipole_B: Array
    disturbance_torque_B: Array
    orbit_start: str
    orbit_radius: float
    inclination: float
    node_longitude: float
    argument_of_latitude: float
    r_N0: Array
    v_N0: Array
    j2_node_drift: bool
    epoch: str
    gravitational_parameter: float
    gravity_gradient: bool
    drag: bool
    drag_factor: float
    drag_coefficient: float
    body_width: float
    body_length: float
    body_axis: str
    center_of_mass_B: Array
    f107: float
    f107_average: float
    ap: float
    field_model: str
    field_degree: int
    field_extrapolate: bool
    initial_attitude: str
    Q0: Array
    q_NB0: Array
    omega_B0: Array
    h_w0: float
    integrator_order: int
    step_max: float

    @cached_property
    def body(self) -> Body:
        J = self.J_B + self.J_error_B
        axis = self.wheel_axis / np.linalg.norm(self.wheel_axis)
        return Body(J=J, J_inverse=np.asarray(np.linalg.inv(J), dtype=np.float64), wheel_axis=axis)

    @cached_property
    def wheel(self) -> Wheel:
        return Wheel(
            self.wheel_inertia,
            self.wheel_momentum_max,
            self.wheel_torque_max,
            self.wheel_viscous_friction,
            self.wheel_coulomb_friction,
        )

    @cached_property
    def rods_to_body(self) -> Array:
        """(3,3), columns u_i: takes the rods' dipoles to the body's."""
        return (self.rod_axes / np.linalg.norm(self.rod_axes, axis=1)[:, None]).T

    @cached_property
    def rod_turns(self) -> Turns:
        return Turns(self.rod_period, self.rod_duty)

    @cached_property
    def gmst0(self) -> float:
        return time_scales.gmst(time_scales.parse_epoch(self.epoch))

    @cached_property
    def orbit(self) -> orbit.Orbit:
        mu = self.gravitational_parameter
        if self.orbit_start == "circular":
            raan = self.gmst0 + self.node_longitude
            path = orbit.circular(self.orbit_radius, self.inclination, raan, self.argument_of_latitude, mu)
            return path.with_node_rate(_drift(path, mu)) if self.j2_node_drift else path
        path = orbit.from_position_velocity(self.r_N0, self.v_N0, mu)
        if not self.j2_node_drift:
            return path
        # v_N0 contains the plane's own turning, whose rate follows from the orbit in the plane: a fixed point.
        x, y, _ = self.r_N0.tolist()
        for _ in range(DRIFT_PASSES):
            rate = _drift(path, mu)
            path = orbit.from_position_velocity(self.r_N0, self.v_N0 - rate * np.array((-y, x, 0.0)), mu)
        return path.with_node_rate(rate)

    @cached_property
    def year(self) -> float:
        """The epoch as a decimal year."""
        return time_scales.decimal_year(time_scales.parse_epoch(self.epoch))

    @cached_property
    def field_extrapolated(self) -> bool:
        return not tables.field_model(self.field_model).covers(self.year)

    @cached_property
    def field(self) -> geomagnetic.FieldAlongOrbit:
        g, h = tables.field_model(self.field_model).at(self.year, self.field_extrapolate)
        return geomagnetic.FieldAlongOrbit(geomagnetic.Field(g, h, self.field_degree), self.orbit, self.gmst0)

    @cached_property
    def air(self) -> atmosphere.AirAlongOrbit:
        day0 = time_scales.day_of_year(time_scales.parse_epoch(self.epoch))
        state = atmosphere.Atmosphere(tables.density_model(), self.f107, self.f107_average, self.ap)
        return atmosphere.AirAlongOrbit(state, self.orbit, self.gmst0, day0)

    @cached_property
    def sun(self) -> Sun:
        return Sun(time_scales.days_since_j2000(time_scales.parse_epoch(self.epoch)))

    @cached_property
    def surface(self) -> Drag:
        plates = octagonal_cylinder(self.body_width, self.body_length, self.body_axis)
        return Drag(plates, self.center_of_mass_B, self.drag_factor * self.drag_coefficient)

    @cached_property
    def environment(self) -> Environment:
        return Environment(
            self.body.J,
            self.gravitational_parameter,
            self.orbit,
            self.field,
            self.gravity_gradient,
            self.air if self.drag else None,
            self.surface,
        )

    @cached_property
    def R_NB0(self) -> Array:
        """Attitude (3,3) at t = 0."""
        if self.initial_attitude == "q_NB0":
            return from_quaternion(self.q_NB0)
        return orbit.lvlh(*self.orbit.position_velocity(0.0)) @ project(self.Q0)


_AT_LEAST = (
    ("wheel_inertia", 1e-12, "kg.m2"),
    ("wheel_momentum_max", 0.0, "N.m.s"),
    ("wheel_torque_max", 0.0, "N.m"),
    ("wheel_viscous_friction", 0.0, "N.m.s/rad"),
    ("wheel_coulomb_friction", 0.0, "N.m"),
    ("dipole_max", 0.0, "A.m2"),
    ("gravitational_parameter", 1e14, "m3/s2"),
    ("step_max", 1e-6, "s"),
)
_DRAG_RANGES = (
    ("drag_factor", 0.0, 1e6, ""),
    ("drag_coefficient", 0.0, 10.0, ""),
    ("body_width", 1e-3, 100.0, " m"),
    ("body_length", 1e-3, 100.0, " m"),
    ("f107", 60.0, 400.0, " (1e-22 W/(m2 Hz))"),
    ("f107_average", 60.0, 300.0, " (1e-22 W/(m2 Hz))"),
    ("ap", 0.0, 400.0, ""),
)
_CHOICES = {
    "orbit_start": ("circular", "position_velocity"),
    "initial_attitude": ("Q0", "q_NB0"),
    "field_model": tables.field_models.NAMES,
}


def _drift(path: orbit.Orbit, mu: float) -> float:
    """Rate of the orbit's node, rad/s, under J2."""
    return orbit.j2_node_rate(path.semi_major_axis, path.eccentricity, path.inclination, mu)


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected, where the parameters describe no satellite."""
    if p.drag:
        _check_drag(p)
    unused = () if p.drag else ("center_of_mass_B", *(name for name, *_ in _DRAG_RANGES))
    for field in fields(p):
        value = getattr(p, field.name)
        if field.name not in unused and isinstance(value, float | np.ndarray) and not np.isfinite(value).all():
            found = value.tolist() if isinstance(value, np.ndarray) else value
            raise ValueError(f"{field.name} is {found}; expected finite numbers")
    for name, least, unit in _AT_LEAST:
        if getattr(p, name) < least:
            raise ValueError(f"{name} is {getattr(p, name)} {unit}; expected at least {least:g} {unit}")
    for name, choices in _CHOICES.items():
        if getattr(p, name) not in choices:
            raise ValueError(f"{name} is {getattr(p, name)!r}; expected one of {', '.join(choices)}")
    _check_inertia("J_B", p.J_B)
    _check_inertia("J_B + J_error_B", p.J_B + p.J_error_B)
    lengths = np.linalg.norm(p.rod_axes, axis=1)
    if np.abs(lengths - 1.0).max() > 1e-6:
        raise ValueError(f"rod_axes has rows of length {lengths.tolist()}; expected unit vectors, to 1e-6")
    if abs((length := float(np.linalg.norm(p.wheel_axis))) - 1.0) > 1e-6:
        raise ValueError(
            f"wheel_axis is {p.wheel_axis.tolist()}, of length {length:.9g}; expected a unit vector, to 1e-6"
        )
    if not (np.abs(p.rod_gain) <= ROD_GAIN_MAX).all():
        raise ValueError(f"rod_gain is {p.rod_gain.tolist()}; expected -{ROD_GAIN_MAX:g} to {ROD_GAIN_MAX:g}")
    if not (p.rod_period == 0.0 or p.rod_period >= ROD_PERIOD_MIN):
        raise ValueError(f"rod_period is {p.rod_period} s; expected 0 (always on) or at least {ROD_PERIOD_MIN:g} s")
    if not 0.0 <= p.rod_duty <= 1.0:
        raise ValueError(f"rod_duty is {p.rod_duty}; expected 0 to 1")
    if abs(p.h_w0) > p.wheel_momentum_max:
        raise ValueError(f"h_w0 is {p.h_w0} N.m.s; expected within wheel_momentum_max, {p.wheel_momentum_max} N.m.s")
    if p.integrator_order not in COMPOSITIONS:
        raise ValueError(
            f"integrator_order is {p.integrator_order}; expected one of {', '.join(map(str, COMPOSITIONS))}"
        )
    if p.initial_attitude == "Q0":
        deviation = np.abs(p.Q0.T @ p.Q0 - np.eye(3)).max()
        if deviation > 1e-3 or np.linalg.det(p.Q0) < 0.0:
            raise ValueError(
                f"Q0 is {p.Q0.tolist()}; expected a rotation: Q0^T Q0 is off the identity by {deviation:.2g} (at most 1e-3), "
                f"determinant {np.linalg.det(p.Q0):.4f}"
            )
    else:
        length = math.sqrt(p.q_NB0 @ p.q_NB0)
        if abs(length - 1.0) > 1e-3:
            raise ValueError(
                f"q_NB0 is {p.q_NB0.tolist()}, of length {length:.6g}; expected a unit quaternion, to 1e-3"
            )
    perigee = p.orbit.semi_major_axis * (1.0 - p.orbit.eccentricity)
    if perigee < LOWEST_PERIGEE:
        name = "orbit_radius" if p.orbit_start == "circular" else "r_N0, v_N0: the perigee"
        raise ValueError(
            f"{name} is {perigee:.1f} m; expected at least {LOWEST_PERIGEE:.1f} m, 100 km above the equator"
        )
    if p.drag:
        _check_heights(p)
    limit = tables.field_model(p.field_model).g.shape[1] - 1
    if not 1 <= p.field_degree <= limit:
        raise ValueError(f"field_degree is {p.field_degree}; expected 1 to {limit}")
    _ = p.field  # refuses a date that the model does not cover


def _check_drag(p: Parameters) -> None:
    for name, low, high, unit in _DRAG_RANGES:
        value = getattr(p, name)
        if not low <= value <= high:
            raise ValueError(f"{name} is {value}; expected {low:g} to {high:g}{unit}")
    if p.body_axis not in AXES:
        raise ValueError(f"body_axis is {p.body_axis!r}; expected one of {', '.join(AXES)}")
    size = np.array([p.body_length if axis == p.body_axis else p.body_width for axis in AXES])
    if not (np.abs(p.center_of_mass_B) <= 0.5 * size).all():
        raise ValueError(
            f"center_of_mass_B is {p.center_of_mass_B.tolist()} m from the geometric centre; expected inside the body, "
            f"within {(0.5 * size).tolist()} m"
        )


def _check_heights(p: Parameters) -> None:
    a, e = p.orbit.semi_major_axis, p.orbit.eccentricity
    lowest = a * (1.0 - e) - orbit.WGS84_RADIUS
    highest = a * (1.0 + e) - orbit.WGS84_RADIUS * (1.0 - orbit.WGS84_FLATTENING)
    for height, end in ((lowest, "lowest"), (highest, "highest")):
        if not atmosphere.LOWEST <= height <= atmosphere.HIGHEST:
            name = "orbit_radius" if p.orbit_start == "circular" else "r_N0, v_N0"
            raise ValueError(
                f"{name}: the orbit's {end} height above the ellipsoid can be {height / 1e3:.1f} km; expected "
                f"{atmosphere.LOWEST / 1e3:g} to {atmosphere.HIGHEST / 1e3:g} km, where the density is known, or drag false"
            )


def _check_inertia(name: str, J: Array) -> None:
    if np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
        raise ValueError(f"{name} is {J.tolist()} kg.m2; expected a symmetric matrix")
    moments = np.linalg.eigvalsh(J)
    if moments[0] <= 0.0:
        raise ValueError(
            f"{name} has the principal moments {moments.tolist()} kg.m2; expected a positive definite matrix"
        )
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise ValueError(
            f"{name} has the principal moments {moments.tolist()} kg.m2, which no body has: the largest exceeds the sum of the others"
        )
