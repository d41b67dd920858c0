"""The tumbles of a review: a campaign, whose own page and replay stand behind what is shown here.

Longer than 250 lines: what is flown, and what is told of it.
Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import controller
from orchestration.campaign import engine
from orchestration.campaign.case import Case, read_campaign
from orchestration.campaign.flying.rows import Rows
from orchestration.errors import writing
from orchestration.results.whole import put
from orchestration.scenario.text import written
from plant.so3 import Array

from ..lasting import LASTING
from ..loop import parameters
from ..momentum import MomentumBalance
from . import studies
from .content import Curves, Section, Table, number
from .facts import Facts
from .options import DRAWN, Asked, Options

ORBITS = 2.0
"""Duration of a tumble; the second half is looked at as the hold."""
RATE = "0.1 deg/s"
"""Of a body that tumbles no more."""
BOUNDED = 5
"""Tumbles whose least time by the balance of momentum is computed."""
LEVELS = (15, 5, 2, 1)
"""deg"""
MORE = 1.25
"""Of the time in which the last one settles: what the figure shows."""
_CODE = '''"""Errors of pointing, written by orchestrate review."""

from {package}.budget import rotation_vectors, sizes, to_lvlh

R_D0 = {R_d0}


def _size(time, signals, index):
    R = signals["{plant}.R_NB"].reshape(-1, 3, 3)
    Q = to_lvlh(R, signals["{plant}.r_N"], signals["{plant}.v_N"], R_D0)
    error = rotation_vectors(Q[len(Q) // 2 :])
    return float(sizes(error, time[1] - time[0], {window!r}, {drift!r})[index].max())
'''


def campaign(facts: Facts, options: Options, folder: Path) -> dict[str, Any]:
    """Returns the entries of the campaign's file."""
    judge, plant = facts.blocks["plant_judge"], facts.plant
    half = f"{0.5 * ORBITS * facts.period:.6g} s"
    error = {"signal": f"{judge}.attitude_error", "unit": "deg"}
    metrics: list[dict[str, Any]] = [
        {
            "name": "settling_time",
            "signal": error["signal"],
            "settles": {"below": f"{math.degrees(facts.goal):.6g} deg"},
        },
        {"name": "detumbling_time", "signal": f"{judge}.rate_error_B", "measure": "norm", "settles": {"below": RATE}},
        {"name": "wheel_momentum", "signal": f"{plant}.h_w", "statistic": "peak"},
        {"name": "absolute_error", **error, "statistic": "maximum", "after": half},
        {"name": "rms_error", **error, "statistic": "rms", "after": half},
        *(
            {"name": f"within_{level}_deg", "signal": error["signal"], "settles": {"below": f"{level} deg"}}
            for level in LEVELS
        ),
    ]
    if "estimate_judge" in facts.blocks:
        signal = f"{facts.blocks['estimate_judge']}.attitude_error"
        metrics.append(
            {"name": "knowledge_error", "signal": signal, "unit": "deg", "statistic": "maximum", "after": half}
        )
    signals = [f"{plant}.{name}" for name in ("R_NB", "r_N", "v_N")]
    metrics += [
        {"name": f"{name}_error", "python": f"pointing:{name}_error", "signals": signals, "unit": "rad"}
        for name, lasts in (("mean", 1.0), ("relative", 1.0), ("drift", 2.0 + options.drift / options.window))
        if lasts * options.window <= 0.5 * ORBITS * facts.period  # else it has no value
    ]
    return {
        "name": DRAWN,
        "description": "Tumbles from any attitude at the file's rate, under the errors that the file states",
        "scenario": {
            "extends": os.path.relpath(facts.file.resolve(), folder.resolve()),
            "duration": f"{ORBITS * facts.period:.6g} s",
            "expect": [],
            "figures": [],
        },
        "runs": options.runs,
        "seed": options.seed,
        "vary": studies.drawn(facts, True),
        "metrics": metrics,
    }


