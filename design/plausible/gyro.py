"""What is left without a gyro where nothing but the field is measured: in eclipse, without a star tracker.

The magnetometer leaves the turn about the field open until the field has turned in inertial space by about a radian.
Meanwhile a torque tau that nobody knows turns the body by tau T^2/(2 J) at most: a polar orbit has T = 1/(2 n). A
residual dipole gives none about the field of the moment, and less: docs/how/health.md has flights.
Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from plant.sun import seen_from

from ..lasting import RADIAN
from .finding import Finding, parts
from .satellite import Satellite

SAMPLES = 96
"""Of an orbit: a minute each."""


def of_no_gyro(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of a satellite whose estimator has no gyro, or loses it by a fault of the scenario."""
    if s.without_gyro and (found := lost(s)):
        yield found


def lost(s: Satellite) -> Finding | None:
    """Returns what is found where the gyro is lost; nothing with a star tracker, in sunlight, or within the goal."""
    if s.goal is None or s.measures_attitude or not (dark := eclipse(s)):
        return None
    acting = s.lasting() | {"what the estimator is told": s.torque_told}
    known = max(sum(s.lasting().values()), s.torque_told)
    if (drift := open_turn(s, known)) <= s.goal:
        return None
    allowed = known * s.goal / drift
    angle = f"{math.degrees(drift):.0f} deg" if drift < math.pi else "half a turn and more"
    return Finding(
        f"without its gyro, and in an eclipse of {dark / 60.0:.0f} min, the field alone is measured: a torque of up to "
        f"{known:.2g} N.m ({parts(acting)}) can turn the body about it by {angle} before the field has turned",
        f"at most {math.degrees(s.goal):.3g} deg, the error that is expected",
        f"a second gyro or a star tracker; or torques below {allowed:.1g} N.m, such as by a trimmed residual dipole, "
        f"and then estimator.momentum_random_walk of {allowed * math.sqrt(RADIAN):.1g} N.m.s",
    )


def open_turn(s: Satellite, torque: float) -> float:
    """Returns the angle, rad, by which a torque, N m, turns the body while the field turns by a radian."""
    return 0.5 * torque / (float(np.trace(s.p.J_B)) / 3.0) * turned_in(s) ** 2


def turned_in(s: Satellite) -> float:
    """Returns the time, s, in which the field's direction in inertial axes turns by a radian, as an orbit's mean."""
    times = np.linspace(0.0, s.period, SAMPLES)
    b = np.array([s.p.field.exact(float(t)) for t in times])
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    turned = np.arccos(np.clip(np.einsum("ni,ni->n", b[1:], b[:-1]), -1.0, 1.0)).sum()
    return s.period / float(turned)


def eclipse(s: Satellite) -> float:
    """Returns how long an orbit lies in the Earth's shadow, s."""
    times = np.linspace(0.0, s.period, SAMPLES)
    light = [seen_from(s.p.orbit.position_velocity(t)[0], s.p.sun.at(t))[1] for t in times.tolist()]
    return s.period * float(np.mean(np.array(light) < 0.5))
