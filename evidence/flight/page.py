"""The fields of docs/evidence/flight.md, each a number or a table from the flights; page.md.j2 has the words."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy.stats import beta

from .. import markdown
from ..markdown import degrees, finite, orbits
from ..paper import ORBIT, Array
from . import conditions
from .cases import EARLY, HOLD, HOLD_ORBITS, RATE, RATE_MAX, SEEDS
from .kept import Flights, angle, quantile
from .schemes import TUNED

NAMES = {"nominal": "nominal", "errors": "all errors"}
_WHEEL, _ERROR = ("wheel_max_mNms", "later_wheel_mNms"), ("later_rms_deg", "later_max_deg")
SCHEMES = {"": "planned", " tuned": "law [8], tuned", " paper": "the paper's scheme"}


def text(flights: Flights) -> str:
    """Returns the page."""
    n = len(flights.of("nominal"))
    verdicts = [
        {"name": NAMES[g].capitalize(), "held": angle(flights.hold_errors(g), np.median), **_summary(flights.times(g))}
        for g in NAMES
    ]
    beside = {s: finite(np.concatenate([flights.times(f"{g} {s}") for g in NAMES])) for s in ("tuned", "paper")}
    tried = conditions.tried(flights)
    tries = len(flights.of("as nominal"))
    kept = [row for row in tried if row[1] == finite(np.zeros(tries)) and row[4] == "0"]
    sound = [row for row in kept if row[5] == "0"]
    found = [row for row in kept if row[5].startswith(f"{tries} ")]
    return markdown.render(
        Path(__file__).parent,
        trial="" if n >= 1000 else " and ".join(f"{len(flights.of(g))} ({name})" for g, name in NAMES.items()),
        rate_max=f"{math.degrees(RATE_MAX):.0f}",
        verdicts=verdicts,
        beside=beside,
        over=_over_bound(flights, "nominal", "nominal"),
        rate=f"{RATE:g}",
        orbit=f"{ORBIT:.1f}",
        early=f"{EARLY / ORBIT:.1f}",
        hold_s=f"{HOLD:.0f}",
        results=[row for row in _results(flights) if row[2] != "0%"],
        unsettled="; ".join(row[0] for row in _results(flights) if row[2] == "0%"),
        tuned_K=f"{TUNED['K0'][1]:.3g}",
        tuned_L=f"{TUNED['L0'][0][0]:.3g}",
        failures=_failures(flights),
        false_alarms={g: f"{len(flights.told(g))} of {len(flights.of(g))}" for g in NAMES},
        nodes=len(flights.of("vb")),
        manoeuvres=[row for row in _manoeuvres(flights) if row[2][:2] != "0 "],
        hold_orbits=HOLD_ORBITS,
        holds=_holds(flights),
        tries=tries,
        tried=[row for row in tried if row not in sound and row not in found],
        found="; ".join(row[0] for row in found),
        conditions=len(tried),
        sound=len(sound),
        sound_median=f"{min(row[2] for row in sound)} to {max(row[2] for row in sound)}" if sound else "",
        sound_worst=max((row[3] for row in sound), default=""),
        pairings=conditions.pairings(flights),
        failure_rates="; ".join(_failure_rate(flights, g) for g in NAMES).capitalize(),
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
            t = flights.times(group + scheme)
            held = flights.hold_errors(group + scheme)
            rows.append(
                [
                    f"{name}, {condition}" if scheme else f"**{name}**, {condition}",
                    f"{len(t)}",
                    f"{100.0 * np.isfinite(t).mean():.4g}%",
                    *(orbits(quantile(t, q)) for q in (0.5, 1.0)),
                    angle(held, np.median),
                    angle(held, np.max),
                    _over_bound(flights, group + scheme, group),
                ]
            )
    return rows


def _failures(flights: Flights) -> str:
    lines = [
        f"- {condition}, run {line['run']}, not below {degree}°: {line['remark']}"
        for group, condition in NAMES.items()
        for degree in (5, 1)
        for line in flights.of(group)
        if not line[f"settled_{degree}deg_s"]
    ]
    return "\n".join(lines) or "Every tumble settles below 5° and below 1°."


def _manoeuvres(flights: Flights) -> list[list[str]]:
    rows = []
    for which, name in (("vb", "V.B"), ("vc", "V.C")):
        for scheme, label in SCHEMES.items():
            group = which + scheme
            t = flights.times(group)
            rows.append([name, label, *_summary(t).values(), angle(flights.hold_errors(group), np.max)])
    return rows


def _holds(flights: Flights) -> dict[str, str]:
    """The worst over the nodes."""
    most = {name: float(flights.column("hold", name).max()) for name in (*_WHEEL, *_ERROR)}
    first, later = (f"{most[name]:.1f}" for name in _WHEEL)
    rms, largest = (degrees(most[name]) for name in _ERROR)
    return {"nodes": str(len(flights.of("hold"))), "first": first, "later": later, "rms": rms, "largest": largest}


def _failure_rate(flights: Flights, group: str) -> str:
    """Returns what the counts say of the failure rate, by the exact binomial bound."""
    n = len(flights.of(group))
    k = n - int(np.isfinite(flights.times(group)).sum())
    rate = 100.0 * float(beta.ppf(0.95, k + 1, n - k))
    return f"{NAMES[group]} {k} of {n} fail, so rates above {rate:.2g}% are excluded at 95% confidence"
