"""Whether wheels fit the body and its rods, and whether it can do without.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from plant.so3 import Array

from .finding import Finding, parts, unit_meant
from .satellite import Satellite

SPIN_UP, HOLDS = (1.0, 2000.0), (0.05, 60.0)
"""s in which a motor fills its wheel; deg/s of the body that a full wheel holds."""
DISC = 0.1
"""Of the mass: a disc as wide as the body, beyond whose inertia a wheel is none that fits."""
SPEEDS = (500.0, 50_000.0)
"""rpm of a full wheel."""
NONE = 1e-8
"""N m s below which a wheel is none."""
WHEEL = "@"
"""Stands for the name of a wheel."""


def of_wheels(s: Satellite) -> Iterator[Finding]:
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
    period, gathered = s.period, s.lasting()
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
            f"check wheel_inertia ({unit_meant(wheel.inertia, 1e-4 * fits, fits)}), which follows from "
            "wheel_momentum_max where it is not stated",
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


def of_no_wheel(s: Satellite) -> Iterator[Finding]:
    """Rods give no torque along the field: while it turns, gravity or the body's inertia has to bear what acts there.

    docs/evidence/satellites.md: of 100 tumbles with a sixth of the bound and drag 61 stay below 15 deg, with 1.6
    times it 2.
    """
    if s.goal is None or any(wheel.momentum_max >= NONE for wheel in s.p.wheel_list):
        return
    acting = s.lasting()
    bound = 2.0 * float(np.trace(s.p.J_B)) / 3.0 * s.p.gravitational_parameter / s.p.orbit.semi_major_axis**3
    if (total := sum(acting.values())) > bound:
        yield Finding(
            f"there is no wheel, and disturbances are up to {total:.2g} N.m ({parts(acting)})",
            f"at most {bound:.2g} N.m, twice the mean moment of inertia times the square of the orbit's rate",
            f"rods alone seldom stay within {math.degrees(s.goal):.3g} deg: a wheel, a smaller residual dipole or a "
            "higher orbit",
        )
