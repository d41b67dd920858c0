"""A plant's magnetic field by itself: that of IGRF-14 at its place, its attitude and the epoch that it is told.

Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fmus.field import EarthField

from ...fmu.model import Floats
from ..polarity.wrongs import signed_permutations
from ..robustness import Trial
from .motion import level
from .signals import SMALL, Explanation, Signals, along, apart, best, factors, rms, transposed

NAME = "its field is the Earth's"
_INSTANTS = 16
_ALLOWED = 0.05
"""Other models of the Earth's field differ by less."""
_TOLD = 3e-3
"""Above this an explanation that leaves a fifth is told, though the field is the Earth's."""


def field(of: Signals, turning: bool, falling: bool) -> Trial:
    """Returns whether the field is the model's. `turning`, `falling`: whether attitude and orbit are right."""
    if why := of.lacks("b_B", "R_NB", "r_N"):
        return Trial(NAME, "", why)
    try:
        earth = EarthField(str(of.told.get("epoch", "")))
    except ValueError as error:
        return Trial(NAME, "", str(error))
    rows = np.unique(np.linspace(0, len(of.time) - 1, _INSTANTS).astype(int))
    time, R, r, b = of.time[rows], of.values["R_NB"][rows], of.values["r_N"][rows], of.values["b_B"][rows]
    if not 6.4e6 < float(np.linalg.norm(r, axis=1).mean()) < 1e9:
        return Trial(NAME, "", "r_N is not the length of an orbit in m")
    model = earth.at(time, r)
    B = along(transposed(R), model)
    left = apart(b, B)
    if left <= _TOLD:
        return Trial(NAME, "met", f"within {100 * left:.2g} % of IGRF-14")
    if not falling and left > _ALLOWED:
        return Trial(NAME, "", "its orbit is not right")
    words = "" if not turning else best(_explanations(of, rows, earth, model)) or _dated(time, R, r, b, earth)
    if left <= _ALLOWED:
        more = f"; nearer: {words}" if words and _leaves(words) < 20 * left else ""
        return Trial(NAME, "met", f"within {100 * left:.2g} % of IGRF-14{more}")
    if not turning:
        sizes = apart(np.linalg.norm(b, axis=1), np.linalg.norm(model, axis=1))
        status = "" if sizes <= _ALLOWED else "failed"
        return Trial(NAME, status, f"its size is within {100 * sizes:.2g} % of IGRF-14; its attitude is not right")
    symptom = f"it differs by {100 * left:.2g} %, its size is {rms(b):.3g} T, that of IGRF-14 {rms(model):.3g} T"
    return Trial(NAME, "failed", words or f"{symptom}; no usual unit, frame or date explains it")


def _leaves(words: str) -> float:
    return float(words.rpartition("(leaves ")[2].partition(" %")[0])


def _explanations(of: Signals, rows: Floats, earth: EarthField, model: Floats) -> Iterator[Explanation]:
    R, r, b, time = of.values["R_NB"][rows], of.values["r_N"][rows], of.values["b_B"][rows], of.time[rows]
    B = along(transposed(R), model)
    yield from factors(
        {"b_B is in nT": 1e-9, "b_B is in uT": 1e-6, "b_B is in gauss": 1e-4, "b_B is in mG": 1e-7}, B, b
    )
    yield "b_B is along N", model, b
    yield "b_B is turned by R_NB the wrong way round", along(R, model), b
    axes = earth.axes(time)
    yield "b_B is along the axes of the Earth", model, along(axes, b)
    if "v_N" in of.values:
        yield "b_B is along LVLH", model, along(level(r, of.values["v_N"][rows]), b)
    up = r / np.linalg.norm(r, axis=1, keepdims=True)
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    north = np.cross(up, east)
    for name, frame in (("north, east, down", (north, east, -up)), ("east, north, up", (east, north, up))):
        yield f"b_B is along {name}", model, along(np.stack(frame, axis=2), b)
    for words, matrix in signed_permutations()[1:]:
        yield f"b_B has other axes or signs: {words}", B, b @ np.asarray(matrix).T
    dipole = earth.at(time, r, degree=1)
    yield "b_B is that of a dipole, the first degree of the model", along(transposed(R), dipole), b


def _dated(time: Floats, R: Floats, r: Floats, b: Floats, earth: EarthField) -> str:
    """Returns how far the Earth is turned from where the epoch has it, and the year of the model; empty where neither
    explains the field."""
    B = along(R, b)

    def left(turned: float, year: float) -> float:
        return apart(earth.at(time, r, turned, year), B)

    degrees, year = 0.0, earth.year
    for step in (6.0, 1.0, 0.1):
        reach = 180.0 if step == 6.0 else 8 * step
        tried = np.arange(degrees - reach, degrees + reach, step)
        degrees = float(min(tried, key=lambda d: left(math.radians(d), year)))
    turned = math.remainder(math.radians(degrees), 2 * math.pi)
    years = [year, *np.arange(1900.0, 2031.0, 5.0)]
    nearest = min(years, key=lambda one: left(turned, one))
    rest = left(turned, nearest)
    if rest > SMALL or rest > 0.2 * left(0.0, year):
        return ""
    degrees = math.degrees(turned)
    if abs(math.remainder(turned - earth.zero_longitude, 2 * math.pi)) < math.radians(1.0):
        where = "the axes of the Earth are taken as those of N at t = 0"
    else:
        hours, days = degrees / 15.041, degrees / 0.9856
        where = f"the Earth is turned by {degrees:+.3g} deg against the epoch told: {hours:+.3g} h or {days:+.3g} days"
    date = "" if nearest == year or left(turned, year) < 2 * rest else f", and its model is of {nearest:.0f}"
    return f"{where}{date} (leaves {100 * rest:.2g} %)"
