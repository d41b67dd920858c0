"""The orbit: propagated, and measured where what is measured is an orbit. Tests: tests/estimator/test_health.py.

Requirement: ES-4.
"""

from __future__ import annotations

from dataclasses import replace

from . import onboard
from .health import ORBIT, noticed
from .parameters import Parameters
from .so3 import Array, norm
from .state import Estimate

Orbit = tuple[Array, Array]
"""Position (3,), m, and velocity (3,), m/s."""
POSITION_OFF, VELOCITY_OFF = 1000.0, 10.0
"""m and m/s that a receiver is off at most."""
J2_LEFT = 0.02
"""m/s2; what an orbit of two bodies lacks."""
FIXES = 20.0
"""Measurements of one orbit that take the place of the propagated one."""


def with_orbit(x: Estimate, measured: Orbit | None, p: Parameters, h: float) -> Estimate:
    """The orbit h s later, with what is measured then."""
    r_N, v_N, since = x.r_N, x.v_N, x.since_orbit + h
    if x.oriented and h > 0.0:
        r_N, v_N = onboard.orbit_after(r_N, v_N, h, p.gravitational_parameter, p.j2)
    x = replace(x, r_N=r_N, v_N=v_N, since_orbit=since, since_fix=x.since_fix + h)
    if measured is None:
        return x
    x = _checked(x, measured, p)
    if not x.watch[ORBIT].trusted:
        return x
    share = since / (p.orbit_time + since) if x.oriented and p.orbit_time > 0.0 else 1.0
    r_N = (1.0 - share) * r_N + share * measured[0]
    v_N = (1.0 - share) * v_N + share * measured[1]
    return replace(x, r_N=r_N, v_N=v_N, since_orbit=0.0, oriented=True)


def _checked(x: Estimate, measured: Orbit, p: Parameters) -> Estimate:
    """Trusts a measured orbit that is the propagated one, and measured ones in turn that are of one orbit."""
    w = noticed(x.watch[ORBIT], measured[0], every=True)
    usable, oriented, fixes = not x.oriented or _same((x.r_N, x.v_N), measured, x.since_orbit), x.oriented, 0.0
    if not usable:
        last = onboard.orbit_after(x.fix_r_N, x.fix_v_N, x.since_fix, p.gravitational_parameter, p.j2)
        fixes = x.fixes + 1.0 if _same(last, measured, x.since_fix) else 0.0
        usable = fixes >= FIXES and not w.frozen
        oriented = not usable  # the propagated one counts no more
    x = x.watched(ORBIT, replace(w, suspect=not usable))
    return replace(x, oriented=oriented, fixes=fixes, fix_r_N=measured[0], fix_v_N=measured[1], since_fix=0.0)


def _same(known: Orbit, measured: Orbit, t: float) -> bool:
    """Returns whether an orbit is another one, known for t s: to what receivers err by, and orbits of two bodies."""
    r, v = (norm(a - b) for a, b in zip(known, measured, strict=True))
    return r < POSITION_OFF + 0.5 * J2_LEFT * t * t and v < VELOCITY_OFF + J2_LEFT * t
