"""Which parameters describe a satellite that the plant can fly."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np

from . import atmosphere, orbit, tables
from .attitude import COMPOSITIONS
from .drag import AXES
from .parameters import Parameters
from .so3 import Array

ROD_GAIN_MAX = 2.0
ROD_PERIOD_MIN = 1e-3
"""s."""

LOWEST_PERIGEE = orbit.WGS84_RADIUS + 100e3
"""m; below it the orbit is no orbit."""

AT_LEAST = (
    ("wheel_inertia", 1e-12, "kg.m2"),
    ("wheel_momentum_max", 0.0, "N.m.s"),
    ("wheel_torque_max", 0.0, "N.m"),
    ("wheel_viscous_friction", 0.0, "N.m.s/rad"),
    ("wheel_coulomb_friction", 0.0, "N.m"),
    ("dipole_max", 0.0, "A.m2"),
    ("gravitational_parameter", 1e14, "m3/s2"),
    ("step_max", 1e-6, "s"),
)
DRAG_RANGES = (
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


def check(p: Parameters) -> None:
    """Raises ValueError with name, value and what is expected, where the parameters describe no satellite."""
    if p.drag:
        _check_drag(p)
    unused = () if p.drag else ("center_of_mass_B", *(name for name, *_ in DRAG_RANGES))
    for field in fields(p):
        value = getattr(p, field.name)
        if field.name not in unused and isinstance(value, float | np.ndarray) and not np.isfinite(value).all():
            found = value.tolist() if isinstance(value, np.ndarray) else value
            raise ValueError(f"{field.name} is {found}; expected finite numbers")
    for name, least, unit in AT_LEAST:
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
    for name, low, high, unit in DRAG_RANGES:
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
