"""Parameters of the plant and what follows from them alone; checks.py says which describe a satellite."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from . import atmosphere, geomagnetic, orbit, tables, time_scales
from .attitude import Body
from .drag import Drag, octagonal_cylinder
from .imbalance import Imbalances, imbalances
from .rods import Turns
from .so3 import Array, from_quaternion, project
from .solar_pressure import SolarPressure
from .sun import Sun
from .surroundings import Environment
from .wheel import Wheel

OfWheels = Any
"""A number for one wheel, an array (4,) for a set of them."""


@dataclass(frozen=True)
class Parameters:
    """Start values of the plant; units, frames and limits are those of fmus/interfaces/plant.toml."""

    J_B: Array
    J_error_B: Array
    wheel_inertia: OfWheels
    wheel_axis: Array
    wheel_momentum_max: OfWheels
    wheel_torque_max: OfWheels
    wheel_viscous_friction: OfWheels
    wheel_coulomb_friction: OfWheels
    dipole_max: float
    rod_limits: Array
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
    solar_pressure: bool
    solar_specular: float
    solar_diffuse: float
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
    h_w0: OfWheels
    integrator_order: int
    step_max: float
    wheels: int = 1
    """How many of the set are there. For one wheel, the fields of wheels are scalars and wheel_axis is (3,); for a set
    they are (4,) and (4, 3)."""
    wheel_gain: OfWheels = 1.0
    wheel_breakaway_friction: OfWheels = 0.0
    wheel_static_imbalance: OfWheels = 0.0
    wheel_dynamic_imbalance: OfWheels = 0.0
    wheel_position_B: OfWheels = 0.0

    @cached_property
    def body(self) -> Body:
        J = self.J_B + self.J_error_B
        return Body(J=J, J_inverse=np.asarray(np.linalg.inv(J), dtype=np.float64))

    @property
    def is_set(self) -> bool:
        """Returns whether the block is that for a set of wheels."""
        return self.wheel_axis.ndim == 2

    @cached_property
    def wheel_axes(self) -> Array:
        """(n,3): the unit axes of the wheels that are there."""
        axes = np.atleast_2d(self.wheel_axis)[: self.wheels]
        return axes / np.linalg.norm(axes, axis=1, keepdims=True)

    def of_wheels(self, value: Any) -> list[float]:
        """A parameter or an input of the wheels as a list with an element for each that is there."""
        listed: list[float] = np.atleast_1d(value).tolist()
        return listed[: self.wheels]

    @cached_property
    def wheel_list(self) -> list[Wheel]:
        """The wheels that are there."""
        of_each = (
            *(self.wheel_inertia, self.wheel_momentum_max, self.wheel_torque_max, self.wheel_viscous_friction),
            *(self.wheel_coulomb_friction, self.wheel_breakaway_friction, self.wheel_gain),
        )
        return [Wheel(*values) for values in zip(*map(self.of_wheels, of_each), strict=True)]

    @cached_property
    def imbalances(self) -> Imbalances | None:
        """Those of the wheels that are there; None where they are balanced, as the block's one wheel is."""
        if not self.is_set:
            return None
        inertia, product, moment = (
            np.array(self.of_wheels(np.broadcast_to(value, 4)))
            for value in (self.wheel_inertia, self.wheel_dynamic_imbalance, self.wheel_static_imbalance)
        )
        positions = np.broadcast_to(self.wheel_position_B, (4, 3))[: self.wheels]
        return imbalances(self.wheel_axes, inertia, product, moment, positions)

    @cached_property
    def rods_to_body(self) -> Array:
        """(3,3), columns u_i: takes the rods' dipoles to the body's."""
        return (self.rod_axes / np.linalg.norm(self.rod_axes, axis=1)[:, None]).T

    @cached_property
    def dipole_limit(self) -> Array:
        """(3,) A m2: the largest dipole of each rod."""
        return self.dipole_max * self.rod_limits

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
            return orbit.with_j2(path, mu) if self.j2_node_drift else path
        through = orbit.drifting if self.j2_node_drift else orbit.from_position_velocity
        return through(self.r_N0, self.v_N0, mu)

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
    def light(self) -> SolarPressure:
        plates = octagonal_cylinder(self.body_width, self.body_length, self.body_axis)
        return SolarPressure(plates, self.center_of_mass_B, self.solar_specular, self.solar_diffuse)

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
            self.sun,
            self.light if self.solar_pressure else None,
        )

    @cached_property
    def R_NB0(self) -> Array:
        """Attitude (3,3) at t = 0."""
        if self.initial_attitude == "q_NB0":
            return from_quaternion(self.q_NB0)
        return orbit.lvlh(*self.orbit.position_velocity(0.0)) @ project(self.Q0)
