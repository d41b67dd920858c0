"""Whether the sensors are good enough for what is expected.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from .finding import Finding
from .satellite import BLIND, Satellite

NOISY = 2.0
"""Largest change of a wheel's momentum by its noise from sample to sample, beside what the rods give in that time."""


def of_sensors(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of the noise beside the rods, and beside the attitude error that is expected."""
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
    if s.sensors.get("attitude_noise", 0.0) > 0.0 and s.sensors.get("attitude_rate_max", 1.0) > BLIND:
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
