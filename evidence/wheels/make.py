"""Flies the satellites in turn and writes docs/evidence/wheels.md. Tests: tests/evidence/wheels/test_wheels.py."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from orchestration import InputError

from .. import files
from ..crew import complete, runs_of
from ..paper import FOLDER, ROOT
from ..plots import save as save_figures
from . import long, page, slews, telemetry
from .bound import of_draws
from .cases import all_flights
from .kept import FILE, REMEDY, Flown, flown_of, load_least

RESULTS = FOLDER / "wheels"


def make(cases: int, jobs: int, rows: Sequence[str]) -> Iterator[str]:
    """Flies what is left of so many tumbles of each, or of those whose names have one of these texts; then writes
    docs/evidence/wheels.csv. Tells of what was not flown by the FMUs as they are."""
    wanted = [one for one in all_flights() if not rows or any(text in one.name for text in rows)]
    if not wanted:
        raise InputError(f"row: expected a part of one of {', '.join(one.name for one in all_flights())}")
    cases_of = {one: one.case(cases) for one in wanted}
    complete(jobs, cases_of.values(), RESULTS)
    for one, case in cases_of.items():
        if one.case(cases).fingerprint != case.fingerprint:
            yield f"{one.name}: an FMU was built anew while it flew; remedy: the same command again"
    yield from keep()


def keep() -> Iterator[str]:
    """Writes docs/evidence/wheels.csv from the flights that there are of the FMUs as they are; of a kind
    that has none the lines of the file stay, which is told."""
    file = ROOT / "docs" / "evidence" / FILE
    before = files.load_if_any(Flown, file, REMEDY)
    found: list[Flown] = []
    for flights in all_flights():
        rows = runs_of(flights.case(2), RESULTS)
        if rows is not None:
            bounds = of_draws(flights, len(rows)) if flights.condition == "nominal" else []
            found += flown_of(flights, rows, bounds)
            continue
        old = [line for line in before if (line.satellite, line.condition) == (flights.satellite, flights.condition)]
        yield f"{flights.name}: no flights of the FMUs as they are; {len(old)} lines of {FILE} stay"
        found += old
    files.save(Flown, file, found, 4)


def write() -> Path:
    """Writes the page from docs/evidence/wheels.csv."""
    docs = ROOT / "docs" / "evidence"
    found = files.load(Flown, docs / FILE, REMEDY)
    save_figures({"wheels": page.figure(found)}, docs.parent / "figures")
    (docs / "wheels.md").write_text(
        page.text(found, slews.load(), long.load(), telemetry.load(), load_least()), "utf-8"
    )
    return docs / "wheels.md"


def _optimum(cases: int) -> Iterator[str]:
    try:
        from .optimum import make as search  # CasADi, which this part alone needs  # noqa: PLC0415
    except ImportError as error:
        raise InputError(f"{error}; remedy: pip install casadi") from error
    return search(cases)


PARTS: dict[str, Callable[[int, int, Sequence[str]], Iterator[str]]] = {
    "tumbles": make,
    "slews": lambda cases, jobs, rows: slews.make(cases, jobs),
    "long": lambda cases, jobs, rows: long.make(jobs),
    "telemetry": lambda cases, jobs, rows: telemetry.make(cases, jobs),
    "optimum": lambda cases, jobs, rows: _optimum(cases),
}
"""What is flown: so many cases, by so many processes, of these rows. Each tells what it did."""
