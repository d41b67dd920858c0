"""python -m evidence: makes the pages of docs/evidence. Exit statuses are those of `orchestrate`.
Tests: tests/evidence/test_cli.py.

Longer than 250 lines: a command each, with its options.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from orchestration import InputError
from orchestration.cli.console import say
from orchestration.cli.status import Commands

from .allocators import make as allocator_runs
from .allocators import page as allocator_page
from .estimator import bank as estimator_bank
from .estimator import make as estimates
from .failures import make as failures_flown
from .failures.rows import TABLES
from .flight import make as flights
from .flight.rivals import compare
from .flight_data import make as flown_records
from .flight_data.told import of_spins
from .flight_data.whole import spun
from .health import make as health_flown
from .health import stuck_on as health_stuck_on
from .margins import cases as margins_cases
from .margins import make as margins_measured
from .margins import page as margins_page
from .optimum import page as least_times
from .optimum.kept import FILE
from .paper import ROOT
from .processor import make as cost
from .proofs import make as proofs_made
from .proofs import planted as faults
from .proofs import rules as rules_of
from .reproduction import make as paper
from .satellites import bound_search
from .satellites import make as satellites_flown
from .satellites.kept import FILE as SATELLITES
from .satellites.kept import load
from .satellites.searched import BOUNDS
from .sensors import make as sensor_figures
from .single import make as floats
from .verification import page as verified
from .wheels import make as wheels_flown


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Studies of the loop."""


_jobs = click.option("--jobs", default=2, show_default=True, type=click.IntRange(1, 64), help="Processes at work.")
_page = click.option(
    "--page", is_flag=True, help="Write page and figures from what docs/evidence keeps, without flying."
)


def _cases(default: int, least: int, most: int, text: str) -> Callable[..., Any]:
    return click.option("--cases", default=default, show_default=True, type=click.IntRange(least, most), help=text)


@main.command()
def sensors() -> None:
    """Make the figures of docs/use/sensors.md: an eclipse, and the Allan deviation of gyros."""
    say(f"written: {sensor_figures()}")


@main.command()
def verification() -> None:
    """Make docs/evidence/verification.md and its figure from verification.csv, which `make authorities` writes."""
    say(f"written: {verified.write()}")


@main.command()
@_jobs
@click.option("--case", "cases", multiple=True, type=click.Choice(tuple(margins_cases.CASES)), help="Only this hold.")
@_page
@click.option("--anew", is_flag=True, help="Fly again what is kept of the same scenarios and code.")
def margins(jobs: int, cases: tuple[str, ...], page: bool, anew: bool) -> None:
    """Make docs/evidence/margins.md and its figure: margins along the orbit, equilibria, and what loses the hold."""
    if not page:
        margins_measured.make(jobs, cases, anew)
    say(f"written: {margins_page.write()}")


@main.command()
def processor() -> None:
    """Make docs/evidence/processor.md: the flight code on an emulated Cortex-M7, in the loop through the link."""
    say(f"written: {cost.make()}")


@main.command()
@_jobs
def reproduction(jobs: int) -> None:
    """Make docs/evidence/reproduction.md and its figures, all from runs."""
    say(f"written: {paper.make(jobs)}")


@main.command()
@_jobs
@click.option(
    "--fly",
    is_flag=True,
    help="Fly all that docs/evidence/allocators.md shows and keep it in docs/evidence/allocators.csv.",
)
@click.option("--page", is_flag=True, help="Write page and figure from docs/evidence/allocators.csv.")
def allocators(jobs: int, fly: bool, page: bool) -> None:
    """The paper's allocator against the bounded one, under the paper's law at 36 nodes: a minute, with --fly five."""
    if fly or not page:
        done = allocator_runs.compute(allocator_runs.cases() if fly else allocator_runs.comparison(), jobs)
        Console().print(allocator_runs.table(done))
    if fly:
        allocator_runs.save(done)
    if page:
        say(f"written: {allocator_page.write(allocator_runs.load())}")


@main.command()
@_jobs
@_cases(1000, 2, 1000, "Random tumbles of each kind; fewer write to results/.")
@_page
def flight(jobs: int, cases: int, page: bool) -> None:
    """Make docs/evidence/flight.md and its figures from campaigns; one that was interrupted goes on."""
    say(f"written: {flights.publish() if page else flights.make(cases, jobs)}")