def prepared(facts: Facts, options: Options, folder: Path) -> Case:
    """Writes the campaign's files and returns it. Raises InputError."""
    file = folder / "tumbles.yaml"
    lines = [_CODE.format(package=__package__, R_d0=facts.R_d0.tolist(), plant=facts.plant,
                          window=options.window, drift=options.drift)]  # fmt: skip
    for name in ("mean", "relative", "drift"):
        lines.append(f'def {name}_error(time, signals):\n    return _size(time, signals, "{name}")\n')
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        put(folder / "pointing.py", "\n\n".join(lines))
        put(file, f"# Written by orchestrate review.\n{written(campaign(facts, options, folder))}")
    return read_campaign(file)


def fly(facts: Facts, options: Options, folder: Path, tell: Callable[[int], None]) -> tuple[Case, Rows]:
    """Flies what is left of the campaign and returns its rows. Raises InputError, KeyboardInterrupt."""
    case = prepared(facts, options, folder)
    finished = engine.fly(case, folder / DRAWN, options.workers, tell=lambda at: tell(at.flown))
    if finished.interrupted:
        raise KeyboardInterrupt
    return case, Rows(folder / DRAWN)


def section(facts: Facts, options: Options, case: Case, rows: Rows) -> Section:
    """Returns the distribution of times beside the bound by momentum."""
    settled = {level: numbers(rows, f"within_{level}_deg", last_moment(facts)) for level in LEVELS}
    shown = [("rate below " + RATE, numbers(rows, "detumbling_time", last_moment(facts)))]
    shown += [(f"error below {level} deg", values) for level, values in settled.items()]
    if (goal := f"error below {math.degrees(facts.goal):g} deg") not in dict(shown):
        shown.insert(1, (goal, numbers(rows, "settling_time", last_moment(facts))))
    table = [[name, *_times(values)] for name, values in shown]
    errors = [
        [name, *(number(v) for v in np.quantile(values[~np.isnan(values)], [0.5, 0.9, 1.0], method="inverted_cdf"))]
        for name, values in (
            ("largest error of the second orbit, deg", rows.numbers("absolute_error")),
            ("rms of it, deg", rows.numbers("rms_error")),
            ("largest momentum of a wheel, tumble included, mN.m.s", 1e3 * rows.numbers("wheel_momentum")),
        )
        if len(values[~np.isnan(values)]) and (facts.wheels or "wheel" not in name)
    ]
    failed = int(rows.failed.sum())
    bounds, why = least_times(facts, case)
    rate = math.degrees(float(np.linalg.norm(facts.satellite.p.omega_B0)))
    notes = [
        f"{len(rows)} tumbles from any attitude at {rate:.3g} "
        f"deg/s in any direction, {ORBITS:g} orbits each, seed {options.seed}; {failed} failed. Their page: "
        "tumbles/campaign.html; one of them again: orchestrate campaign tumbles.yaml --out tumbles --replay RUN",
        why or _bounded(bounds),
    ]
    steps = [(level, np.sort(values[np.isfinite(values)])) for level, values in settled.items()]
    latest = max((float(t[-1]) for _, t in steps if len(t)), default=ORBITS * facts.period)
    grid = np.linspace(0.0, min(MORE * latest, ORBITS * facts.period), 201)
    figure = Curves(
        "Tumbles that have settled",
        (grid / 60.0).tolist(),
        "time, min",
        "share of the tumbles",
        {f"{level} deg": (np.searchsorted(t, grid, "right") / max(len(rows), 1)).tolist() for level, t in steps},
    )
    return Section(
        "Tumbles",
        [
            Table(
                "Time to settle",
                ["until", "settled", "median, s", "90%, s", "worst, s"],
                table,
                "From the start, also while no attitude is known yet; to the end of the flight, and for its last "
                "sixth at least. The median is the least time within which half of the tumbles settled.",
            ),
            Table("Hold after the tumble", ["", "median", "90%", "worst"], errors),
        ],
        [figure] if any(len(t) for _, t in steps) else [],
        notes,
    )


