"""The tables, the figure and the CSV file of docs/evidence/flight_data.md; page.md.j2 has the words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..plots import BLUE, GREEN, RED, name_axes, panels
from . import spins
from .parts import TRIED
from .study import Shown, air_and_rest, pair, sky
from .told import beyond, of_flown, of_known, of_motion
from .whole import Study


def figure(done: Study) -> Any:
    """Gain, errors on the sky, ambiguity, and a forecast."""
    drawing, axes = panels(2, 2, 5.2, 3.4)
    colours = (BLUE, RED, GREEN)
    gain, size, witness, ambiguity = axes.flat
    for s, colour in zip(done.shown, colours, strict=False):
        minutes, name = s.flight.t / 60.0, s.flight.name
        gain.plot(s.calibration.knots / 60.0, s.calibration.gain, "o-", color=colour, markersize=3, label=name)
        size.plot(minutes, 1e6 * s.calibration.residual, ".", color=colour, markersize=1.2)
        _, error, on = sky(s.flight, s.attitude)
        witness.plot(minutes[on], error[on], ".", color=colour, markersize=3)
        ambiguity.plot(minutes, np.degrees(s.attitude.ambiguity), color=colour, linewidth=1.0)
    name_axes(gain, "min", "gain", "Common gain of the magnetometer")
    name_axes(size, "min", "uT", "|B| as calibrated less that of IGRF")
    name_axes(witness, "min", "deg", "Sun sensors, withheld, against the attitude")
    name_axes(ambiguity, "min", "deg", "Angle to the farthest attitude not excluded")
    if done.shown:
        gain.legend(fontsize=7)
    size.set_ylim(-3.0, 3.0)
    ambiguity.set_yscale("symlog", linthresh=1.0)
    return drawing


def fields(done: Study) -> dict[str, Any]:
    """Returns what the template takes."""
    records = [
        [s.flight.name, str(len(s.flight.t)), f"{1e6 * s.constant:.2f}", f"{1e6 * s.calibration.rms:.2f}"]
        for s in done.shown
    ]
    crossed = [[s.flight.name, other, f"{1e6 * rms:.2f}"] for s in done.shown for other, rms in s.crossed.items()]
    shadow = [
        [s.flight.name, "entry" if e.entry else "exit", f"{e.time:.0f}", f"{e.late:+.1f}", f"{e.late_air:+.1f}"]
        for s in done.shown
        for e in s.edges
    ]
    free = done.free
    parts = [(s.flight.name, both) for s in done.shown if (both := air_and_rest(s.edges)) is not None]
    through = [
        (sky(s.flight, a)[0], pair(s.flight, a)) for s, a in zip(done.shown, done.flown, strict=True) if a is not None
    ]
    wrong = [spins.counted(cases)["wrong, not reported"] for cases in done.spins.values()]
    counts = [
        [what, *(str(n) for n in spins.counted(cases).values()), f"{spins.largest_trusted(cases):.1f}"]
        for what, cases in done.spins.items()
    ]
    return {
        "records": records,
        "crossed": crossed,
        "shadow": shadow,
        "apart": " and ".join(f"{np.degrees(s.apart):.1f}" for s in done.shown),
        "tried": "|".join(("record", *TRIED)),
        "likelihoods": [
            [s.flight.name, *(f"{x:.0f}" for x in row)] for s, row in zip(done.shown, done.likelihoods, strict=False)
        ],
        "parts_count": str(len(done.cuts)),
        "parts_ranges": _ranges(done.cuts),
        "spins_count": str(len(next(iter(done.spins.values()), []))),
        "beyond": str(len(beyond(done)) or "none"),
        "beyond_lines": beyond(done),
        "known_lines": of_known(done.known) if done.known else [],
        "left": " and ".join(f"{np.degrees(s.left):.3f}" for s in done.shown),
        "motion_lines": of_motion(done),
        "counts": counts,
        "flown": of_flown(done),
        "c_three": next((f"{three.rms:.1f}" for three, _ in through if three is not None), "-"),
        "c_two": next((f"{two.rms:.1f}" for _, two in through if two is not None), "-"),
        "one_wrong": str(wrong[0]) if wrong else "-",
        "bank_wrong": "none" if not sum(wrong[1:]) else str(sum(wrong[1:])),
        "common": next((f"{s.sky.common:.1f}" for s in done.shown if s.sky is not None), "-"),
        "air": " and ".join(f"{air:.1f}" for _, (air, _) in parts) or "-",
        "rest": " and ".join(f"{rest:+.1f}" for _, (_, rest) in parts) or "-",
        "forecast": "-" if free is None else f"{free.whole('forecast') / free.noise:.2f}",
    }


PART = ("part", "rows", "field, uT rms", "attitude", "three faces, deg rms", "rows", "two faces, deg rms", "rows")


def part(s: Shown) -> list[str]:
    seen = [cell for x in (s.sky, s.pair) for cell in (("", "") if x is None else (f"{x.rms:.1f}", str(x.rows)))]
    return [s.flight.name, str(len(s.flight.t)), f"{1e6 * s.calibration.rms:.2f}", s.attitude.verdict(), *seen]


def _ranges(cuts: Sequence[Shown]) -> str:
    """Between which figures they lie."""
    columns = {
        "|B| {} µT rms": [f"{1e6 * s.calibration.rms:.2f}" for s in cuts],
        "three faces {}°": sorted(f"{s.sky.rms:.1f}" for s in cuts if s.sky is not None),
        "two faces {}°": sorted(f"{s.pair.rms:.1f}" for s in cuts if s.pair is not None),
    }
    return ", ".join(what.format(f"{min(v)} to {max(v)}") for what, v in columns.items() if v)
