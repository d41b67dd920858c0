"""The text of docs/flight.md, every number in it from the flights that it is given."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence

import numpy as np

from . import flight_cases
from .claims import ORBIT
from .flight import Done
from .flight_cases import BESIDE, HOLD_ORBITS, PAIRINGS, RATE_MAX, SEEDS, SHORT, TRIED, TRIES, TUNED, Case, share
from .flight_run import HOLD, RATE, Row, truth
from .vectors import Array

GOALS = {"nominal": (0.09, 0.20, 0.01), "errors": (0.10, 0.23, 0.1)}
"""Median and worst time to 5 deg, orbits, and hold error, deg rms."""
SAID = {"nominal": "nominal", "errors": "all errors"}
SCHEMES = {"": "planned", ", tuned": "law [8], tuned", ", paper": "the paper's scheme"}


def text(done: Done) -> str:
    """The page."""
    parts = (_head, _results, _failures, _manoeuvres, _hold, _tried, _pairings, _kinds, _calls, _made)
    return "\n\n".join(part(done).strip() for part in parts if part(done).strip()) + "\n"


def _table(header: str, rows: Sequence[Sequence[str]]) -> str:
    lines = [header.split("|"), ["---"] * len(header.split("|")), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _picture(name: str, alt: str) -> str:
    return f"![{alt}](figures/flight-{name}.png)"


# ---------------------------------------------------------------- numbers


def _orbits(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "not settled"


def _share(times: Array) -> str:
    return f"{int(np.isfinite(times).sum())} of {len(times)}"


def _quantile(times: Array, q: float) -> float:
    """Of all cases, those that never settle counted as later than all others."""
    return float(np.sort(times)[max(0, math.ceil(q * len(times)) - 1)])


def _hold_errors(done: Done, group: str) -> Array:
    """Rms angle over the last seconds of the cases that had settled below 5 deg by then, deg."""
    held = [row for _, row in done.of(group) if row.get("settled5") is not None]
    return np.degrees([row["hold_rms"] for row in held if row["settled5"] <= row["duration"] - HOLD])


def _degrees(value: float) -> str:
    return f"{value:.2g}°" if value < 9.95 else f"{value:.0f}°"


def _worst(done: Done, group: str) -> Case:
    return done.of(group)[int(np.argmax(done.times(group)))][0]


def _over_bound(done: Done, group: str, bounds: str) -> str:
    least = done.least(bounds)[: len(done.of(group))]
    times = done.times(group)
    usable = np.isfinite(times) & (least > 1.0 / ORBIT)
    return f"{np.median(times[usable] / least[usable]):.1f}" if usable.any() else "–"


# ---------------------------------------------------------------- parts


def _head(done: Done) -> str:
    verdicts = []
    for group in SAID:
        t = done.times(group)
        verdicts.append(
            f"{SAID[group]} {_share(t)} settle, in {_orbits(_quantile(t, 0.5))} orbit at the median and {_orbits(float(t.max()))} at worst"
        )
    beside = {
        scheme: _share(np.concatenate([done.times(f"{g}{scheme}") for g in SAID])) for scheme in (", tuned", ", paper")
    }
    held = [float(np.median(_hold_errors(done, g))) for g in SAID]
    few = "" if done.n >= 1000 else f"\n> **A trial with {done.n} cases**, not the study.\n"
    return f"""
<!-- Written by `make flight` (python -m studies flight); do not edit. -->
# It flies in SI units

In SI units, with the hardware's limits (25 A m² a rod, 3 mN m, 30 mN m s) and the inertia diag(2.13, 3.04, 3.09) kg m², the published scheme does not detumble its own satellite
([reproduction.md](reproduction.md)). `controller_planned` and `allocator_bounded` do, in the same three blocks and on the same ports. This page flies them {len(done.cases)} times against the
plant's truth, beside the paper's scheme and beside its law (8) with tuned gains. [planned.md](planned.md) says how they work.
{few}
- **Random tumbles up to {math.degrees(RATE_MAX):.0f} deg/s**, any attitude, any node: {"; ".join(verdicts)}.
- **The hold** is {_degrees(held[0])} rms at the median nominally, {_degrees(held[1])} under all errors.
- **Beside it**, on the same tumbles and within three orbits: law (8) with tuned gains and the bounded allocator settles {beside[", tuned"]}, the paper's scheme {beside[", paper"]}.

