"""What the bank of filters costs where one filter does: tumbles of docs/evidence/estimation.md on the same draws, with
`bank` and without.

Tests: tests/evidence/estimator/test_bank.py."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table
from scipy.stats import binom

from orchestration.campaign.case import Case

from ..crew import case, crew
from ..paper import ROOT

CAMPAIGNS = {
    "estimated": ("magnetometer, sun sensors, gyro", "angle_5"),
    "estimated_star_tracker": ("with a star tracker", "angle_5"),
    "cubesat": ("3U CubeSat", "angle_15"),
}
"""Campaigns of scenarios/campaigns by their row of the page, and the time of settling that it has."""
COLUMNS = ("settled", "time", "hold", "estimate")


def campaign(name: str, bank: bool, runs: int) -> Case:
    """The first runs of a campaign, with the bank or without."""
    return case(
        {
            "extends": str(ROOT / "scenarios" / "campaigns" / f"{name}.yaml"),
            "name": f"{name}_{'bank' if bank else 'one'}",
            "scenario": {"blocks": {"estimator": {"start": {"bank": bank}}}},
            "runs": runs,
            "requirements": [],
            "keep": {},
        },
        ROOT,
    )


def table(runs: int, jobs: int) -> Table:
    """The rows of the page that fly the estimator, with one filter and with the bank."""
    found = Table(title=f"the same {runs} draws: median (95% of it), worst")
    for column in ("", "estimator", "settle", "after, s", "hold rms, deg", "estimate rms, deg", "hold, median change"):
        found.add_column(column)
    with crew(jobs) as hands:
        for name, (row, settled) in CAMPAIGNS.items():
            flown = [hands.fly(campaign(name, bank, runs), ROOT / "results" / "bank").numbers for bank in (False, True)]
            holds = [numbers("hold_rms") for numbers in flown]
            for what, numbers in zip(("one filter", "bank"), flown, strict=True):
                change = interval(holds[1] - holds[0]) if what == "bank" else ""
                found.add_row(row, what, *cells(numbers, settled), change)
    return found


def cells(numbers: Callable[[str], NDArray[np.float64]], settled: str) -> list[str]:
    """Returns how many settle, when, the hold, the estimate."""
    times = numbers(settled)
    there = np.isfinite(times)
    parts: list[Any] = [times[there], numbers("hold_rms"), numbers("estimate_rms")]
    return [f"{there.sum()} of {len(times)}", *(f"{interval(p)}, {p.max():.3g}" for p in parts)]


def interval(values: NDArray[np.float64]) -> str:
    """The median, and between which of the values in their order that of all draws lies with 95%."""
    order = np.sort(values)
    low = int(binom.ppf(0.025, len(order), 0.5))
    return (
        f"{np.median(order):.3g} ({order[max(low - 1, 0)]:.3g} to {order[min(len(order) - low, len(order) - 1)]:.3g})"
    )
