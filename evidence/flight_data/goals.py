"""The goals of docs/evidence/flight_data.md against what a study found, in text.

Tests: tests/evidence/flight_data/test_study.py."""

from __future__ import annotations

from collections.abc import Sequence

from inflight.attitude import Attitudes

from .study import Free, Shown, pair, silent, sky

SKY = 4.0
"""deg rms of the withheld Sun sensors"""


def goals(shown: Sequence[Shown], flown: Sequence[Attitudes | None], free: Free | None) -> list[str]:
    """Each goal with the figure that is the farthest from it, of all records and of both estimators."""
    seen = [(s.attitude, s.sky, s.pair) for s in shown]
    seen += [(a, sky(s.flight, a)[0], pair(s.flight, a)) for s, a in zip(shown, flown, strict=True) if a is not None]
    errors = [x.rms for found, *both in seen if found.trusted for x in both if x is not None]
    measured: list[tuple[str, float, list[float]]] = [
        ("|B|, uT rms", 0.75, [1e6 * s.calibration.rms for s in shown]),
        ("withheld sun sensors, deg rms", SKY, errors),
        ("eclipse less the air's part, s", 2.0, [abs(edge.late_air) for s in shown for edge in s.edges]),
        ("forecast of free motion over the noise", 1.1, [] if free is None else [free.whole("forecast") / free.noise]),
        ("false convergences not reported", 0.0, [float(sum(silent(*each) for each in seen))] if seen else []),
    ]
    return [f"goal: {what}: {_met(limit, found)}" for what, limit, found in measured]


def _met(limit: float, found: list[float]) -> str:
    if not found:
        return "these records do not show it"
    return f"{max(found):.3g}, at most {limit:g}: {'met' if max(found) <= limit else 'NOT MET'}"
