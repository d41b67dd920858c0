"""Finds which tumbles of docs/evidence/satellites.md no controller can keep settled, by evidence/hold_bound.py."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np

from ..crew import in_parts
from ..flight.bound import loop, starts
from ..flight.cases import LOST
from ..flight.schemes import Data
from ..hold_bound import missing
from .classes import ALL, DURATION, EARLY, tumbles
from .kept import CONDITIONS, Flights, not_settled
from .searched import Missing, load_bounds, save_bounds


def make(jobs: int, flights: Flights, file: Path) -> Iterator[str]:
    """Finds what the file does not have of those that are not settled, and tells of each part when it is saved."""
    wanted = set(not_settled(flights))
    found = [bound for bound in load_bounds(file) if bound.tumble in wanted]
    yield from in_parts(jobs, "bounds of holds", _of_tumble, _left(flights, found), found, partial(save_bounds, file))


def _left(flights: Flights, found: list[Missing]) -> list[tuple[str, str, int, Data]]:
    known = {bound.tumble for bound in found}
    left = [tumble for tumble in not_settled(flights) if tumble not in known]
    wanted = []
    for (name, condition), those in groupby(left, lambda tumble: tumble[:2]):
        runs = [int(run) for *_, run in those]
        data = starts(tumbles(name, max(runs) + 1, CONDITIONS[condition]))
        wanted += [(name, condition, run, data[run]) for run in runs]
    return wanted


def _of_tumble(tumble: tuple[str, str, int, Data]) -> Missing:
    name, condition, run, data = tumble
    p = loop(data).plant
    torque = missing(p, EARLY, DURATION, math.radians(LOST), ALL[name].slow)
    return Missing(name, condition, run, torque / float(np.linalg.norm(p.disturbance_torque_B)))
