"""Runs what docs/evidence/estimation.md shows, prints its tables and draws its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from orchestration import Result, run

from ..crew import crew
from ..paper import ROOT, Array
from ..plots import BLUE, GREEN, RED, name_axes, panels, save
from . import consistency, steady

SCENARIOS = {"flight_estimated": "magnetometer, sun sensors, gyro", "flight_star_tracker": "with a star tracker"}
HOLD = 2500.0
"""s; the errors of the hold are from then on."""


def make(runs: int, jobs: int, folder: Path = ROOT / "docs" / "figures") -> list[Table]:
    """The tables; the figures go to the folder."""
    with crew(jobs) as hands:
        flown = {
            tracker: hands.each(name, consistency.measured, [(i, tracker) for i in range(runs)])
            for tracker, name in ((False, "field, Sun, gyro"), (True, "with a star tracker"))
        }
    flights = {name: run(ROOT / "scenarios" / f"{name}.yaml") for name in SCENARIOS}
    drawn = {f"estimation-{name[7:].replace('_', '-')}": errors(result) for name, result in flights.items()}
    save({"estimation-consistency": consistent(flown), **drawn}, folder)
    return [*map(_consistency, flown.values(), flown), _starts(flown[False]), _steady(), _holds(flights)]


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title)
    for column in columns:
        table.add_column(column)
    return table


def _consistency(runs: list[dict[str, Array]], tracker: bool) -> Table:
    title = f"{len(runs)} runs, {'with' if tracker else 'without'} a star tracker"
    table = _table(title, "", "mean", "95% of a mean over the runs", "times within")
    for name, mean, low, high, share in consistency.summary(runs, tracker):
        table.add_row(name, f"{mean:.3f}", f"{low:.2f} to {high:.2f}", f"{share:.0%}")
    return table


def _starts(runs: list[dict[str, Array]]) -> Table:
    """Returns how far the attitude is off at times after the start, at the median and at worst."""
    table = _table("from any attitude", "s", "in light: median, worst, deg", "in eclipse: median, worst, deg")
    lit = np.array([r["sunlight"][0] >= 1.0 for r in runs])
    angles = np.degrees([r["angle"] for r in runs])
    for k, t in enumerate(runs[0]["time"]):
        if t in (10.0, 60.0, 120.0, 240.0, 300.0, 600.0, 900.0):
            cells = []
            for chosen in (angles[lit, k], angles[~lit, k]):
                waiting = int(np.isnan(chosen).sum())
                seen = f"{np.nanmedian(chosen):.2f}, {np.nanmax(chosen):.2f}" if waiting < len(chosen) else "-"
                cells.append(seen + (f" ({waiting} of {len(chosen)} wait)" if waiting else ""))
            table.add_row(f"{t:g}", *cells)
    return table


def _steady() -> Table:
    table = _table("steady state", "star tracker, gyro", "closed form, before and after, arcsec", "filter", "apart")
    for case in steady.CASES:
        form, found = steady.closed_form(*case), steady.of_filter(*case)
        apart = max(abs(b / a - 1.0) for a, b in zip(form, found, strict=True))
        cells = [", ".join(f"{np.degrees(x) * 3600.0:.3f}" for x in pair) for pair in (form, found)]
        table.add_row(", ".join(f"{x:g}" for x in case), *cells, f"{apart:.0e}")
    return table


def _holds(flights: dict[str, Result]) -> Table:
    table = _table("scenarios, from 2500 s on", "", "attitude rms, largest, deg", "estimate rms, largest, deg")
    for name, result in flights.items():
        held = result.time >= HOLD
        cells = []
        for judge in ("judge", "estimate_judge"):
            angle = np.degrees(result[f"{judge}.attitude_error"][held])
            cells.append(f"{np.sqrt(np.mean(angle**2)):.4f}, {angle.max():.4f}")
        table.add_row(SCENARIOS[name], *cells)
    return table


def errors(result: Result) -> Any:
    """Attitude error of the satellite and of the estimate with three deviations, over time; the eclipse shaded."""
    figure, axes = panels(2, 1, width=8.0, height=2.8, sharex=True)
    t = result.time / 60.0
    sigma = np.degrees(3.0 * np.linalg.norm(result["estimator.attitude_sigma_B"], axis=1))
    axes[0, 0].semilogy(t, np.degrees(result["judge.attitude_error"]), color=BLUE, label="satellite to LVLH")
    axes[1, 0].semilogy(
        t, np.degrees(result["estimate_judge.attitude_error"]), color=RED, label="estimate to the truth"
    )
    axes[1, 0].semilogy(t, sigma, color=GREEN, linewidth=1.0, label="three standard deviations, as estimated")
    for ax in axes[:, 0]:
        ax.fill_between(
            t,
            0.0,
            1.0,
            where=result["plant.sunlight"] < 0.5,
            color="0.85",
            transform=ax.get_xaxis_transform(),
            label="eclipse",
        )
        ax.legend(fontsize=8, loc="upper right")
    name_axes(axes[0, 0], "", "attitude error, deg")
    name_axes(axes[1, 0], "time, min", "attitude error, deg")
    return figure


def consistent(flown: dict[bool, list[dict[str, Array]]]) -> Any:
    """NEES and NIS over time, means over the runs, with their bounds."""
    figure, axes = panels(1, 2, width=4.6, height=3.0)
    for ax, (tracker, runs) in zip(axes[0], flown.items(), strict=True):
        t = runs[0]["time"]
        late = t >= consistency.FROM
        ax.plot(
            t[late], np.mean([r["nees"][late] for r in runs], axis=0), color=BLUE, label="NEES, 6 degrees of freedom"
        )
        nis = np.mean([r["nis"][late][:, 2 if tracker else 0] for r in runs], axis=0)
        ax.plot(t[late], nis, color=RED, label=f"NIS of the {'star tracker' if tracker else 'field'}, 3")
        for freedom in (6, 3):
            for bound in consistency.bounds(freedom, len(runs)):
                ax.axhline(bound, color="0.4", linewidth=0.8, linestyle="--")
        ax.set_ylim(0.0, 9.0)
        ax.legend(fontsize=8, loc="upper left")
        name_axes(
            ax, "time, s", "mean over the runs", f"{len(runs)} runs {'with' if tracker else 'without'} a star tracker"
        )
    return figure
