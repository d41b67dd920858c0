"""What follows from a satellite's data sheet: inertia of a mass and size, axes of a set of wheels, period, notes.

Tests: tests/design/test_new_satellite.py.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestration import InputError
from orchestration.quantities import QuantityError, parse_unit, value_in
from orchestration.scenario.forms import matrix

from .lasting import RADIAN
from .template import Template, flow

MU, EARTH_RADIUS = 3.986004418e14, 6378137.0
"""m3/s2 and m (WGS 84)."""
FIELD = 4.4e-5
"""T: a mean of the Earth's field at 500 km, by which notes give torques."""
HELD = 0.9
"""Of a wheel's limit: within it a hold is expected to keep the momentum, which no wheel brings beyond its limit."""
FULL = 200.0 * math.pi
"""rad/s of a full wheel, 6000 rpm, where its inertia is not given."""
TOLD = math.pi / 30.0
"""rad/s: the error of a wheel's speed that is told, 1 rpm, where it is not given: docs/use/sensors.md#wheels."""
ERROR, RESIDUAL, DUTY = 0.05, 0.01, 0.8
"""Assumed where not given: error of the inertia, residual dipole over that of the rods; part in which rods are on."""
KNOWN = {
    "cubesat": ("0.2 deg", "1e-4 rad/s", "15 deg"),
    "star tracker": ("0.01 deg", "3e-5 rad/s", "1 deg"),
    "perfect": ("0.01 deg", "1e-5 rad/s", "1 deg"),
}
"""Errors of attitude and rate of an estimate on each set of sensors, as a controller is told; a goal for the hold."""
OWN = KNOWN["cubesat"]
NO_WHEEL = ("1e-9 N.m", "1e-9 N.m.s")
SET = 4
"""Places of a set of wheels."""


def wheel_axes(text: str) -> list[list[float]] | None:
    """Returns the unit axes of a preset's wheels; None of one wheel and of none, whose axis is a value.

    "three axes" are x, y and z; "pyramid 35 deg" are four wheels about z, that angle from the plane of x and y, between
    the body's axes; "[[1, 0, 0], ...]" are the axes of three or four, of any length. Raises InputError.
    """
    if text.startswith("["):
        return _unit_axes(text)
    if text in ("none", "one"):
        return None
    if text == "three axes":
        return np.eye(3).tolist()
    if match := re.fullmatch(r"pyramid(?: (.+))?", text):
        try:
            angle = value_in(match[1] or "35.26438968 deg", parse_unit("rad"))
        except QuantityError as error:
            raise InputError(f"--set wheels: {error}") from None
        if not 0.0 < angle < math.pi / 2:
            raise InputError(f"--set wheels: expected an angle of 0 to 90 deg, such as pyramid 35 deg, found {text}")
        turns = math.pi / 4 + math.pi / 2 * np.arange(SET)
        flat, up = math.cos(angle), math.sin(angle)
        return [[flat * math.cos(turn), flat * math.sin(turn), up] for turn in turns.tolist()]
    raise InputError(f"--set wheels: expected none, one, three axes, pyramid 35 deg or a list of axes, found {text!r}")


def _unit_axes(text: str) -> list[list[float]]:
    try:
        axes = np.array(json.loads(text), np.float64)
    except (ValueError, TypeError):
        axes = np.zeros((0, 0))
    fits = axes.ndim == 2 and axes.shape[1] == 3 and 3 <= len(axes) <= SET and bool(np.isfinite(axes).all())
    if not fits or np.linalg.matrix_rank(axes) < 3 or not np.linalg.norm(axes, axis=1).all():
        raise InputError(f"--set wheels: expected three or four axes of three numbers that span space, found {text}")
    return (axes / np.linalg.norm(axes, axis=1, keepdims=True)).tolist()


def box(mass: float, width: float, length: float, axis: str, depth: float | None = None) -> list[float]:
    """Returns the principal moments (3,), kg m2, of a homogeneous box, its length along x, y or z.

    The width lies along the first of the two other axes, the depth, if it is another, along the second.
    """
    across = iter((width, width if depth is None else depth))
    squares = [(length if name == axis else next(across)) ** 2 for name in "xyz"]
    return [mass / 12.0 * (sum(squares) - square) for square in squares]


