"""A review from a scenario's file to its sections: what is flown, in which order, and what follows.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter, process_time

from orchestration import InputError
from orchestration.scenario.source import Source
from orchestration.session.read import load, read
from orchestration.session.run import whole

from . import inputs, manoeuvres, margins, pointing, studies, tumbles, verify
from .content import Review, Section
from .facts import Facts, facts
from .flights import fly
from .flights import motion as flown_alone
from .options import Options, Tell
from .power import power

SAMPLE, SAMPLE_RODS = 0.4, 1.0
"""Orbits of the file's own tumble that are flown to see how fast it is; by rods alone plans are searched all along."""
LIMITS = [
    "Flexible parts, sloshing, moving panels and appendages: the body is rigid.",
    "Failures of two parts at once, failures that come and go, the computer, the radio and the power supply.",
    "Jitter faster than the step of the scenario, wheels' imbalance and their friction unless the file states it.",
    "Alignment of an instrument to the body, thermal distortion, and mounting that the file does not state.",
    "Orbits other than the one of the file, and what changes over the years: air, fuel, wear, ageing of sensors.",
    "Delays of rods and wheels, delays of sensors, and the run time of the flight software.",
    "The ground segment, the sequence of commissioning, and what an operator does.",
]


def review(
    file: Path, folder: Path, options: Options, tell: Tell, announce: Callable[[str], None] = lambda text: None
) -> Review:
    """Flies what is left of a review and returns it; the tables and the page are for the caller to write.

    Raises InputError, and KeyboardInterrupt where a signal ends it: what has been flown stays.
    """
    begun = perf_counter()
    found = facts(file, options.mass)
    source = read(file)
    tracks, why = manoeuvres.station(found)
    announce(_planned(found, options, len(tracks), speed(found, source)))
    case, rows = tumbles.fly(found, options, folder, lambda done: tell("tumbles", done, options.runs))
    place = folder / "flights"
    holds = pointing.flights(found, options, case)
    singles = [*manoeuvres.slews(found), *tracks, *manoeuvres.failing(found)]
    flown = fly(file, holds, place, options.workers, lambda done: tell("holds", done, len(holds)))
    flown |= fly(file, singles, place, options.workers, lambda done: tell("manoeuvres", done, len(singles)))
    motion = flown_alone(file, f"{tumbles.ORBITS * found.period:.6g} s", place)
    disturbed, factors = inputs.disturbances(found)
    agility, slew_time = manoeuvres.agility(found, flown)
    station, station_error = manoeuvres.tracking(found, flown, why)
    failures, after_failure = manoeuvres.failures(found, flown)
    single = {
        "slew_time": slew_time,
        "station_error": station_error,
        "error_after_failure": after_failure,
        **{name: (value, "") for name, value in factors.items()},
    }
    required, said = verify.section(options, rows, single, tumbles.last_moment(found))
    sections = [
        inputs.data(found),
        disturbed,
        replace(tumbles.section(found, options, case, rows), motion=motion),
        pointing.section(found, options, flown),
        agility,
        station,
        failures,
        margins.section(found, source),
        power(found, options, flown),
        required,
        _left(found),
    ]
    runs = options.runs + len(holds) + len(singles) + 1
    shown = {
        "flights": f"{runs}, seed {options.seed}",
        "confidence": f"{100 * options.confidence:g}%",
        "windows": f"{options.window:g} s, {options.drift:g} s apart",
        "wall time of this start": f"{perf_counter() - begun:.0f} s",
        "finished": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }
    return Review(found.scenario.name, found.scenario.description, shown, sections, said)


def speed(found: Facts, source: Source) -> float:
    """Returns how many steps a second a processor flies of the file's own tumble, whatever else it does.

    Raises InputError where the tumble has no first sample.
    """
    source = source.without([(name,) for name in ("record", "expect", "figures", "live", "timeline", "faults")])
    duration = (SAMPLE if found.wheels else SAMPLE_RODS) * found.period
    for seconds in (min(60.0, duration), duration):  # the first loads
        scenario = load(source.with_value("duration", f"{seconds:.6g} s", "review"))
        begun = process_time()
        flown = whole(scenario)
        if flown.failure is not None and not len(flown.time):
            raise InputError(f"{found.file}: {flown.failure}")
    return float(flown.time[-1]) / scenario.step / max(process_time() - begun, 1e-3)


def _planned(found: Facts, options: Options, tracks: int, steps: float) -> str:
    """Returns how many flights there are, and about how long they take."""
    holds = sum(pointing.members(options, name) for name in pointing.cases(found))
    fails = len(studies.failures(found)) + 1
    slews = len(manoeuvres.slews(found))
    orbits = tumbles.ORBITS * (options.runs + 1) + (pointing.SETTLED + pointing.OBSERVED) * holds
    orbits += manoeuvres.ENDS * fails + slews + manoeuvres.PASS * tracks
    minutes = orbits * found.period / found.scenario.step / steps / max(options.workers, 1) / 60.0
    flights = options.runs + holds + fails + slews + tracks + 1
    return (
        f"{flights} flights, {orbits:.0f} orbits: about {max(minutes, 1):.0f} min on "
        f"{max(options.workers, 1)} free cores at {steps:,.0f} steps a second, less what has been flown"
    )


def _left(found: Facts) -> Section:
    """Returns what was not looked at."""
    notes = list(LIMITS)
    errors = studies.contributors(found)
    missing = [name for name in studies.CONTRIBUTORS if name not in errors]
    if missing:
        notes.append(f"Errors that the file does not state, and that are taken as zero: {', '.join(missing)}.")
    if not math.isfinite(found.satellite.goal or math.inf):
        notes.append("The scenario states no goal of the hold: 5 deg were taken.")
    return Section("What was not looked at", notes=notes)
