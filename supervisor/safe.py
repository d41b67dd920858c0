"""Where the mode safe points, by directions that are measured in body axes: no attitude is needed.

Requirement: SV-3.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .ports import Inputs, Parameters, State, require
from .so3 import Array, exp, norm

FIELD_TIME = 50.0
"""s, of the filter that gives the field's rate."""
SLOW = 0.3
"""rad in safe_time, below which the satellite turns slowly enough to begin pointing."""
OPPOSITE = 1e-9
"""Sine of the angle below which opposite directions have no axis between them."""


def pointed(x: State, u: Inputs, p: Parameters, h: float) -> State:
    """With `towards`, the rate that is asked for at x.t, h after the last; zeros where there is nothing to point at.

    Raises ValueError where the direction that safe_pointing needs is not connected.
    """
    turns = _may_turn(x, u, p)
    axis, to, rate = p.safe_axis_B, np.zeros(3), np.zeros(3)
    if p.safe_pointing == "field":
        require("b_B", u.b_B, "safe_pointing is 'field'")
        x = _following(x, u, h)
        to, rate = x.field_direction, x.field_rate
    elif p.safe_pointing == "sun":
        require("sun_B", u.sun_B, "safe_pointing is 'sun'")
        axis, to = p.sun_axis_B, u.sun_B / (norm(u.sun_B) or 1.0)
    if not (turns and to.any()):
        return replace(x, towards=np.zeros(3))
    rate_max = min(p.slew_rate_max, 0.5 * p.rate_acquire)  # a faster turn would end the pointing
    return replace(x, towards=rate_towards(axis, to, p.safe_time, rate_max) + rate)


def _may_turn(x: State, u: Inputs, p: Parameters) -> bool:
    """Returns whether it turns at all: the rates are damped first.

    Rods do not damp a spin about the field, so an axis that points along it would keep its spin, and a fast one upsets
    the pointing.
    """
    slow = x.calm >= p.rate_time and norm(u.omega_B) * p.safe_time < SLOW
    return slow or (x.calm > 0.0 and bool(x.towards.any()))


def rate_towards(axis_B: Array, to_B: Array, time: float, rate_max: float) -> Array:
    """The rate (3,) that turns a body axis to a unit vector, both in body axes: the angle over `time`, at
    most rate_max."""
    about = np.cross(axis_B, to_B)
    s, c = norm(about), float(axis_B @ to_B)
    angle = math.atan2(s, c)
    if s < OPPOSITE:
        if angle < 1.0:
            return about / time
        a, b, d = np.abs(axis_B).tolist()
        about = np.cross(axis_B, np.eye(3)[0 if a <= b and a <= d else 1])
    return np.asarray(min(angle / time, rate_max) / norm(about) * about, np.float64)


def _following(x: State, u: Inputs, h: float) -> State:
    """With the direction of the field and its rate relative to N.

    Both are turned by the measured rate, so that the filter sees the slow motion of the field alone:
    field <- exp((1 - e^2) m^) field, rate <- rate + (1 - e)^2/h m, m the turn that was missed, e = exp(-h/FIELD_TIME).
    """
    field, rate, size = x.field_direction, x.field_rate, norm(u.b_B)
    if field.any():
        turned = exp(-h * u.omega_B)
        rate = turned @ rate
        field = exp(h * rate) @ (turned @ field)
    elif size > 0.0:
        field = u.b_B / size
    if size > 0.0 and h > 0.0:
        left = math.exp(-h / FIELD_TIME)
        miss = np.cross(field, u.b_B) / size
        rate = rate + (1.0 - left) ** 2 / h * miss
        field = exp((1.0 - left * left) * miss) @ field
        field = field / norm(field)
        rate = rate - float(rate @ field) * field
    return replace(x, field_direction=field, field_rate=rate)
