"""What the study of the records found, in lines of text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.bank import UNIQUE
from inflight.attitude import STEADY, Attitudes

from . import spins
from .goals import SKY, goals
from .study import FIT, Shown, Sky, air_and_rest, pair, silent, sky
from .whole import Study


def of_spins(done: dict[str, list[spins.Case]]) -> list[str]:
    """Returns what became of them, a line each."""
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
    known = of_known(done.known) if done.known else []
    judged = goals(done.shown, done.flown, done.free)
    return [*of_records, *of_flown(done), *of_motion(done), *known, *of_spins(done.spins), *judged]


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


def of_known(found: Sequence[list[tuple[float, float]]]) -> list[str]:
    """Returns what was trusted of the spins with known answers, and how far it was off."""
    out = []
    for what, each in zip(("rates as measured", "rates by parabolas"), np.array(found).transpose(1, 2, 0), strict=True):
        trusted = np.isfinite(each[0])
        rms, worst = np.sqrt(np.mean(each[0, trusted] ** 2)), each[1, trusted].max()
        out.append(f"{what}: trusted in {trusted.sum()} of {len(trusted)}, {rms:.1f}° rms off, {worst:.1f}° at worst")
    return out


def beyond(done: Study) -> list[str]:
    """The parts of the records whose error on the sky is beyond the goal."""
    out = []
    for s in done.cuts:
        sizes = {"three faces": s.sky, "two faces": s.pair}
        far = [f"{what} {x.rms:.1f}° ({x.rows} rows)" for what, x in sizes.items() if x is not None and x.rms > SKY]
        turn = np.degrees(0.5 * s.calibration.sigma[[1, 2, 4]].max())
        known_ = f"one deviation of the shear turns the magnetometer's axes by {turn:.1f}°"
        out += [f"{s.flight.name}: {', '.join(far)}; {known_}"] if far else []
    return out


def _false(name: str, found: Attitudes, *seen: Sky | None) -> list[str]:
    return [f"{name}: FALSE CONVERGENCE that was not reported"] if silent(found, *seen) else []


def of_flown(done: Study) -> list[str]:
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


def of_motion(done: Study) -> list[str]:
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
