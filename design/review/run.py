"""A review from a scenario's file to its sections: what is flown, in which order, and what follows.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from orchestration.session.read import read

from . import inputs, manoeuvres, margins, pointing, station, studies, tumbles, verify
from .content import Review, Section
from .facts import Facts, facts
from .flights import fly
from .flights import motion as flown_alone
from .glance import glance
from .options import Options, Tell
from .power import power

FIRST = 2
"""Tumbles of each worker by whose time on this machine the rest is announced."""
OFF, SHORT = 0.3, 60.0
"""Share, and time, s, by which an announced end has to be off before another one is announced."""
LONG = 900.0
"""s: of a longer review the announcement says how fewer are flown."""
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

    Raises InputError, BlockError where a block fails in the flight of the file as it stands, and KeyboardInterrupt
    where a signal ends it: what has been flown stays.
    """
    begun = perf_counter()
    found = facts(file, options.mass)
    source = read(file)
    tracks, why = station.station(found)
    timed = Timed(found, options, len(tracks), announce)

    def told(study: str, of: int) -> Callable[[int], None]:
        def told_of(done: int) -> None:
            timed(study, done)
            tell(study, done, of)

        return told_of

    place = folder / "flights"
    motion = flown_alone(file, f"{tumbles.ORBITS * found.period:.6g} s", place)
    case, rows = tumbles.fly(found, options, folder, told("tumbles", options.runs))
    holds = pointing.flights(found, options, case)
    singles = [*manoeuvres.slews(found), *tracks, *manoeuvres.failing(found)]
    flown = fly(file, holds, place, options.workers, told("holds", len(holds)))
    flown |= fly(file, singles, place, options.workers, told("manoeuvres", len(singles)))
    disturbed, factors = inputs.disturbances(found)
    agility, slew_time = manoeuvres.agility(found, flown)
    tracked, station_error = station.tracking(found, flown, why)
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
        pointing.section(found, options, flown, rows),
        agility,
        tracked,
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
    first = glance(sections, said, math.degrees(found.goal), f"{100 * options.confidence:g}%")
    return Review(found.scenario.name, found.scenario.description, shown, [first, *sections], said)


class Timed:
    """Says how many flights there are, and by the time that they take on this machine how long the rest takes: after
    the first tumbles, and again where the flights since have made it OFF longer or shorter."""

    def __init__(self, found: Facts, options: Options, tracks: int, announce: Callable[[str], None]) -> None:
        holds = sum(pointing.members(options, name) for name in pointing.cases(found))
        fails = len(studies.failures(found)) + 1
        slews = len(manoeuvres.slews(found))
        self._orbits = {
            "tumbles": [tumbles.ORBITS] * options.runs,
            "holds": [pointing.SETTLED + pointing.OBSERVED] * holds,
            "manoeuvres": [1.0] * slews + [station.PASS] * tracks + [manoeuvres.ENDS] * fails,
        }
        """Of each flight, in the order in which they are flown."""
        self._first, self._announce = FIRST * max(options.workers, 1), announce
        self._study, self._began, self._kept = "", 0.0, 0
        self._ends: float | None = None
        self._announce(
            f"{sum(map(len, self._orbits.values())) + 1} flights, "
            f"{sum(map(sum, self._orbits.values())) + tumbles.ORBITS:.0f} orbits, "
            "less what is there"
        )

    def __call__(self, study: str, done: int) -> None:
        """Takes how many flights of a study have been flown."""
        now = perf_counter()
        if study != self._study:
            self._study, self._began, self._kept = study, now, done
        flown = done - self._kept
        if flown < self._first:
            return
        of_this = self._orbits[study]
        later = list(self._orbits)[list(self._orbits).index(study) + 1 :]
        orbits = sum(of_this[done:]) + sum(sum(self._orbits[name]) for name in later)
        left = (now - self._began) / sum(of_this[self._kept : done]) * orbits
        if self._ends is None or abs(left - (self._ends - now)) > max(OFF * (self._ends - now), SHORT):
            fewer = "; smaller --runs and --members fly fewer" if left > LONG else ""
            self._announce(f"about {max(left / 60.0, 1.0):.0f} min more, by the time of the {study} so far{fewer}")
            self._ends = now + left


def _left(found: Facts) -> Section:
    """Returns what was not looked at."""
    notes = list(LIMITS)
    errors = studies.contributors(found)
    missing = [name for name in studies.CONTRIBUTORS if name not in errors and studies.aboard(found, name)]
    if missing:
        notes.append(f"Errors that the file does not state, and that are taken as zero: {', '.join(missing)}.")
    true, law = f"{found.plant}.h_w", found.blocks.get(found.controller)
    if any(str(c.source).startswith(true) and c.target.block == law for c in found.scenario.connections):
        notes.append("Telemetry of the wheels: the controller is given their true momenta.")
    if not math.isfinite(found.satellite.goal or math.inf):
        notes.append("The scenario states no goal of the hold: 5 deg were taken.")
    return Section("What was not looked at", notes=notes)
