"""Tables of docs/evidence/satellites.md on satellites without a wheel."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from ..markdown import degrees
from ..paper import Array
from .classes import ALL
from .kept import CONDITIONS, NAMES, STEEP, Flights, column


def _without_wheel(flights: Flights) -> Iterator[tuple[str, str, list[Mapping[str, str]]]]:
    """Satellite, condition and lines of each row without a wheel."""
    for name, kind in itertools.product((name for name in ALL if not ALL[name].has_wheel), CONDITIONS):
        yield name, kind, flights.of(name, kind)


def _below(largest: Array) -> list[str]:
    """How many of these errors, deg, are below 5 and 15 deg."""
    return [f"{(largest < limit).sum()} of {len(largest)}" for limit in (5.0, 15.0)]


def flown(flights: Flights) -> list[list[str]]:
    """What satellites without a wheel hold, settled or not."""
    rows = []
    for name, kind, lines in _without_wheel(flights):
        largest, rms = column(lines, "later_max_deg", math.inf), column(lines, "hold_rms_deg", math.inf)
        steep = column(lines, "inclination_deg") > STEEP
        rows.append(
            [
                name,
                NAMES[kind],
                f"{1e9 * ALL[name].disturbance(CONDITIONS[kind]):.2g}",
                *_below(largest),
                f"{(steep & (largest < 15.0)).sum()} of {steep.sum()}",
                degrees(float(np.median(rms[steep]))) if steep.any() else "–",
            ]
        )
    return rows