def _length(dipole: Any) -> float:
    """Returns the length of a dipole as it is given, A m2; 0 of one that is none, which the block refuses by name."""
    try:
        return math.hypot(*(value_in(each, parse_unit("A.m2")) for each in dipole))
    except (QuantityError, TypeError, ValueError):
        return 0.0


def _matrix(value: Any) -> Any:
    """Returns the inertia (3,3), kg m2, of what is given; None where the blocks will refuse it."""
    try:
        rows = matrix(value) if isinstance(value, dict) else value
        return np.array([[value_in(each, parse_unit("kg.m2")) for each in row] for row in rows]).reshape(3, 3)
    except (QuantityError, TypeError, ValueError):
        return None


def prefixed(value: float, unit: str) -> str:
    """Returns a value to three figures with a prefix of its unit."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    power = min(max(3 * math.floor(math.log10(abs(value)) / 3), -9), 3)
    return f"{value / 10.0**power:.3g} { {-9: 'n', -6: 'u', -3: 'm', 0: '', 3: 'k'}[power] }{unit}"


def followed(found: Template, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Returns all values by name, with those that follow, and the texts of notes. Raises InputError."""
    values = {name: entry.get("default") for name, entry in found.values.items()} | dict(given)
    number = {n: found.number(n, v) for n, v in values.items() if v is not None and "unit" in found.values[n]}
    notes: dict[str, str] = {}

    if isinstance(moments := given.get("inertia"), list) and len(moments) == 3 and not isinstance(moments[0], list):
        values["inertia"] = {"diagonal": moments}
    if "inertia" not in given:
        sizes = number["body_width"], number["body_length"], str(values["body_axis"]), number.get("body_depth")
        moments = box(number["mass"], *sizes)
        values["inertia"] = {"diagonal": [float(f"{m:.6g}") for m in moments]}
        notes["inertia"] = f"of a homogeneous body of {values['mass']} and this size; wheels locked"
    else:
        notes["inertia"] = "with the wheels locked" + (f"; mass {values['mass']}" if "mass" in given else "")
    stated = f"data: {{mass: {flow(values['mass'])}}}" if "mass" in given else "# data: {mass: 4 kg}"
    notes["mass"] = f"{stated}          # only compared with J_B" + ("" if "mass" in given else "; state it")
    if values["center_of_mass_B"] is None:
        values["center_of_mass_B"] = [f"{each * min(1.0, number['body_width'] / 0.1):.3g} mm" for each in (20, 20, 10)]
    deep = f"       # assumed on all sides, though it is {values['body_depth']} deep: drag and sunlight act more"
    notes["depth"] = deep if "body_depth" in given else ""
    notes |= {n: "" if n in given else "assumed: " for n in ("center_of_mass_B", "f107", "disturbance_torque_B")}
    J = _matrix(values["inertia"])
    if values["J_error_B"] is None:
        off = ERROR * J if J is not None else np.zeros((3, 3))
        values["J_error_B"] = [[float(f"{x:.4g}") for x in row] for row in off.tolist()]
        notes["J_error_B"] = "assumed to be a twentieth of it"
    else:
        notes["J_error_B"] = "as given"

    dipole = number["dipole_max"]
    torque = dipole * FIELD
    if J is not None and torque > 0.0 and np.trace(J) > 0.0:
        turned = math.sqrt(np.trace(J) / 3.0 / torque)
        notes["dipole_max"] = (
            f"{prefixed(torque, 'N.m')} in a field of 44 uT, which turn the body by a radian in {turned:.3g} s"
        )
    else:
        notes["dipole_max"] = f"{prefixed(torque, 'N.m')} in a field of 44 uT"
    if values["residual_dipole_B"] is None:
        each = RESIDUAL * dipole
        values["residual_dipole_B"] = [f"{sign * each:.3g} A.m2" for sign in (1, -1, 1)]
        largest = math.sqrt(3.0) * each * FIELD
        notes["residual_dipole_B"] = f"assumed, a hundredth of the rods': up to {prefixed(largest, 'N.m')}; measure it"
    else:
        notes["residual_dipole_B"] = "as given"
    unknown = max(_length(values["residual_dipole_B"]), math.sqrt(3.0) * RESIDUAL * dipole) * FIELD
    # where the estimator has no gyro, it is told of a torque over a radian of the orbit as a random walk
    notes["momentum_random_walk"] = f"{math.sqrt(RADIAN) * unknown:.3g} N.m.s"
    notes["dipole_mean"] = f"{DUTY * dipole:.6g} A.m2"

    if values["wheel_axis"] == [0, 0, 0]:
        raise InputError("--set wheel_axis: expected a direction, found [0, 0, 0]")
    kind = str(values["wheels"])
    axes = wheel_axes(kind)
    notes["momentum_expected"], notes["wheel_fault"] = "# no wheel, and nothing expected of it", "# no wheel to fail"
    if kind != "none":
        within = f"{HELD * number['wheel_momentum_max']:.4g} N.m.s"
        notes["momentum_expected"] = (
            f"- {{name: wheel momentum within {HELD:g} of its limit from 1.5 orbits, signal: plant.h_w, "
            f"after: 1.5 orbits, always: {{within: {within}}}}}"
        )
        notes["wheel_fault"] = "- {name: wheel stuck, cut: plant.wheel_torque_cmd, at: 1 orbits}"
    if kind == "none":
        values["wheel_torque_max"], values["wheel_momentum_max"] = NO_WHEEL
        values["wheel_inertia"] = values["wheel_inertia"] or "1e-06 kg.m2"
        notes |= {"wheels": "no wheel: next to nothing, as the controller takes it"}
        notes |= {"wheel_torque_max": "none", "wheel_momentum_max": "none", "wheel_momentum_noise": "0 N.m.s"}
        notes["wheel_inertia"] = "none"
        notes["wheel_telemetry"] = "no wheel"
    else:
        momentum, motor = number["wheel_momentum_max"], number["wheel_torque_max"]
        notes["wheel_inertia"] = "as given" if values["wheel_inertia"] else "assumed: full at 6000 rpm"
        values["wheel_inertia"] = values["wheel_inertia"] or f"{momentum / FULL:.3g} kg.m2"
        notes["wheels"] = "one wheel"
        notes["wheel_torque_max"] = f"full in {momentum / motor:.3g} s" if motor > 0.0 else "the motor gives nothing"
        held = f"{math.degrees(momentum / np.diag(J).max()):.3g} deg/s of the body" if J is not None else "of a wheel"
        emptied = f"; the rods take it away in {momentum / torque:.3g} s" if torque > 0.0 else ""
        notes["wheel_momentum_max"] = held + emptied
        told = TOLD * found.number("wheel_inertia", values["wheel_inertia"])
        notes["wheel_momentum_noise"] = f"{told:.3g} N.m.s"
        notes["wheel_telemetry"] = f"assumed: {'its' if axes is None else 'each'} speed to 1 rpm, times its inertia"
    values["wheel_count"] = 1
    if axes is not None:
        values["wheel_count"] = len(axes)
        values["wheel_axis"] = [[float(f"{x:.10g}") for x in a] for a in [*axes, *axes[: SET - len(axes)]]]
        for name in ("wheel_torque_max", "wheel_momentum_max", "wheel_inertia"):
            values[name] = SET * [values[name]]
        notes["wheels"] = f"{kind}: the first {len(axes)} of {SET} places"
    notes["plant"] = "plant" if axes is None else "plant_wheels"

    by_radius = "orbit_radius" in given
    radius = number["orbit_radius"] if by_radius else EARTH_RADIUS + number["altitude"]
    if values["period"] is None:
        values["period"] = f"{2.0 * math.pi * math.sqrt(radius**3 / MU):.7g} s"
    name = "orbit_radius" if by_radius else "altitude"
    notes["orbit"] = f"{name}: {values[name]}"
    notes["period"] = f"a circular orbit of {values['period']}"

    sensors = str(values["sensors"])
    attitude, rate, goal = KNOWN.get(sensors, OWN)
    values["attitude_noise"] = values["attitude_noise"] or attitude
    values["rate_noise"] = values["rate_noise"] or rate
    values["goal"] = values["goal"] or goal
    on = {"perfect": "PERFECT sensors, which no satellite has", "cubesat": "the sensors of a CubeSat"}
    law = f"planned controller{'' if axes is None else ' of wheels'}, bounded allocator"
    measured = on.get(sensors, f"sensors: {sensors}".replace('"', "'"))
    notes["description"] = f"A tumble to LVLH hold on {measured}, the estimator in the loop: {law}"
    return values, notes