def _bounded(bounds: list[float]) -> str:
    """Says the least times, s, of the first tumbles."""
    if not max(bounds):
        return (
            f"The wheels can hold the momentum of the first {len(bounds)} of these tumbles: its balance bounds no time."
        )
    return (
        f"By the balance of momentum no controller needs less than {min(bounds):.0f} to {max(bounds):.0f} s for "
        f"the first {len(bounds)} of these tumbles (orchestrate momentum-bound); it counts the attitude as known."
    )


def last_moment(facts: Facts) -> float:
    """Returns when a tumble has settled at the latest, s: it has to stay so for a sixth of its flight."""
    return (1.0 - LASTING) * ORBITS * facts.period


def numbers(rows: Rows, metric: str, latest: float) -> Array:
    """Returns a metric of the tumbles; NaN for a time that is later."""
    values: Array = rows.numbers(metric)
    is_time = metric in ("settling_time", "detumbling_time") or metric.startswith("within_")
    return np.where(values > latest, np.nan, values) if is_time else values


def _times(values: Array) -> list[str]:
    """The share that settled, and quantiles over all; a dash where it has not settled."""
    values = np.where(np.isnan(values), np.inf, values)
    told = [np.quantile(values, q, method="inverted_cdf") for q in (0.5, 0.9, 1.0)]
    return [f"{int(np.isfinite(values).sum())} of {len(values)}", *(number(float(v), 4) for v in told)]


def least_times(facts: Facts, case: Case) -> tuple[list[float], str]:
    """Returns the least times, s, of some tumbles, or why there are none."""
    p = facts.satellite.p
    if not p.dipole_max > 0.0:
        return [], "There are no rods, and no bound by the balance of momentum."
    found = []
    for i in range(min(BOUNDED, case.runs)):
        values = zip(case.job.draws.draws, case.job.draws.at(_point(case, i)), strict=True)
        start = {one.name.partition(".")[2]: np.asarray(one.known(value), float) for one, value in values}
        moved: dict[str, Any] = {
            key: start[key] for key in ("Q0", "omega_B0", "residual_dipole_B", "J_error_B") if key in start
        }
        law = parameters("controller", {}, controller)
        bound = MomentumBalance(replace(p, initial_attitude="Q0", **moved), law, horizon=facts.period).least_time()
        found.append(facts.period if bound.least is None else bound.least)
    return found, ""


def draw(case: Case, index: int) -> dict[str, Any]:
    """Returns the start values of a run by name, in SI units."""
    draws = case.job.draws
    return draws.texts(draws.at(_point(case, index)))


def _point(case: Case, index: int) -> list[float]:
    point: list[float] = case.job.design.points([index])[0].tolist()
    return point


def worst(rows: Rows, asked: Asked, latest: float) -> int | None:
    """Returns the run that is farthest on the wrong side of a requirement."""
    values = numbers(rows, asked.metric, latest)
    bad = np.where(np.isnan(values), np.inf, values if asked.below is not None else -values)
    return int(rows.index[int(np.argmax(bad))]) if len(bad) else None


def counted(rows: Rows, asked: Asked, latest: float) -> tuple[int, int, float]:
    """Returns how many runs meet a requirement, of how many, and the margin of the share that it asks for, in the
    metric's own unit.
    """
    values = numbers(rows, asked.metric, latest) * (math.pi / 180.0 if in_degrees(asked.metric) else 1.0)
    if asked.below is not None:
        values = np.where(np.isnan(values), np.inf, values)
        margin = asked.below - float(np.quantile(values, asked.probability, method="inverted_cdf"))
        return int((values < asked.below).sum()), len(values), margin
    assert asked.above is not None
    values = np.where(np.isnan(values), -np.inf, values)
    margin = float(-np.quantile(-values, asked.probability, method="inverted_cdf")) - asked.above
    return int((values > asked.above).sum()), len(values), margin


def in_degrees(metric: str) -> bool:
    return metric in ("absolute_error", "knowledge_error")
