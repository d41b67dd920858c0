"""The tables of docs/evidence/estimation.md from docs/evidence/health.csv; page.md.j2 has the words.
Tests: tests/evidence/health/test_page.py."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .. import markdown
from ..markdown import degrees
from .kept import Flight
from .rows import ROWS, Row

HEAD = "what fails|lost|safe|named, median"
NOTHING = "nothing"
SENSORS = {"estimated": "coarse", "estimated_star_tracker": "star tracker", "cubesat": "3U"}
"""What the page calls the sensors of each campaign."""


def text(flights: Sequence[Flight]) -> str:
    """Returns the page."""
    of = {row.name: [f for f in flights if f.row == row.name] for row in ROWS}
    failing = [
        f for row in ROWS if (row.part or row.text.startswith("commands")) and not row.pair for f in of[row.name]
    ]
    parts = [f for row in ROWS if row.part and not row.pair for f in of[row.name]]
    pairs = [f for row in ROWS if row.pair for f in of[row.name]]
    every = [f for row in ROWS for f in of[row.name]]
    lost = [f for f in failing if f.outcome == "lost"]
    return markdown.render(
        Path(__file__).parent,
        rows=[
            _line(which, of)
            for which in dict.fromkeys(kind(row) for row in ROWS if of[row.name] and row.text != NOTHING)
        ],
        head=HEAD,
        flown=len(failing),
        lost=len(lost),
        largest=degrees(max((f.largest_deg for f in every if f.outcome == "held"), default=0.0)),
        spin=f"{max((f.spin_deg_s for f in every if f.outcome != 'held'), default=0.0):.2g}",
        pairs=len(pairs),
        pairs_lost=sum(f.outcome == "lost" for f in pairs),
        kinds=sum(bool(of[row.name]) for row in ROWS if row.text != NOTHING and not row.pair),
        kinds_lost=len({f.row for f in lost}),
        parts=len(parts),
        named=sum(np.isfinite(f.named_s) for f in parts),
        others=sum(bool(f.others) for f in failing),
        sound=len(sound := [f for row in ROWS if row.text == NOTHING for f in of[row.name]]),
        sound_lost=sum(f.outcome == "lost" for f in sound),
        blamed=sum(bool(f.others) for f in sound),
    )


def _line(which: str, of: dict[str, list[Flight]]) -> list[str]:
    rows = [row for row in ROWS if kind(row) == which]
    flights = [f for row in rows for f in of[row.name]]
    return [
        which,
        _lost([(row.campaign, f) for row in rows for f in of[row.name]]),
        str(sum(f.outcome == "safe" for f in flights)),
        _named(rows, flights) + (f"; another {others}" if (others := sum(bool(f.others) for f in flights)) else ""),
    ]


def kind(row: Row) -> str:
    """Returns what fails, whenever it does."""
    return row.text.removesuffix(", in the tumble").removesuffix(", in the hold")


def _lost(flights: Sequence[tuple[str, Flight]]) -> str:
    """Returns how many are lost, and on which sets of sensors."""
    lost = [campaign for campaign, f in flights if f.outcome == "lost"]
    where = ", ".join(f"{text} {lost.count(campaign)}" for campaign, text in SENSORS.items() if campaign in lost)
    return f"{len(lost)} of {len(flights)}" + (f": {where}" if where else "")


def _named(rows: Sequence[Row], flights: Sequence[Flight]) -> str:
    """In how many flights the part is named, and after how long at the median."""
    times = np.array([f.named_s for f in flights])
    if not rows[0].part or not len(times):
        return ""
    known = times[np.isfinite(times)]
    return markdown.finite(times) + (f", {np.median(known):.0f} s" if len(known) else "")
