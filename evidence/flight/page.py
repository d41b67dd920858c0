"""The fields of docs/evidence/flight.md, each a number or a table from the flights; page.md.j2 has the words."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import beta

from orchestration import Result

from .. import markdown
from ..markdown import degrees, finite, orbits
from ..paper import ORBIT, Array
from . import conditions
from .calls import Calls
from .cases import EARLY, HOLD, HOLD_ORBITS, RATE, RATE_MAX, SEEDS
from .closest import Closest, compared
from .figures import errors
from .kept import GOALS, Flights, angle, quantile
from .schemes import TUNED

NAMES = {"nominal": "nominal", "errors": "all errors"}
SCHEMES = {"": "planned", " tuned": "law [8], tuned", " paper": "the paper's scheme"}


def text(flights: Flights, hold: Result, calls: Calls, closest: Sequence[Closest] = ()) -> str:
    """The page; `hold` is the run of scenarios/flight_hold.yaml, `closest` what was sought of SOUGHT."""
    n = len(flights.of("nominal"))
    best = [{"name": NAMES[g].capitalize(), **_summary(flights.times(g))} for g in NAMES]
    beside = {s: finite(np.concatenate([flights.times(f"{g} {s}") for g in NAMES])) for s in ("tuned", "paper")}
    return markdown.render(
        Path(__file__).parent,
        cases=len(flights.lines),
        trial="" if n >= 1000 else " and ".join(f"{len(flights.of(g))} ({name})" for g, name in NAMES.items()),
        rate_max=f"{math.degrees(RATE_MAX):.0f}",
        verdicts=best,
        held={g: degrees(float(np.median(flights.hold_errors(g)))) for g in NAMES},
        beside=beside,
        rate=f"{RATE:g}",
        orbit=f"{ORBIT:.1f}",
        early=f"{EARLY / ORBIT:.1f}",
        hold_s=f"{HOLD:.0f}",
        results=_results(flights),
        tuned_K=f"{TUNED['K0'][1]:.3g}",
        tuned_L=f"{TUNED['L0'][0][0]:.3g}",
        beside_cases=len(flights.of("nominal tuned")),
        goals=[_goals(flights, g) for g in NAMES],
        failures=_failures(flights),
        false_alarms={g: f"{len(flights.told(g))} of {len(flights.of(g))}" for g in NAMES},
        nodes=len(flights.of("vb")),
        manoeuvres=_manoeuvres(flights),
        hold_orbits=HOLD_ORBITS,
        holds=_holds(flights),
        peaks=_peaks(hold),
        tries=len(flights.of("as nominal")),
        tried=conditions.tried(flights),
        notable=conditions.notable(flights),
        closest=compared(flights, closest),
        pairings=conditions.pairings(flights),
        failure_rates="; ".join(_failure_rate(flights, g) for g in NAMES),
        calls=_calls(calls),
        seeds=SEEDS,
    )


def _summary(times: Array) -> dict[str, str]:
    return {"share": finite(times), "median": orbits(quantile(times, 0.5)), "worst": orbits(float(times.max()))}


def _over_bound(flights: Flights, group: str, bounds: str) -> str:
    """Median of time over bound, of those that settle and whose bound exceeds a second."""
    times = flights.times(group)
    least = flights.least(bounds)[: len(times)]
    usable = np.isfinite(times) & (least > 1.0 / ORBIT)
    return f"{np.median(times[usable] / least[usable]):.1f} ×" if usable.any() else "–"


def _results(flights: Flights) -> list[list[str]]:
    rows = []
    for scheme, name in SCHEMES.items():
        for group, condition in NAMES.items():
            t, fine = flights.times(group + scheme), flights.times(group + scheme, 1)
            held = flights.hold_errors(group + scheme)
            rows.append(
                [
                    f"{name}, {condition}" if scheme else f"**{name}**, {condition}",
                    f"{len(t)}",
                    f"{100.0 * np.isfinite(t).mean():.4g}%",
                    *(orbits(quantile(t, q)) for q in (0.5, 0.9, 1.0)),
                    f"{100.0 * np.isfinite(fine).mean():.4g}%",
                    *(orbits(quantile(fine, q)) for q in (0.5, 1.0)),
                    angle(held, np.median),
                    angle(held, np.max),
                    _over_bound(flights, group + scheme, group),
                    "" if scheme else flights.of(group)[int(np.argmax(t))]["run"],
                ]
            )
    return rows


def _goals(flights: Flights, group: str) -> list[str]:
    goals = GOALS[group]
    t, held = flights.times(group), flights.hold_errors(group)

    def verdict(value: float, goal: float) -> str:
        return "met" if value <= goal * (1.0 + 1e-9) else "**missed**"

    above = int((held > goals[2]).sum())
    found = [round(quantile(t, 0.5), 3), round(float(t.max()), 3)]
    return [
        NAMES[group],
        f"{finite(t)}: " + ("met" if np.isfinite(t).all() else "**missed**"),
        *(
            f"{orbits(value)}: goal {goal:g} {verdict(value, goal)}"
            for value, goal in zip(found, goals[:2], strict=True)
        ),
        f"median {angle(held, np.median)}, worst {angle(held, np.max)}: goal {goals[2]:g}° "
        f"{verdict(float(np.median(held)), goals[2])} at the median, "
        + (f"**missed** by {above} of {len(held)}" if above else "met by each"),
    ]


def _failures(flights: Flights) -> str:
    lines = []
    for group, condition in NAMES.items():
        for degree in (5, 1):
            for line in flights.of(group):
                if not line[f"settled_{degree}deg_s"]:
                    lines.append(f"- {condition}, run {line['run']}, not below {degree}°: {line['remark']}")
        goal = GOALS[group][1] * ORBIT
        late = [line for line in flights.of(group) if float(line["settled_5deg_s"] or 0.0) > goal]
        for line in sorted(late, key=lambda line: -float(line["settled_5deg_s"])):
            time = float(line["settled_5deg_s"]) / ORBIT
            lines.append(
                f"- {condition}, run {line['run']}, later than the goal: {time:.3f} orbits, "
                f"from {float(line['initial_rate_deg_s']):.1f} deg/s; {line['remark']}"
            )
    return "\n".join(lines) or "None: every tumble settles below 5° and below 1°, and none later than the goal."


def _manoeuvres(flights: Flights) -> list[list[str]]:
    rows = []
    for which, name in (("vb", "V.B"), ("vc", "V.C")):
        for scheme, label in SCHEMES.items():
            group = which + scheme
            t, fine = flights.times(group), flights.times(group, 1)
            rows.append(
                [
                    *(name, label, *_summary(t).values(), finite(fine), orbits(float(fine.max()))),
                    *(angle(flights.hold_errors(group), np.max), _over_bound(flights, group, which)),
                ]
            )
    return rows


def _holds(flights: Flights) -> list[list[str]]:
    return [
        [line["node_deg"]]
        + [f"{float(line[name]):.1f}" for name in ("wheel_max_mNms", "later_wheel_mNms")]
        + [degrees(float(line[name])) for name in ("later_rms_deg", "later_max_deg")]
        for line in flights.of("hold")
        if line["later_rms_deg"]
    ]


def _peaks(hold: Result) -> dict[str, str] | None:
    """How long after passages of the field through the normal to the wheel axis the error is largest."""
    error, _ = errors(hold)
    b, t = hold["allocator.b_wheel"], hold.time
    zeros = t[:-1][np.sign(b[:-1]) * np.sign(b[1:]) < 0]
    half = int(0.25 * ORBIT / (t[1] - t[0]))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(error, half), 2 * half + 1).max(axis=1)
    peaks = [i for i in np.flatnonzero(error == around) if t[i] > ORBIT]
    delays = [t[i] - zeros[zeros <= t[i]].max() for i in peaks if (zeros <= t[i]).any()]
    if not delays:
        return None
    first, last = np.quantile(delays, (0.1, 0.9))
    return {"first": f"{first:.0f}", "last": f"{last:.0f}", "count": f"{len(delays)}"}


def _failure_rate(flights: Flights, group: str) -> str:
    """What the counts say of the failure rate, by the exact binomial bound."""
    n = len(flights.of(group))
    k = n - int(np.isfinite(flights.times(group)).sum())
    rate = 100.0 * float(beta.ppf(0.95, k + 1, n - k))
    return f"{NAMES[group]} {k} of {n} fail, so rates above {rate:.2g}% are excluded at 95% confidence"


def _calls(c: Calls) -> dict[str, str]:
    return {
        "count": f"{c.count}",
        "machine": f"{platform.machine()} ({platform.system()})",
        "median": f"{1e6 * c.median:.0f}",
        "rarely": f"{1e3 * c.rarely:.1f}",
        "worst": f"{1e3 * c.worst:.1f}",
        "memory": f"{c.memory / 1024:.0f}" if c.memory else "",
    }