Settled means: below 5° (and 1°) between attitude and LVLH and below {RATE:g} rad/s from then to the end of the run. Both are computed here from the plant's attitude, rate, position and velocity, never
from what the controller says of itself. An orbit is {ORBIT:.1f} s.

    orchestrate scenarios/flight_vb.yaml --figures        # V.B; also flight_vc, flight_tumble (all errors) and flight_hold (20 orbits)
"""


def _goal(found: float, goal: float, unit: str = "") -> str:
    word = "met" if found <= goal * (1.0 + 1e-9) else "**missed**"
    return f"{goal:g}{unit} {word}"


def _results(done: Done) -> str:
    header = "|cases|below 5°|median, orbits|90%|worst|below 1°|median|worst|hold rms, median|worst|over the bound, median|worst case"
    rows = []
    for scheme, name in SCHEMES.items():
        for group, said in SAID.items():
            cases, t, fine = done.of(group + scheme), done.times(group + scheme), done.times(group + scheme, 1)
            held = _hold_errors(done, group + scheme)
            rows.append(
                [
                    f"**{name}**, {said}" if not scheme else f"{name}, {said}",
                    f"{len(cases)}",
                    f"{100.0 * np.isfinite(t).mean():.4g}%",
                    _orbits(_quantile(t, 0.5)),
                    _orbits(_quantile(t, 0.9)),
                    _orbits(float(t.max())),
                    f"{100.0 * np.isfinite(fine).mean():.4g}%",
                    _orbits(_quantile(fine, 0.5)),
                    _orbits(float(fine.max())),
                    _degrees(float(np.median(held))) if len(held) else "–",
                    _degrees(float(held.max())) if len(held) else "–",
                    _over_bound(done, group + scheme, group) + (" ×" if np.isfinite(t).any() else ""),
                    f"{_worst(done, group).seed}" if not scheme else "",
                ]
            )
    goals = []
    for group, (median, worst, hold) in GOALS.items():
        t, held = done.times(group), _hold_errors(done, group)
        count = int(np.isfinite(t).sum())
        goals.append(
            [
                SAID[group],
                f"{count} of {len(t)}: " + ("met" if count == len(t) else "**missed**"),
                f"{_orbits(_quantile(t, 0.5))}: goal {_goal(round(_quantile(t, 0.5), 3), median)}",
                f"{_orbits(float(t.max()))}: goal {_goal(round(float(t.max()), 3), worst)}",
                f"median {_degrees(float(np.median(held)))}, worst {_degrees(float(held.max()))}: goal {_goal(float(np.median(held)), hold, '°')} at the median, "
                + ("met" if held.max() <= hold else f"**missed** by {int((held > hold).sum())} of {len(held)}")
                + " by each",
            ]
        )
    best = TUNED
    return f"""
## Random tumbles

Attitude uniform on SO(3), direction of the rate uniform, its size uniform in 0 to {math.degrees(RATE_MAX):.0f} deg/s, node uniform, drag and gravity gradient on. Nominal: a disturbance of 10⁻⁶ N m in a random direction, perfect sensors.
All errors together: inertia 5 to 10% off in each axis, rods that give 0.9 of their command, a disturbance of 10⁻⁵ N m, noise of 0.01° about each axis, 10⁻⁵ rad/s and 50 nT, an onboard field model 200 nT off
(in its dipole). Cases that have not settled within {SHORT / ORBIT:.1f} orbits are flown for 3. The hold's error is the rms over the last {HOLD:.0f} s of those that have settled by then.

{_table(header, rows)}

Those that never settle count as later than all others in every percentile. *The bound* is each case's own [momentum bound](reproduction.md#the-balance-of-momentum): a proven lower bound for any controller with these rods, from the same start,
to the tolerance of 5°. *Law [8], tuned* is the paper's `controller` with `allocator_bounded`, K = {best["K0"][1]:.3g} diag(0.9, 1, 1.1) N m and L = {best["L0"][0][0]:.3g} I N m s, the best of a random search on tumbles of its own
(`python -m studies flight-tune`). *The paper's scheme* is `controller` and `allocator` with the paper's gains, at 10 Hz. Both fly the first {share(done.n, BESIDE)} of the cases under each condition, for 3 orbits, as all 1000 would take too long.

