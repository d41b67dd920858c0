"""Small motions about LVLH under gravity gradient: their frequencies in closed form."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from tests.authorities.registry import authority
from tests.plant.motion import checked, command, fly

STABLE = (3.04, 3.09, 2.13)
"""Moments about X along the velocity, Y along the negative orbit normal, Z to nadir: stable."""
PAPER = (2.13, 3.04, 3.09)
MU, RADIUS = 3.986004418e14, 6971e3
RATE = math.sqrt(MU / RADIUS**3)
HUGHES = "Hughes, Spacecraft Attitude Dynamics, 9.1; Wie, Space Vehicle Dynamics and Control, 6.5"


def lvlh_from_definition(r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Columns X, Y, Z in N, by Gram and Schmidt."""
    z = -r / np.linalg.norm(r)
    x = v - (v @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def small_angles(moments, roll, pitch, yaw, pitch_rate=0.0, orbits=3.0, step=20.0) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and roll, pitch, yaw, rad, from a start at rest in LVLH (but for the pitch rate), order 6."""
    E = np.eye(3) + np.array([[0.0, -yaw, pitch], [yaw, 0.0, -roll], [-pitch, roll, 0.0]])
    omega = E.T @ [0.0, -RATE, 0.0] + [0.0, pitch_rate, 0.0]
    p = checked(J_B=np.diag(moments), Q0=E, omega_B0=omega, integrator_order=6, step_max=step)
    n = round(orbits * 2.0 * math.pi / RATE / step)
    angles = []
    for i, x in enumerate(fly(p, command(), step, n)):
        E = lvlh_from_definition(*p.orbit.position_velocity(i * step)).T @ x.R
        angles.append([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
    return step * np.arange(n + 1), 0.5 * np.array(angles)


def _frequencies(samples: np.ndarray, interval: float, count: int) -> list[float]:
    """Frequencies, rad/s, of a sum of `count` (1 or 2) cosines, by Prony's method on symmetric differences."""
    x = samples
    if count == 1:
        middle = x[1:-1]
        return [math.acos(0.5 * float((x[2:] + x[:-2]) @ middle / (middle @ middle))) / interval]
    columns = np.column_stack([x[3:-1] + x[1:-3], x[2:-2]])
    (a, b), *_ = np.linalg.lstsq(columns, x[4:] + x[:-4], rcond=None)
    # a = 2 (c1 + c2), b = -(2 + 4 c1 c2)
    cosines = np.roots([1.0, -0.5 * a, -(b + 2.0) / 4.0])
    return sorted(math.acos(c) / interval for c in cosines.real)


def pitch_closed_form(moments) -> float:
    """omega^2/n^2 in pitch: 3 (Jx - Jz)/Jy."""
    Jx, Jy, Jz = moments
    return 3.0 * (Jx - Jz) / Jy


def roll_yaw_closed_form(moments) -> list[float]:
    """omega/n: roots of s^4 + (1 + 3 k1 + k1 k3) s^2 + 4 k1 k3, k1 = (Jy - Jz)/Jx, k3 = (Jy - Jx)/Jz."""
    Jx, Jy, Jz = moments
    k1, k3 = (Jy - Jz) / Jx, (Jy - Jx) / Jz
    return sorted(math.sqrt(-s) for s in np.roots([1.0, 1.0 + 3.0 * k1 + k1 * k3, 4.0 * k1 * k3]).real)


@authority(
    "Gravity gradient",
    "Libration frequency in pitch, diag(3.04, 3.09, 2.13), over n",
    source=HUGHES,
    expected=math.sqrt(pitch_closed_form(STABLE)),
    tolerance=1e-6,
)
@cache
def pitch_frequency() -> float:
    _, angles = small_angles(STABLE, 0.0, 1e-5, 0.0)
    return _frequencies(angles[::15, 1], 300.0, 1)[0] / RATE


@cache
def _roll_yaw() -> list[float]:
    _, angles = small_angles(STABLE, 2e-5, 0.0, 1e-5, orbits=12.0)
    return [w / RATE for w in _frequencies(angles[::30, 0], 600.0, 2)]


@authority(
    "Gravity gradient",
    "Slow libration frequency in roll and yaw, same body, over n",
    source=HUGHES,
    expected=roll_yaw_closed_form(STABLE)[0],
    tolerance=1e-5,
)
def slow_roll_yaw_frequency() -> float:
    return _roll_yaw()[0]


@authority(
    "Gravity gradient",
    "Fast libration frequency in roll and yaw, same body, over n",
    source=HUGHES,
    expected=roll_yaw_closed_form(STABLE)[1],
    tolerance=1e-6,
)
def fast_roll_yaw_frequency() -> float:
    return _roll_yaw()[1]


@authority(
    "Gravity gradient",
    "Growth rate in pitch of the paper's diag(2.13, 3.04, 3.09), unstable in LVLH: its square over n^2",
    source=HUGHES,
    expected=-pitch_closed_form(PAPER),
    tolerance=1e-6,
)
@cache
def paper_growth() -> float:
    growth = math.sqrt(-pitch_closed_form(PAPER)) * RATE
    times, angles = small_angles(PAPER, 0.0, 1e-7, 0.0, pitch_rate=1e-7 * growth, orbits=1.0, step=5.0)
    found = math.log(angles[-1, 1] / angles[0, 1]) / times[-1]
    return (found / RATE) ** 2


@authority(
    "Gravity gradient",
    "Relative equilibrium: largest angle from LVLH over three orbits of the stable body",
    source="symmetry: a principal body at rest in LVLH stays there",
    unit="rad",
    tolerance=3e-11,
)
@cache
def relative_equilibrium() -> float:
    _, angles = small_angles(STABLE, 0.0, 0.0, 0.0)
    return float(np.abs(angles).max())
