"""Which parameters describe a satellite that the plant can fly. Tests: tests/plant/test_parameters.py."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np

from . import atmosphere, orbit, tables
from .attitude import COMPOSITIONS
from .drag import AXES
from .parameters import Parameters
from .so3 import Array

ROD_GAIN_MAX, ROD_LIMIT_MIN = 2.0, 0.01
WHEELS_MAX, WHEEL_GAIN_MAX = 4, 2.0
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
BODY_RANGES = (("body_width", 1e-3, 100.0, " m"), ("body_length", 1e-3, 100.0, " m"))
LIGHT_RANGES = (("solar_specular", 0.0, 1.0, ""), ("solar_diffuse", 0.0, 1.0, ""))
AIR_RANGES = (
    ("drag_factor", 0.0, 1e6, ""),
    ("drag_coefficient", 0.0, 10.0, ""),
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
        _check_ranges(p, AIR_RANGES)
    if p.drag or p.solar_pressure:
        _check_body(p)
    if p.solar_pressure:
        _check_ranges(p, LIGHT_RANGES)
        if p.solar_specular + p.solar_diffuse > 1.0:
            found = p.solar_specular + p.solar_diffuse
            raise ValueError(f"solar_specular + solar_diffuse: expected at most 1, found {found:g}")
    body = () if p.drag or p.solar_pressure else ("center_of_mass_B", *(name for name, *_ in BODY_RANGES))
    unused = (*body, *(() if p.drag else (name for name, *_ in AIR_RANGES)))
    for field in fields(p):
        value = getattr(p, field.name)
        if field.name not in unused and isinstance(value, float | np.ndarray) and not np.isfinite(value).all():
            found = value.tolist() if isinstance(value, np.ndarray) else value
            raise ValueError(f"{field.name}: expected finite numbers, found {found}")
    for name, least, unit in AT_LEAST:
        value = getattr(p, name)
        if np.any(value < least):
            found = value.tolist() if isinstance(value, np.ndarray) else value
            raise ValueError(f"{name}: expected at least {least:g} {unit}, found {found} {unit}")
    for name, choices in _CHOICES.items():
        if getattr(p, name) not in choices:
            raise ValueError(f"{name}: expected one of {', '.join(choices)}, found {getattr(p, name)!r}")
    _check_inertia("J_B", p.J_B)
    _check_inertia("J_B + J_error_B", p.J_B + p.J_error_B)
    lengths = np.linalg.norm(p.rod_axes, axis=1)
    if np.abs(lengths - 1.0).max() > 1e-6:
        raise ValueError(f"rod_axes: expected rows of unit length, to 1e-06, found rows of length {lengths.tolist()}")
    _check_wheels(p)
    if not ((p.rod_limits >= ROD_LIMIT_MIN) & (p.rod_limits <= 1.0)).all():
        raise ValueError(f"rod_limits: expected {ROD_LIMIT_MIN:g} to 1, found {p.rod_limits.tolist()}")
    if not (np.abs(p.rod_gain) <= ROD_GAIN_MAX).all():
        raise ValueError(f"rod_gain: expected -{ROD_GAIN_MAX:g} to {ROD_GAIN_MAX:g}, found {p.rod_gain.tolist()}")
    if not (p.rod_period == 0.0 or p.rod_period >= ROD_PERIOD_MIN):
        raise ValueError(f"rod_period: expected 0 (always on) or at least {ROD_PERIOD_MIN:g} s, found {p.rod_period} s")
    if not 0.0 <= p.rod_duty <= 1.0:
        raise ValueError(f"rod_duty: expected 0 to 1, found {p.rod_duty}")
    if p.integrator_order not in COMPOSITIONS:
        raise ValueError(
            f"integrator_order: expected one of {', '.join(map(str, COMPOSITIONS))}, found {p.integrator_order}"
        )
    if p.initial_attitude == "Q0":
        deviation = np.abs(p.Q0.T @ p.Q0 - np.eye(3)).max()
        if deviation > 1e-3 or np.linalg.det(p.Q0) < 0.0:
            raise ValueError(
                "Q0: expected a rotation matrix, max |Q0^T Q0 - I| at most 0.001 and determinant +1, "
                f"found {deviation:.2g} and {np.linalg.det(p.Q0):.4f}: {p.Q0.tolist()}"
            )
    else:
        length = math.sqrt(p.q_NB0 @ p.q_NB0)
        if abs(length - 1.0) > 1e-3:
            raise ValueError(
                f"q_NB0: expected a quaternion of unit length, to 0.001, found {length:.6g}: {p.q_NB0.tolist()}"
            )
    perigee = p.orbit.semi_major_axis * (1.0 - p.orbit.eccentricity)
    if perigee < LOWEST_PERIGEE:
        name = "orbit_radius" if p.orbit_start == "circular" else "r_N0, v_N0: the perigee"
        raise ValueError(
            f"{name}: expected at least {LOWEST_PERIGEE:.1f} m, 100 km above the equator, found {perigee:.1f} m"
        )
    if p.drag:
        _check_heights(p)
    limit = tables.field_model(p.field_model).g.shape[1] - 1
    if not 1 <= p.field_degree <= limit:
        raise ValueError(f"field_degree: expected 1 to {limit}, found {p.field_degree}")
    _ = p.field  # refuses a date that the model does not cover


def _check_wheels(p: Parameters) -> None:
    if not 0 <= p.wheels <= WHEELS_MAX:
        raise ValueError(f"wheels: expected 0 to {WHEELS_MAX}, found {p.wheels}")
    for i, axis in enumerate(np.atleast_2d(p.wheel_axis)[: p.wheels], start=1):
        of = f"[{i}]" if p.is_set else ""
        if abs((length := float(np.linalg.norm(axis))) - 1.0) > 1e-6:
            raise ValueError(
                f"wheel_axis{of}: expected a vector of unit length, to 1e-06, found {length:.9g}: {axis.tolist()}"
            )
        wheel, start = p.wheel_list[i - 1], p.of_wheels(p.h_w0)[i - 1]
        if abs(start) > wheel.momentum_max:
            raise ValueError(
                f"h_w0{of}: expected within wheel_momentum_max, {wheel.momentum_max} N.m.s, found {start} N.m.s"
            )
        if wheel.breakaway_friction < 0.0:
            raise ValueError(f"wheel_breakaway_friction{of}: expected at least 0 N.m, found {wheel.breakaway_friction}")
        if not abs(wheel.gain) <= WHEEL_GAIN_MAX:
            raise ValueError(f"wheel_gain{of}: expected -{WHEEL_GAIN_MAX:g} to {WHEEL_GAIN_MAX:g}, found {wheel.gain}")
        product, moment = (
            np.broadcast_to(value, WHEELS_MAX)[i - 1] for value in (p.wheel_dynamic_imbalance, p.wheel_static_imbalance)
        )
        if not moment >= 0.0:
            raise ValueError(f"wheel_static_imbalance{of}: expected at least 0 kg.m, found {moment} kg.m")
        if not 0.0 <= product <= wheel.inertia:
            raise ValueError(
                f"wheel_dynamic_imbalance{of}: expected 0 to wheel_inertia, {wheel.inertia} kg.m2, "
                f"found {product} kg.m2"
            )


def _check_ranges(p: Parameters, ranges: tuple[tuple[str, float, float, str], ...]) -> None:
    for name, low, high, unit in ranges:
        value = getattr(p, name)
        if not low <= value <= high:
            raise ValueError(f"{name}: expected {low:g} to {high:g}{unit}, found {value}")


def _check_body(p: Parameters) -> None:
    _check_ranges(p, BODY_RANGES)
    if p.body_axis not in AXES:
        raise ValueError(f"body_axis: expected one of {', '.join(AXES)}, found {p.body_axis!r}")
    size = np.array([p.body_length if axis == p.body_axis else p.body_width for axis in AXES])
    if not (np.abs(p.center_of_mass_B) <= 0.5 * size).all():
        raise ValueError(
            f"center_of_mass_B: expected inside the body, within {(0.5 * size).tolist()} m of its geometric centre, "
            f"found {p.center_of_mass_B.tolist()} m"
        )


def _check_heights(p: Parameters) -> None:
    a, e = p.orbit.semi_major_axis, p.orbit.eccentricity
    lowest = a * (1.0 - e) - orbit.WGS84_RADIUS
    highest = a * (1.0 + e) - orbit.WGS84_RADIUS * (1.0 - orbit.WGS84_FLATTENING)
    for height, end in ((lowest, "lowest"), (highest, "highest")):
        if not atmosphere.LOWEST <= height <= atmosphere.HIGHEST:
            name = "orbit_radius" if p.orbit_start == "circular" else "r_N0, v_N0"
            raise ValueError(
                f"{name}: expected heights above the ellipsoid of {atmosphere.LOWEST / 1e3:g} to "
                f"{atmosphere.HIGHEST / 1e3:g} km, "
                f"where the density is known, or drag false, found {height / 1e3:.1f} km, the {end} of the orbit"
            )


def _check_inertia(name: str, J: Array) -> None:
    if np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
        raise ValueError(f"{name}: expected a symmetric matrix, found {J.tolist()} kg.m2")
    moments = np.linalg.eigvalsh(J)
    if moments[0] <= 0.0:
        raise ValueError(
            f"{name}: expected a positive definite matrix, found principal moments {moments.tolist()} kg.m2"
        )
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise ValueError(
            f"{name}: expected the inertia of a body, each principal moment at most the sum of the other two, "
            f"found principal moments {moments.tolist()} kg.m2"
        )