| goals | settled | median to 5°, orbits | worst | hold rms |
| --- | --- | --- | --- | --- |
{chr(10).join("| " + " | ".join(row) + " |" for row in goals)}

{_picture("settling", "share of tumbles settled over time, beside the bound of momentum")}

{_picture("bound", "each tumble's time against its own bound and its initial rate")}

A tumble under all errors, `scenarios/flight_tumble.yaml`: the rods first turn the total momentum to where it has to be, then a plan takes attitude, rate and wheel to the hold together.

{_picture("one", "a tumble under all errors: angle, rate, dipoles, wheel")}
"""


def cause(row: Row) -> str:
    """Why a case has not settled, as far as its row tells."""
    if "failed" in row:
        return f"the run failed: {row['failed']}"
    end = f"{_degrees(math.degrees(row['end_angle']))} and {row['end_rate']:.1e} rad/s at the end of {row['duration'] / ORBIT:.1f} orbits"
    if row.get("steered", 0.0) is None:
        return f"still steering the momentum: {end}"
    if row["wheel_full"] > 0.01:
        return f"wheel at its limit for {100.0 * row['wheel_full']:.0f}% of the time: {end}"
    return f"{end}; at most {_degrees(math.degrees(row['hold_max']))} in the last {HOLD:.0f} s"


def _failures(done: Done) -> str:
    lines = []
    for group, said in SAID.items():
        for degrees in (5, 1):
            for case, row in done.of(group):
                if row.get(f"settled{degrees}") is None:
                    lines.append(f"- {said}, seed {case.seed}, not below {degrees}°: {cause(row)}")
        late = [(case, row) for case, row in done.of(group) if (row.get("settled5") or 0.0) / ORBIT > GOALS[group][1]]
        for case, row in sorted(late, key=lambda both: -both[1]["settled5"])[:20]:
            steered = row.get("steered")
            lines.append(
                f"- {said}, seed {case.seed}, later than the goal: {row['settled5'] / ORBIT:.3f} orbits, from {math.degrees(row['rate']):.1f} deg/s; "
                f"steering took {(steered or 0.0) / ORBIT:.3f}"
            )
        if len(late) > 20:
            lines.append(f"- {said}: and {len(late) - 20} more later than the goal")
    said_all = (
        "\n".join(lines) if lines else "None: every tumble settles below 5° and below 1°, and none later than the goal."
    )
    return f"""
## Every case that fails or is late

{said_all}

`python -m studies flight-case errors {SEEDS["errors"]}` flies one of them again and writes it as a scenario.
"""


def _manoeuvres(done: Done) -> str:
    rows = []
    for which, name in (("vb", "V.B"), ("vc", "V.C")):
        for scheme, said in SCHEMES.items():
            group = f"{which}{scheme}"
            t, fine, held = done.times(group), done.times(group, 1), _hold_errors(done, group)
            rows.append(
                [
                    name,
                    said,
                    _share(t),
                    _orbits(_quantile(t, 0.5)),
                    _orbits(float(t.max())),
                    _share(fine),
                    _orbits(float(fine.max())),
                    _degrees(float(held.max())) if len(held) else "–",
                    _over_bound(done, group, which) + (" ×" if np.isfinite(t).any() else ""),
                ]
            )
    return f"""
## V.B and V.C from every node

The paper's two starts (90° and 5.5 deg/s; 90° and 4.4 deg/s) in SI units at {len(flight_cases.NODES)} longitudes of the node, drag and gravity gradient on, no errors:

{_table("manoeuvre|scheme|below 5°|median, orbits|worst|below 1°|worst|hold rms, worst|over the bound, median", rows)}

{_picture("nodes", "V.B and V.C by longitude of the node")}
"""


def _hold(done: Done) -> str:
    rows = [
        [
            f"{case.seed}",
            f"{1e3 * row['wheel_max']:.1f}",
            f"{1e3 * row['late_wheel']:.1f}",
            _degrees(math.degrees(row["late_rms"])),
            _degrees(math.degrees(row["late_max"])),
        ]
        for case, row in done.of("hold")
        if "late_rms" in row
    ]
    return f"""
