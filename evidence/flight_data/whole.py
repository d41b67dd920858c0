"""The study of the records of a folder: all that docs/evidence/flight_data.md shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inflight.attitude import Attitudes
from inflight.magnetometer import Calibration, calibrate, symmetric
from inflight.orbit import borders
from inflight.records import Flight
from orchestration import InputError

from ..crew import crew
from . import spins
from .flown import through_the_estimator
from .parts import CUTS, TRIED, cut, known, likelihood
from .records import records
from .study import LONG, NOISE, Free, Shown, free_motion, long_record

KNOWN = 30
"""Spins with known answers."""


@dataclass(frozen=True)
class Study:
    """All that the page shows."""

    shown: list[Shown]
    flown: list[Attitudes | None]
    """By the shipped estimator in C, with what the calibrations wrote; None without rows at whole seconds"""
    free: Free | None
    cuts: list[Shown]
    """Parts of each record, calibrated by themselves"""
    likelihoods: list[list[float]]
    """By record, those of its field with each of TRIED"""
    known: list[list[tuple[float, float]]]
    """Spins with known answers, with rates as measured and by parabolas"""
    spins: dict[str, list[spins.Case]]
    """By what flew them"""


def study(folder: Path, cases: int, jobs: int, split: bool) -> Study:
    """Runs it; `cases` are synthetic spins, `split` asks for parts of the records, too. Raises InputError."""
    flown, short = records(folder, LONG)
    if not flown and not short:
        raise InputError(f"--data {folder}: expected records with rates and field, found none")
    own = [calibrate(f.t, f.m, np.linalg.norm(f.orbit.field_N(), axis=1), breaks=borders(f.orbit)) for f in flown]
    with crew(jobs) as hands:
        shown = hands.each("records", _long_record, [(flown, own, i) for i in range(len(flown))])
        parts = hands.each("parts of them", cut, [(flight, name) for flight in flown for name in CUTS] if split else [])
        tried = [(flight, s, name) for flight, s in zip(flown, shown, strict=True) for name in TRIED] if split else []
        likely = hands.each("likelihoods", likelihood, tried)
        answers = hands.each("known answers", known, range(KNOWN) if split else [])
    through = [through_the_estimator(s.flight, symmetric(s.calibration), NOISE) for s in shown]
    likelihoods = [likely[i : i + len(TRIED)] for i in range(0, len(likely), len(TRIED))]
    synthetic = spun(cases, jobs) if cases else {}
    return Study(shown, through, free_motion(short), parts, likelihoods, answers, synthetic)


def _long_record(item: tuple[list[Flight], list[Calibration], int]) -> Shown:
    flown, own, i = item
    others = [k for k in range(len(flown)) if k != i]
    return long_record(flown[i], [own[k] for k in others], [flown[k].name for k in others])


def spun(cases: int, jobs: int) -> dict[str, list[spins.Case]]:
    """The synthetic spins, by what flew them."""
    done: dict[str, list[spins.Case]] = {}
    with crew(jobs) as hands:
        for faces, name in zip((0, 3, 6), spins.KINDS, strict=True):
            both = hands.each(name, spins.case, [(number, faces) for number in range(cases)])
            if not faces:
                done["one filter, field and gyro"] = [one for one, _ in both]
            done[f"bank, {name}"] = [bank for _, bank in both]
    return done