@main.command()
@_jobs
@click.option(
    "--runs", default=200, show_default=True, type=click.IntRange(2, 10000), help="Tumbles for the consistency."
)
def estimator(jobs: int, runs: int) -> None:
    """The tables of docs/evidence/estimation.md, and its figures; a minute and a half of a core."""
    for shown in estimates.make(runs, jobs):
        Console().print(shown)


@main.command()
@_cases(50, 1, 1000, "Nominal tumbles, from run 0.")
@click.option("--flown", is_flag=True, help="Fly the tumbles of docs/evidence/optimum.csv anew; their best times stay.")
@_page
def optimum(cases: int, flown: bool, page: bool) -> None:
    """Search the least time of tumbles by optimal control, for docs/evidence/optimum.md: about a minute each,
    one process.

    What is in docs/evidence/optimum.csv is not searched again. Needs the package casadi (pip install casadi).
    """
    if not page:
        if find_spec("casadi") is None:
            raise InputError("the package casadi is not installed; remedy: pip install casadi")
        from .optimum.make import fly_again, make  # CasADi, which this command alone needs  # noqa: PLC0415

        file = ROOT / "docs" / "evidence" / FILE
        for line in fly_again(file) if flown else make(range(cases), file):
            say(line)
    say(f"written: {least_times.publish()}")


@main.command()
@_jobs
@_cases(10, 2, 1000, "Nominal tumbles.")
def rival(jobs: int, cases: int) -> None:
    """Fly a controller from the literature on tumbles of docs/evidence/flight.md beside ours, and print the table of
    docs/evidence/rival.md."""
    for line in compare(cases, jobs):
        say(line)


@main.command("flight-data")
@_jobs
@click.option(
    "--data",
    required=True,
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    help="A folder of records (CSV or Parquet) and element sets (.txt); columns.yaml names other columns.",
)
@_cases(0, 0, 10000, "Synthetic spins, too.")
@click.option(
    "--page", is_flag=True, help="Write docs/evidence/flight_data.md and its figure, not results/flight_data."
)
def flight_data(jobs: int, data: Path, cases: int, page: bool) -> None:
    """Put the models beside the records of a satellite that flew: field, attitude, Sun sensors, shadow, free motion."""
    for line in flown_records.make(data, cases, jobs, page):
        say(line)


@main.command("false-convergence")
@_jobs
@_cases(200, 1, 10000, "Spins of each kind.")
def false_convergence(jobs: int, cases: int) -> None:
    """Fly spins with a wrong gyro scale through the estimator: one filter, and its bank, which reports what it cannot
    tell apart."""
    for line in of_spins(spun(cases, jobs)):
        say(line)


@main.command("bank")
@_jobs
@click.option("--runs", default=24, show_default=True, type=click.IntRange(6, 1000), help="Draws of each campaign.")
def bank(jobs: int, runs: int) -> None:
    """Fly the tumbles of docs/evidence/estimation.md with one filter and with the bank, on the same draws.

    What is flown is kept in results/bank.
    """
    Console(width=160).print(estimator_bank.table(runs, jobs))


@main.command()
@_jobs
@_cases(100, 1, 1000, "Tumbles of each class.")
@_page
@click.option("--bounds", is_flag=True, help="Prove which that are not settled no controller can hold.")
def satellites(jobs: int, cases: int, page: bool, bounds: bool) -> None:
    """Fly satellites from 1U to 500 kg by their data alone, and make docs/evidence/satellites.md.

    One that was interrupted goes on.
    """
    docs = ROOT / "docs" / "evidence"
    if bounds:
        for line in bound_search.make(jobs, load(docs / SATELLITES), docs / BOUNDS):
            say(line)
    say(f"written: {satellites_flown.write() if page or bounds else satellites_flown.make(cases, jobs)}")


@main.command()
@_jobs
@_cases(20, 2, 1000, "Tumbles of each kind.")
@click.option("--row", "rows", multiple=True, help="Fly the kinds whose names have this text alone; may be repeated.")
@click.option(
    "--part",
    default="tumbles",
    show_default=True,
    type=click.Choice(["tumbles", "slews", "long", "telemetry", "optimum"]),
    help="Slews: --cases of each angle. Long: a day at a ground station, 100 orbits of hold. Telemetry: --cases with "
    "three and with four wheels, and as many of wheels that fail. Optimum: the least time of --cases nominal tumbles "
    "of each, some minutes each (pip install casadi).",
)
@_page
def wheels(jobs: int, cases: int, rows: tuple[str, ...], part: str, page: bool) -> None:
    """Fly satellites with three and four wheels, and make docs/evidence/wheels.md; one that was interrupted goes on."""
    for line in () if page else wheels_flown.PARTS[part](cases, jobs, rows):
        say(line)
    say(f"written: {wheels_flown.write()}")