## Hold and unloading over {HOLD_ORBITS} orbits

`scenarios/flight_hold.yaml`: 1° off at the start and 25 of 30 mN m s in the wheel, all errors, drag, a residual dipole of 0.09 A m² and the disturbance of 10⁻⁵ N m, from {len(rows)} nodes:

{_table("node, °E|wheel: largest, mN m s|after an orbit|error after an orbit, rms|largest", rows)}

{_picture("holding", "20 orbits of hold: angle and wheel momentum")}

{_peaks(done)}
"""


def _peaks(done: Done) -> str:
    """How long after passages of the field through the normal to the wheel's axis the error is largest."""
    r = done.hold
    error, _ = truth(*(r[f"plant.{name}"] for name in ("R_NB", "omega_B", "r_N", "v_N")))
    b, t = r["allocator.b_wheel"], r.time
    zeros = t[:-1][np.sign(b[:-1]) * np.sign(b[1:]) < 0]
    half = int(0.25 * ORBIT / (t[1] - t[0]))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(error, half), 2 * half + 1).max(axis=1)
    peaks = [i for i in np.flatnonzero(error == around) if t[i] > ORBIT]
    delays = [t[i] - zeros[zeros <= t[i]].max() for i in peaks if (zeros <= t[i]).any()]
    if not delays:
        return ""
    return f"""The error peaks twice an orbit, {np.quantile(delays, 0.1):.0f} to {np.quantile(delays, 0.9):.0f} s after the field has passed the normal to the wheel's axis ({len(delays)} peaks at 158° E, the middle 80%): round such a passage wheel and rods give torques in a plane only,
what the disturbance gives along the field meets nothing, and what has gathered is taken out afterwards."""


def _tried(done: Done) -> str:
    rows = []
    for t in TRIED:
        five, one, held = done.times(t.name), done.times(t.name, 1), _hold_errors(done, t.name)
        failed = [row for _, row in done.of(t.name) if "failed" in row]
        rows.append(
            [
                t.said + (f" ({len(failed)} runs failed)" if failed else ""),
                _share(five),
                _orbits(_quantile(five, 0.5)),
                _orbits(_quantile(five, 0.9)),
                _orbits(float(five.max())),
                _share(one),
                _degrees(float(np.median(held))) if len(held) else "–",
                _degrees(float(held.max())) if len(held) else "–",
            ]
        )
    return f"""
## Also tried

The same {share(done.n, TRIES)} tumbles each time, nominal but for one thing (unless all errors are named), flown for {SHORT / ORBIT:.1f} orbits. “Not known” is not known to the flight software, which is told nothing of it.

{_table("what is different|below 5°|median, orbits|90%|worst|below 1°|hold rms, median|worst", rows)}

{_found(done)}
"""


def _found(done: Done) -> str:
    """What stands out in the table, by its own numbers."""
    usual = _quantile(done.times("as nominal"), 0.5)
    lost, slow, coarse = [], [], []
    for t in TRIED:
        times, held = done.times(t.name), _hold_errors(done, t.name)
        if not np.isfinite(times).all():
            lost.append(f"{t.said} ({int((~np.isfinite(times)).sum())})")
        elif _quantile(times, 0.5) > 1.5 * usual:
            slow.append(t.said)
        if len(held) and np.median(held) > 0.1:
            coarse.append(t.said)
    return "\n".join(
        f"- **{what}:** {'; '.join(names)}."
        for what, names in (
            ("Not all settle (how many do not)", lost),
            ("All settle, but half of them more than 1.5 times as late as nominally", slow),
            ("Held worse than 0.1° rms at the median of those that settle", coarse),
        )
        if names
    )


