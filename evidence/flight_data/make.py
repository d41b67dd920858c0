"""Runs the study on the records of a folder; prints its figures, and draws and writes the page.

Longer than 250 lines: each figure of the study is told in text and on the page, side by side.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from estimator.bank import UNIQUE
from inflight.attitude import STEADY, Attitudes
from inflight.magnetometer import Calibration, calibrate, symmetric
from inflight.orbit import borders
from inflight.records import Flight
from orchestration import InputError

from ..crew import crew
from ..markdown import render
from ..paper import ROOT
from ..plots import BLUE, GREEN, RED, name_axes, panels, save
from . import spins
from .flown import through_the_estimator
from .goals import SKY, goals
from .parts import CUTS, TRIED, cut, known, likelihood
from .records import records
from .study import (
    FIT,
    LONG,
    NOISE,
    Free,
    Shown,
    Sky,
    air_and_rest,
    free_motion,
    long_record,
    pair,
    silent,
    sky,
)

FIGURE = "flight-data"
KNOWN = 30
"""Spins with known answers."""


@dataclass(frozen=True)
class Study:
    """All that the page shows."""

    shown: list[Shown]
    flown: list[Attitudes | None]
    """By the shipped estimator in C, with what the calibrations wrote; None without rows at whole seconds"""
    free: Free | None
    cuts: list[Shown]
    """Parts of each record, calibrated by themselves"""
    likelihoods: list[list[float]]
    """By record, those of its field with each of TRIED"""
    known: list[list[tuple[float, float]]]
    """Spins with known answers, with rates as measured and by parabolas"""
    third: Free | None
    """By every third of the short records"""
    spins: dict[str, list[spins.Case]]
    """By what flew them"""


def study(folder: Path, cases: int, jobs: int, split: bool) -> Study:
    """Runs it; `cases` are synthetic spins, `split` asks for parts of the records, too. Raises InputError."""
    flown, short = records(folder, LONG)
    if not flown and not short:
        raise InputError(f"--data {folder}: expected records with rates and field, found none")
    own = [calibrate(f.t, f.m, np.linalg.norm(f.orbit.field_N(), axis=1), breaks=borders(f.orbit)) for f in flown]
    with crew(jobs) as hands:
        shown = hands.each("records", _long_record, [(flown, own, i) for i in range(len(flown))])
        parts = hands.each("parts of them", cut, [(flight, name) for flight in flown for name in CUTS] if split else [])
        tried = [(flight, s, name) for flight, s in zip(flown, shown, strict=True) for name in TRIED] if split else []
        likely = hands.each("likelihoods", likelihood, tried)
        answers = hands.each("known answers", known, range(KNOWN) if split else [])
    through = [through_the_estimator(s.flight, symmetric(s.calibration), NOISE) for s in shown]
    third = free_motion(short[1::3]) if split else None
    likelihoods = [likely[i : i + len(TRIED)] for i in range(0, len(likely), len(TRIED))]
    return Study(
        shown, through, free_motion(short), parts, likelihoods, answers, third, spun(cases, jobs) if cases else {}
    )


def _long_record(item: tuple[list[Flight], list[Calibration], int]) -> Shown:
    flown, own, i = item
    others = [k for k in range(len(flown)) if k != i]
    return long_record(flown[i], [own[k] for k in others], [flown[k].name for k in others])


def spun(cases: int, jobs: int) -> dict[str, list[spins.Case]]:
    """The synthetic spins, by what flew them."""
    done: dict[str, list[spins.Case]] = {}
    with crew(jobs) as hands:
        for faces, name in zip((0, 3, 6), spins.KINDS, strict=True):
            both = hands.each(name, spins.case, [(number, faces) for number in range(cases)])
            if not faces:
                done["one filter, field and gyro"] = [one for one, _ in both]
            done[f"bank, {name}"] = [bank for _, bank in both]
    return done


def of_spins(done: dict[str, list[spins.Case]]) -> list[str]:
    """What became of them, a line each."""
    out = []
    for name, cases in done.items():
        counts = ", ".join(f"{n} {what}" for what, n in spins.counted(cases).items())
        out.append(f"{len(cases)} spins of {spins.SECONDS:.0f} s, {name}: {counts}")
        if (worst := spins.worst_quiet(cases)) is not None:
            out.append(f"{name}: {np.degrees(worst.off):.0f} deg off, valid, with a mean nis of {worst.nis:.2f} (3)")
    return out


def lines(done: Study) -> list[str]:
    """The figures in text, a line each."""
    of_records = [line for shown in done.shown for line in _of_record(shown)]
    known_ = _of_known(done.known) if done.known else []
    return (
        of_records
        + _of_flown(done)
        + _of_motion(done)
        + known_
        + of_spins(done.spins)
        + goals(done.shown, done.flown, done.free)
    )


def _of_record(s: Shown) -> list[str]:
    name = s.flight.name
    gain = f"gain {s.calibration.gain.min():.3f} to {s.calibration.gain.max():.3f}"
    out = [f"{name}: |B| rms {1e6 * s.calibration.rms:.2f} uT ({1e6 * s.constant:.2f} with a constant gain; {gain})"]
    out += [f"{name}: |B| rms {1e6 * rms:.2f} uT with matrix and bias of {other}" for other, rms in s.crossed.items()]
    turn = np.degrees(0.5 * s.calibration.sigma[[1, 2, 4]].max())
    out.append(f"{name}: axes of the magnetometer turned by {turn:.1f} deg by one deviation of the shear")
    out.append(f"{name}: rates by parabolas over {2 * STEADY:.0f} s leave {np.degrees(s.left):.3f} deg/s rms")
    out.append(
        f"{name}: attitude {s.attitude.verdict()}; gyro off by at most {s.attitude.strain:.1f} deviations of "
        f"what is known before"
    )
    if np.isnan(s.apart):
        out.append(f"{name}: filters back from the last row are unique in no row of these")
    else:
        agree = "agree with" if s.apart < UNIQUE else "DO NOT AGREE with"
        out.append(f"{name}: filters back from the last row {agree} these, {np.degrees(s.apart):.2f} deg rms apart")
    for seen, what in ((s.sky, "three faces"), (s.pair, "two faces, about the third")):
        if seen is not None:
            common = f", {seen.common:.2f} deg of it a turn common to all" if np.isfinite(seen.common) else ""
            out.append(
                f"{name}: withheld sun sensors, {what}: {seen.rms:.2f} deg rms, {seen.median:.2f} median, "
                f"{seen.rows} rows{common}"
            )
    if s.sky is None and s.pair is None:
        out.append(f"{name}: no row whose sun sensors can be compared")
    out += _false(name, s.attitude, s.sky, s.pair)
    if not s.edges:
        out.append(f"{name}: no border of the shadow with currents and a unique attitude around it")
    for edge in s.edges:
        what = "enters the shadow" if edge.entry else "leaves the shadow"
        out.append(
            f"{name}: {what} at {edge.time:.0f} s, by the currents {edge.late:+.1f} s from that, "
            f"{edge.late_air:+.1f} s with air"
        )
    if (parts := air_and_rest(s.edges)) is not None:
        out.append(f"{name}: eclipse, air's part {parts[0]:.1f} s, the rest {parts[1]:+.1f} s")
    return out


def _of_known(found: Sequence[list[tuple[float, float]]]) -> list[str]:
    """What was trusted of the spins with known answers, and how far it was off."""
    out = []
    for what, each in zip(("rates as measured", "rates by parabolas"), np.array(found).transpose(1, 2, 0), strict=True):
        trusted = np.isfinite(each[0])
        rms, worst = np.sqrt(np.mean(each[0, trusted] ** 2)), each[1, trusted].max()
        out.append(f"{what}: trusted in {trusted.sum()} of {len(trusted)}, {rms:.1f}° rms off, {worst:.1f}° at worst")
    return out


def _beyond(done: Study) -> list[str]:
    """The parts of the records whose error on the sky is beyond the goal."""
    out = []
    for s in done.cuts:
        sizes = {"three faces": s.sky, "two faces": s.pair}
        beyond = [f"{what} {x.rms:.1f}° ({x.rows} rows)" for what, x in sizes.items() if x is not None and x.rms > SKY]
        turn = np.degrees(0.5 * s.calibration.sigma[[1, 2, 4]].max())
        known_ = f"one deviation of the shear turns the magnetometer's axes by {turn:.1f}°"
        out += [f"{s.flight.name}: {', '.join(beyond)}; {known_}"] if beyond else []
    return out


def _false(name: str, found: Attitudes, *seen: Sky | None) -> list[str]:
    return [f"{name}: FALSE CONVERGENCE that was not reported"] if silent(found, *seen) else []


def _of_flown(done: Study) -> list[str]:
    out = []
    for s, found in zip(done.shown, done.flown, strict=True):
        name = f"{s.flight.name}: estimator in C"
        if found is None:
            out.append(f"{name}: not flown, its rows are not at whole seconds")
            continue
        seen = (sky(s.flight, found)[0], pair(s.flight, found))
        out.append(f"{name}: attitude {found.verdict()}")
        out += [
            f"{name}, {what}: {each.rms:.2f} deg rms, {each.median:.2f} median, {each.rows} rows"
            for each, what in zip(seen, ("three faces", "two faces"), strict=True)
            if each is not None
        ]
        out += _false(name, found, *seen)
    return out


def _of_motion(done: Study) -> list[str]:
    if done.free is None:
        return ["free motion: fewer than two records that nutate"]
    free = done.free
    ratios, sigma = free.inertia.ratios, free.inertia.ratio_sigma
    degrees = [float(np.degrees(x)) for x in (free.noise, *map(free.whole, ("forecast", "left_out", "constant")))]
    return [
        f"free motion of {len(free.rows)} records: moments as 1: {ratios[0]:.4f} +- {sigma[0]:.4f}, "
        f"{ratios[1]:.3f} +- {sigma[1]:.3f}",
        f"free motion: noise {degrees[0]:.4f} deg/s; forecast from {FIT:.0f} s on {degrees[1]:.4f}, "
        f"{degrees[1] / degrees[0]:.3f} times the noise",
        f"free motion: {degrees[2]:.4f} with the inertia of the other records; {degrees[3]:.4f} for a constant rate",
    ]


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


def make(folder: Path, cases: int, jobs: int, page: bool) -> list[str]:
    """Returns the figures in text, and writes picture and JSON to results/flight_data, or page and picture to docs."""
    return published(study(folder, cases, jobs, page), page)


def published(done: Study, page: bool) -> list[str]:
    """Writes what was found, and returns it in text."""
    told = lines(done)
    out = ROOT / "results" / "flight_data"
    if page:
        save({FIGURE: figure(done)}, ROOT / "docs" / "figures")
        text = render(Path(__file__).parent, **fields(done))
        (ROOT / "docs" / "evidence" / "flight_data.md").write_text(text, "utf-8")
        with (ROOT / "docs" / "evidence" / "flight_data.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([PART, *map(_part, done.cuts)])
        return [*told, "written: docs/evidence/flight_data.md and flight_data.csv"]
    save({FIGURE: figure(done)}, out)
    (out / "figures.json").write_text(json.dumps(told, indent=1), "utf-8")
    return [*told, f"written: {out}"]


def fields(done: Study) -> dict[str, Any]:
    """What the template takes."""
    records_ = [_row(s) for s in done.shown]
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
        "records": records_,
        "fields": [row[:4] for row in records_],
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
        "beyond": str(len(_beyond(done)) or "none"),
        "beyond_lines": _beyond(done),
        "known_lines": _of_known(done.known) if done.known else [],
        "left": " and ".join(f"{np.degrees(s.left):.3f}" for s in done.shown),
        "third": "" if done.third is None else _of_motion(replace(done, free=done.third))[1],
        "motion_lines": _of_motion(done),
        "counts": counts,
        "flown": _of_flown(done),
        "c_three": next((f"{three.rms:.1f}" for three, _ in through if three is not None), "-"),
        "c_two": next((f"{two.rms:.1f}" for _, two in through if two is not None), "-"),
        "one_wrong": str(wrong[0]) if wrong else "-",
        "bank_wrong": "none" if not sum(wrong[1:]) else str(sum(wrong[1:])),
        "common": next((f"{s.sky.common:.1f}" for s in done.shown if s.sky is not None), "-"),
        "air": " and ".join(f"{air:.1f}" for _, (air, _) in parts) or "-",
        "rest": " and ".join(f"{rest:+.1f}" for _, (_, rest) in parts) or "-",
        "forecast": "-" if free is None else f"{free.whole('forecast') / free.noise:.2f}",
    }


def _row(s: Shown) -> list[str]:
    def said(seen: Any) -> str:
        return "-" if seen is None else f"{seen.rms:.1f} ({seen.median:.1f}; {seen.rows})"

    rms = f"{1e6 * s.calibration.rms:.2f}"
    return [
        s.flight.name,
        str(len(s.flight.t)),
        f"{1e6 * s.constant:.2f}",
        rms,
        s.attitude.verdict(),
        said(s.sky),
        said(s.pair),
    ]


PART = ("part", "rows", "field, uT rms", "attitude", "three faces, deg rms", "rows", "two faces, deg rms", "rows")


def _part(s: Shown) -> list[str]:
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
