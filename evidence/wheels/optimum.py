"""Searches the least time of nominal tumbles with sets of wheels, as evidence/optimum does with one, and writes
docs/evidence/wheels_optimum.csv. Tests: tests/evidence/wheels/test_optimum.py."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import asdict

from ..optimum.flown import fly
from ..optimum.make import line_of
from ..optimum.problem import WHEELS as GRID
from ..optimum.search import Optimum, search
from ..optimum.tumbles import Tumbles
from ..paper import FOLDER
from .bound import least_time, plants
from .cases import CONDITIONS, DURATION, WHEELS, Flights, scenario
from .kept import Least, load_least, save_least

RESULTS = FOLDER / "wheels" / "optimum"
"""Of each tumble the motions found, which no change of the controller makes longer."""


def tumbles_of(satellite: str, runs: int) -> Tumbles:
    """The first nominal tumbles of a satellite."""
    flights = Flights(satellite, "nominal")
    data, of_runs = scenario(flights, CONDITIONS["nominal"]), plants(flights, runs)
    return Tumbles(
        data,
        flights.drawn(runs),
        DURATION,
        of_runs.__getitem__,
        lambda run: least_time(of_runs[run]),
        GRID,
        sample=0.5,
        held=False,
    )


def make(cases: int) -> Iterator[str]:
    """Searches what is left of so many tumbles of each satellite, flies them all, and writes the file after each."""
    lines = {(line.satellite, line.run): line for line in load_least()}
    RESULTS.mkdir(parents=True, exist_ok=True)
    of_each = {satellite: tumbles_of(satellite, cases) for satellite in WHEELS}
    for run in range(cases):
        for satellite, tumbles in of_each.items():
            flight = fly(tumbles, run)
            file = RESULTS / f"{satellite.replace(' ', '_')}-{run}.pickle"
            if not file.is_file():
                file.write_bytes(pickle.dumps(search(flight, tumbles.grid)))
            found: Optimum = pickle.loads(file.read_bytes())
            line = line_of(run, tumbles, flight, found)
            if line is None:
                yield f"{satellite}, {run}: no motion that the plant confirms"
                continue
            lines[satellite, run] = Least(**asdict(line), satellite=satellite)
            save_least(lines.values())
            yield f"{satellite}, {run}: best found {line.best_s:.1f} s, flown {line.flown_s:.1f} s"