def _pairings(done: Done) -> str:
    rows = []
    for (law, allocator), said in PAIRINGS.items():
        row = done.rows[f"{law} + {allocator}/158"]
        times = [row.get(f"settled{d}") for d in (5, 1)]
        rows.append(
            [
                said,
                *(f"{t / ORBIT:.3f}" if t is not None else "not settled" for t in times),
                cause(row) if times[0] is None else f"hold {_degrees(math.degrees(row['hold_rms']))} rms",
            ]
        )
    return f"""
## Each controller with each allocator

V.B from 158° E for 3 orbits. All four run; a port that one side lacks stays unconnected. The paper's controller has the tuned gains here.

{_table("pairing|below 5°, orbits|below 1°|what it reaches", rows)}

The paper's allocator holds its last command while a demand exceeds 80% of a limit. Steering demands all that the rods have, so that it holds a command of zero from the first sample to the last: `controller_planned` needs an allocator
that takes the nearest torque within the limits.
"""


def _failure_rate(done: Done) -> str:
    """What the counts say of the failure rate, by the exact binomial bound."""
    from scipy.stats import beta

    said = []
    for group, name in SAID.items():
        n = len(done.of(group))
        k = n - int(np.isfinite(done.times(group)).sum())
        said.append(
            f"{name} {k} of {n} fail, so that rates above {100.0 * float(beta.ppf(0.95, k + 1, n - k)):.2g}% are excluded at 95% confidence"
        )
    return "; ".join(said)


def _kinds(done: Done) -> str:
    return f"""
## What is proven, what is measured, what is a heuristic

**Proven.** The momentum bound: no controller settles a case sooner, whatever it knows, with rods of this strength. Law (8) with exact torque and constant gains converges to its reference from almost
everywhere ([11] of the paper, shown for constant gains); the reference here is a plan. The allocator finds the minimum of its problem to rounding, in bounded time. Commands stay within the limits by construction, and the plan's wheel momentum likewise.

**Not proven.** That theorem says nothing about this loop: its torque is not exact, and the plan is made anew every 10 s from the measured state, so that replanning is the feedback that counts and the law in between corrects little. There is no proof of recursive feasibility
(that a plan within the limits is followed by one), none of convergence of the loop, and none that a disturbance is always met: near the poles it is not.

**Measured.** All of the above tables. They are statements about these cases, on this plant, and its plant has limits: rigid body, rods without lag or hysteresis, noise that is white. Of the tumbles
{_failure_rate(done)}, and no rate below is shown.

**Heuristic.** Two phases, momentum first, are a choice: a plan through the whole tumble would see more. The thresholds at which phases and horizons switch, the weights of the plan's cost, and the starts of its optimiser were found by trial. Box-constrained iLQR finds a local
minimum, after a fixed count of iterations not always that; three starts and a challenger every 30 s until settled make a bad one rare. Steering is the time-optimal condition of a simpler problem (momentum only, field known ahead), iterated a fixed number of times.
The observer and the identification rest on thresholds, too.
"""


def _calls(done: Done) -> str:
    c = done.calls
    return f"""
## What a call takes

{c.count} samples of the controller in ten tumbles under all errors, each with the setting of its inputs and the getting of its outputs, in processor time on {platform.machine()} ({platform.system()}), one core:
half take up to {1e6 * c.median:.0f} µs, 99.9% up to {1e3 * c.rarely:.1f} ms, the longest {1e3 * c.worst:.1f} ms. The longest are those that make or improve a plan.
The number of iterations is fixed, so the longest call is bounded. {_memory(c.memory)}
"""


def _memory(size: int | None) -> str:
    return (
        ""
        if size is None
        else f"An instance takes {size / 1024:.0f} KB, the workspace of its optimiser included, allocated once."
    )


def _made(done: Done) -> str:
    return f"""
## How this page is made

`make flight` flies everything anew, about half an hour on two cores, with two processes and a progress bar. Rows are kept under results/flight/ by case and by the FMUs that flew them: what was interrupted goes on, and after a change of a block its cases are
flown again. `python -m studies flight --cases 40` is a trial, and writes beside the rows.
[flight.csv](flight.csv) has every case with its times, its bound and its hold.

Seeds: case i of the nominal tumbles has numpy's `default_rng({SEEDS["nominal"]} + i)`, under all errors {SEEDS["errors"]} + i, in the table of what was also tried {SEEDS["tried"]} + i. The planner was tuned on seeds 1000 to 3999, and law (8)'s gains on
4001 to 4200; none of those is flown here, and no case of this page was used to tune anything.
"""
