"""Searches how close to the target tumbles of docs/evidence/flight.md can stay (evidence/hold.py)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from ..crew import in_parts
from ..hold import least
from .bound import loop, starts
from .cases import EARLY, LONG, RATE
from .closest import SOUGHT, Closest, load, save
from .groups import all_groups
from .schemes import Data


def make(jobs: int, file: Path) -> Iterator[str]:
    """Searches what the file does not have of SOUGHT, and tells of each part when it has been saved."""
    found = load(file)
    known = {(one.group, one.run) for one in found}
    groups = [group for group in all_groups(1000) if group.name in SOUGHT]
    wanted = [(group.name, run, data) for group in groups for run, data in enumerate(starts(group))]
    left = [one for one in wanted if one[:2] not in known]
    yield from in_parts(jobs, "holds", _of_tumble, left, found, partial(save, file))


def _of_tumble(tumble: tuple[str, int, Data]) -> Closest:
    group, run, data = tumble
    return Closest(group, run, math.degrees(least(loop(data).plant, EARLY, LONG, RATE)))
