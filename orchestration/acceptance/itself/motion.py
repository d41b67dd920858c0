"""A plant's motion by itself: its attitude turns at its rate, its position moves at its velocity and falls as gravity
has it.

Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...fmu.model import Floats
from ..polarity.frames import EARTH_RATE
from ..polarity.wrongs import signed_permutations
from ..robustness import Trial
from .signals import (
    Explanation,
    Signals,
    along,
    apart,
    axes_and_angles,
    between,
    factors,
    judged,
    rate,
    rms,
    transposed,
)

MU = 3.986004418e14
"""m3/s2, WGS 84."""
RADIUS, J2 = 6378137.0, 1.08263e-3
EARTH = np.array([0.0, 0.0, EARTH_RATE])
"""rad/s"""
_DEGREE, _RPM = np.pi / 180, np.pi / 30
NAMES = (
    "its attitude is a rotation",
    "its attitude turns at its rate",
    "its position moves at its velocity",
    "its acceleration is gravity's",
    "its orbit keeps its energy",
)


def turns(R: Floats, time: Floats) -> Floats:
    """Returns log(R_before^T R)/h, the mean body rates (n - 1, 3) between attitudes (n, 3, 3)."""
    axis, angle = axes_and_angles(np.einsum("nji,njk->nik", R[:-1], R[1:]))
    sine = np.linalg.norm(axis, axis=1)
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)
    return axis * (scale / np.diff(time))[:, None]


def level(r: Floats, v: Floats) -> Floats:
    """Returns the matrices (n, 3, 3) from LVLH to N: x along the flight, z down."""
    down = -r / np.linalg.norm(r, axis=1, keepdims=True)
    across = np.cross(v, r)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([np.cross(across, down), across, down], axis=2)


def motion(of: Signals) -> Iterator[Trial]:
    """Yields what the motion of a plant keeps; empty statuses where it does not give what is read."""
    yield (_skipped(NAMES[0], why) if (why := of.lacks("R_NB")) else _rotation(of))
    yield (_skipped(NAMES[1], why) if (why := of.lacks("R_NB", "omega_B")) else _turning(of))
    if why := of.lacks("r_N", "v_N"):
        yield from (_skipped(name, why) for name in NAMES[2:])
        return
    moving = _moving(of)
    yield moving
    if moving.status != "met":
        yield from (_skipped(name, "its velocity is not that of its position") for name in NAMES[3:])
        return
    falling = _falling(of)
    yield falling
    yield _energy(of) if falling.status == "met" else _skipped(NAMES[4], "its acceleration is not gravity's")


def _skipped(name: str, why: str) -> Trial:
    return Trial(name, "", why)


def _rotation(of: Signals) -> Trial:
    R = of.values["R_NB"]
    off = float(np.abs(R @ transposed(R) - np.eye(3)).max())
    mirrored = bool((np.linalg.det(R) < 0.0).any())
    text = "R_NB is a mirror: its determinant is -1" if mirrored else f"R_NB R_NB^T is I to {off:.2g}"
    return Trial(NAMES[0], "failed" if mirrored or off > 1e-3 else "met", text)


def _turning(of: Signals) -> Trial:
    R, given, time = of.values["R_NB"], between(of.values["omega_B"]), of.time
    turned = turns(R, time)
    if rms(turned) < 1e-7 and rms(given) < 1e-7:
        return _skipped(NAMES[1], "it does not turn in this run")

    def explanations() -> Iterator[Explanation]:
        units = {"omega_B is in deg/s": _DEGREE, "omega_B is in rpm": _RPM}
        yield from factors(units, turned, given)
        yield "R_NB is from N to B (transposed)", turns(transposed(R), time), given
        yield "omega_B is along N", turned, between(along(transposed(R), of.values["omega_B"]))
        if not of.lacks("r_N", "v_N"):
            r, v = of.values["r_N"], of.values["v_N"]
            orbit = np.cross(r, v) / (r * r).sum(axis=1, keepdims=True)
            yield "omega_B is relative to LVLH", turned, given + between(along(transposed(R), orbit))
        for words, matrix in signed_permutations()[1:]:
            yield f"omega_B has other axes or signs: {words}", turned, given @ np.asarray(matrix).T

    symptom = f"it turns at {rms(turned):.3g} rad/s rms, its rate says {rms(given):.3g}"
    return judged(NAMES[1], apart(turned, given), explanations(), symptom)


def _moving(of: Signals) -> Trial:
    r, v, given = of.values["r_N"], rate(of.values["r_N"], of.time), between(of.values["v_N"])

    def explanations() -> Iterator[Explanation]:
        yield from factors({"v_N is in km/s, r_N in m": 1e3, "v_N is in m/s, r_N in km": 1e-3}, v, given)
        yield "v_N is relative to the turning Earth", v, given + between(np.cross(EARTH, r))
        yield "v_N is along LVLH", v, between(along(level(r, np.gradient(r, of.time, axis=0)), of.values["v_N"]))
        if "R_NB" in of.values:
            yield "v_N is along the body's axes", v, between(along(of.values["R_NB"], of.values["v_N"]))
        for words, matrix in signed_permutations()[1:]:
            yield f"v_N has other axes or signs: {words}", v, given @ np.asarray(matrix).T

    return judged(NAMES[2], apart(v, given), explanations(), f"it moves at {rms(v):.6g} m/s, v_N says {rms(given):.6g}")


def gravity(r: Floats) -> Floats:
    """Returns the acceleration (n, 3), m/s2, at places (n, 3), m, J2 included."""
    size = np.linalg.norm(r, axis=1, keepdims=True)
    up = 5.0 * (r[:, 2:] / size) ** 2
    oblate = 1.5 * J2 * (RADIUS / size) ** 2 * (np.array([1.0, 1.0, 3.0]) - up)
    return np.asarray(-MU * r / size**3 * (1.0 + oblate))


def _falling(of: Signals) -> Trial:
    r, v = between(of.values["r_N"]), between(of.values["v_N"])
    a = rate(of.values["v_N"], of.time)

    def explanations() -> Iterator[Explanation]:
        yield "r_N is in km, v_N in km/s", 1e3 * a, gravity(1e3 * r)
        carried = 2.0 * np.cross(EARTH, v) + np.cross(EARTH, np.cross(EARTH, r))
        yield "r_N and v_N are along the turning axes of the Earth", a + carried, gravity(r)
        yield "r_N and v_N have the opposite sign of time", -a, gravity(r)

    return judged(
        NAMES[3],
        apart(a, gravity(r)),
        explanations(),
        f"it accelerates at {rms(a):.4g} m/s2, gravity at r_N is {rms(gravity(r)):.4g}",
        allowed=5e-3,
    )


def _energy(of: Signals) -> Trial:
    r, v = of.values["r_N"], of.values["v_N"]
    size = np.linalg.norm(r, axis=1)
    plain = 0.5 * (v * v).sum(axis=1) - MU / size
    oblate = plain + MU * J2 * RADIUS**2 / (2.0 * size**3) * (3.0 * (r[:, 2] / size) ** 2 - 1.0)
    left = min(float(np.ptp(energy) / np.abs(energy).mean()) for energy in (plain, oblate))
    text = f"it changes by {100 * left:.2g} % in {of.time[-1]:.6g} s"
    return Trial(NAMES[4], "met" if left < 2e-4 else "failed", text)