@main.command()
@_jobs
@_cases(10, 1, 1000, "Flights of each row.")
@click.option(
    "--table", "tables", multiple=True, type=click.Choice(TABLES), help="Fly this table alone; may be repeated."
)
@_page
def failures(jobs: int, cases: int, tables: tuple[str, ...], page: bool) -> None:
    """Fly tumbles with rods, sensors and wheels that fail, and make docs/evidence/failures.md; one that was
    interrupted goes on.

    A flight takes about two seconds of a core, one with a stuck wheel 36.
    """
    say(f"written: {failures_flown.write() if page else failures_flown.make(cases, tables or TABLES, jobs)}")


@main.command()
@_jobs
@_cases(1, 1, 1000, "Flights of each row.")
@click.option("--row", "rows", multiple=True, help="Fly the rows whose names have this text alone; may be repeated.")
@_page
def health(jobs: int, cases: int, rows: tuple[str, ...], page: bool) -> None:
    """Fly tumbles behind the estimator in which one part fails, in the tumble or in the hold, and make
    docs/evidence/estimation.md; what was interrupted goes on.

    A flight takes about four seconds of a core, one with a stuck wheel a minute.
    """
    say(f"written: {health_flown.write() if page else health_flown.make(cases, rows, jobs)}")


@main.command()
def stuck_on() -> None:
    """Show what a hold can be at best with a rod stuck on: the least largest angle, by a linear programme (a
    minute)."""
    say(health_stuck_on.make())


@main.command()
@click.argument("names", metavar="[SUBJECT]...", nargs=-1)
def proofs(names: tuple[str, ...]) -> None:
    """Prove the flight code free of run-time errors by Frama-C; all subjects: make docs/evidence/proofs.md."""
    page = proofs_made.make(names)
    say(f"written: {page}" if page else "proved")


@main.command()
def trace() -> None:
    """Write out/trace/trace.html, trace.csv and trace.reqif: requirements, and the code, tests, scenarios and proofs
    that name them.

    Needs the package reqif (pip install reqif).
    """
    if find_spec("reqif") is None:
        raise InputError("the package reqif is not installed; remedy: pip install reqif")
    from .trace.matrix import make  # reqif, which this command alone needs  # noqa: PLC0415

    proofs_made.refuse_stale()
    say(f"written: {make()}")


@main.command()
def rules() -> None:
    """Hold the flight code against MISRA C:2012 (required rules, by cppcheck) and clang-tidy, but for the
    deviations."""
    say(f"{rules_of.check().total()} findings, all as in evidence/proofs/deviations.yaml")


@main.command()
@_cases(100_000, 3, 10_000_000, "Samples of each block.")
def rounding(cases: int) -> None:
    """Bound the rounding errors of controller and allocator, measure them, and make docs/evidence/rounding.md.

    Needs the package python-flint (pip install python-flint).
    """
    if find_spec("flint") is None:
        raise InputError("the package python-flint is not installed; remedy: pip install python-flint")
    from .rounding.make import make  # python-flint, which this command alone needs  # noqa: PLC0415

    say(f"written: {make(cases)}")


@main.command()
@click.option(
    "--sources", type=click.Path(path_type=Path, file_okay=False), help="Only write the C in single precision here."
)
def single(sources: Path | None) -> None:
    """Make docs/evidence/single.md: the flight code in single precision, beside double precision and on an emulated
    Cortex-M4."""
    for path in (floats.make(),) if sources is None else floats.sources(sources):
        say(f"written: {path}")


@main.command()
@click.argument("numbers", metavar="[NUMBER]...", nargs=-1, type=int)
def planted(numbers: tuple[int, ...]) -> None:
    """Plant the faults of tests/evidence/proofs/planted.yaml, one at a time: each has to be found by its proof."""
    faults.make(numbers)


if __name__ == "__main__":
    main(prog_name="python -m evidence")
