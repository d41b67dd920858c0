"""Whether rods and orbit fit the body.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from .finding import Finding, parts
from .satellite import Satellite

TURNS = (3.0, 1000.0)
"""s, in which rods turn the body by a radian: 16 for a 1U, 170 for 500 kg."""
SMALL, DIPOLES = 25.0, (0.5, 1.0)
"""kg of a small satellite; A m2 of a rod for each kg of it, and of a larger one: 0.03 to 0.15 of CubeSats, 0.75 of the
paper's."""
WEAK = 0.1
"""Of the strongest rod's dipole: below it a rod counts as none."""
APART = 10.0
"""deg, at least: between a rod and the plane of the two others."""
SHARE = 0.3
"""Of the rods' torque that disturbances may take: across the field is a part of all directions only."""


def of_rods(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of the rods beside the body, the control period, the disturbances and the orbit."""
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
            f"a rod gives {dipole:.3g} A.m2 in a body of {s.heavy:.3g} kg{', by its size and J_B' * (s.mass is None)}",
            f"at most {bound:g} A.m2 for each kg",
            f"check the units and the points of dipole_max and of {'J_B' if s.mass is None else 'the mass'}",
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
            f"a control_period of {0.2 * s.turned:.2g} s or less, in whole steps of estimator and control",
        )
    causes = s.disturbances()
    total = sum(causes.values())
    if total > SHARE * s.rods:
        yield Finding(
            f"disturbances are up to {total:.3g} N.m ({parts(causes)}), the rods give {s.rods:.3g} N.m in the weakest "
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


def _times(value: float, least: float, most: float) -> str:
    """A factor on a dipole, by whose root the time goes."""
    return f"{(value / most) ** 2:.2g} times" if value > most else f"{(least / value) ** 2:.2g} times"
