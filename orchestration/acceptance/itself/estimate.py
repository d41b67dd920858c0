"""An estimator by itself: its attitude turns at its rate, explains the field that is measured, and errs as it states.

Only the second half of the run counts, and of it where the attitude is said to be valid.
Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fmus.field import EarthField

from ...fmu.model import Floats
from ..robustness import Trial
from .motion import turns
from .signals import Explanation, Signals, along, apart, axes_and_angles, between, judged, rms, transposed

Bools = NDArray[np.bool_]
NAMES = (
    "its attitude turns at its rate",
    "its attitude explains the field that is measured (innovation)",
    "its attitude errs as it states (truth)",
)
_RATE, _INNOVATION, _WITHIN = 0.25, 0.1, 0.9
"""Shares: of the rate that corrections may make, of the field that may be left, of instants within three deviations."""
_INSTANTS = 60


def estimate(of: Signals, truth: Signals) -> Iterator[Trial]:
    """Yields what an estimator keeps. `truth` has R_NB and `epoch` of the plant, at the same instants."""
    if why := of.lacks("R_NB"):
        yield from (Trial(name, "", why) for name in NAMES)
        return
    R = of.values["R_NB"]
    good: Bools = np.abs(np.linalg.det(R) - 1.0) < 1e-2
    if "attitude_valid" in of.values:
        good = good & (of.values["attitude_valid"] != 0.0)
    good[: len(good) // 2] = False
    if good.sum() < _INSTANTS:
        yield from (Trial(name, "", "it has no valid attitude in the second half of the run") for name in NAMES)
        return
    yield _turning(of, R, good)
    yield _innovation(of, R, good, truth)
    yield _errors(of, R, good, truth)


def _turning(of: Signals, R: Floats, good: Bools) -> Trial:
    if why := of.lacks("omega_B"):
        return Trial(NAMES[0], "", why)
    both = good[1:] & good[:-1]
    turned, given = turns(R, of.time)[both], between(of.values["omega_B"])[both]
    if max(rms(turned), rms(given)) < 2e-4:
        return Trial(NAMES[0], "", "it hardly turns in this run")

    def explanations() -> Iterator[Explanation]:
        yield "R_NB is from N to B (transposed)", turns(transposed(R), of.time)[both], given
        yield "omega_B is along N", turned, between(along(transposed(R), of.values["omega_B"]))[both]
        yield "omega_B is in deg/s", turned, given * np.pi / 180
        yield "omega_B has the opposite sign", turned, -given

    mean = turned.mean(axis=0) - given.mean(axis=0)
    symptom = f"its attitude turns on average by {np.linalg.norm(mean):.2g} rad/s more or less than its rate says"
    return judged(NAMES[0], apart(turned, given), explanations(), symptom, _RATE)


def _innovation(of: Signals, R: Floats, good: Bools, truth: Signals) -> Trial:
    place = "r_N" if "r_N" in of.values else "r_N_measured"
    if why := of.lacks("b_B_measured", place):
        return Trial(NAMES[1], "", why)
    usable = np.flatnonzero(good & (np.abs(of.values["b_B_measured"]).max(axis=1) > 0.0))
    if len(usable) < _INSTANTS:
        return Trial(NAMES[1], "", "there are too few measurements of the field")
    rows = usable[np.linspace(0, len(usable) - 1, _INSTANTS).astype(int)]
    try:
        field = EarthField(str(truth.told.get("epoch", ""))).at(of.time[rows], of.values[place][rows])
    except ValueError as error:
        return Trial(NAMES[1], "", str(error))
    R, b = R[rows], of.values["b_B_measured"][rows]

    def explanations() -> Iterator[Explanation]:
        yield "R_NB is from N to B (transposed)", along(R, field), b

    left = apart(along(transposed(R), field), b)
    symptom = f"{100 * left:.2g} % of the measured field are not that of IGRF-14 at its attitude"
    return judged(NAMES[1], left, explanations(), symptom, _INNOVATION)


def _errors(of: Signals, R: Floats, good: Bools, truth: Signals) -> Trial:
    if "R_NB" not in truth.values:
        return Trial(NAMES[2], "", "the loop has no true attitude")
    off = transposed(R[good]) @ truth.values["R_NB"][good]
    angles, size = axes_and_angles(off)
    text = f"its error is {np.degrees(np.sqrt((size**2).mean())):.3g} deg rms, {np.degrees(size.max()):.3g} at most"
    if "attitude_bound" in of.values:
        bound = of.values["attitude_bound"][good]
        inside = float((size <= bound).mean())
        text += f"; within the bound that it states at {100 * inside:.3g} % of instants"
    elif "attitude_sigma_B" in of.values:
        inside = float((np.abs(angles) <= 3.0 * of.values["attitude_sigma_B"][good]).all(axis=1).mean())
        text += f"; within three deviations that it states at {100 * inside:.3g} % of instants"
    else:
        return Trial(NAMES[2], "", f"{text}; it states no deviation")
    return Trial(NAMES[2], "met" if inside >= _WITHIN else "failed", text)
