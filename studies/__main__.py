"""python -m studies: the momentum bound and the gains of a scenario, and the pages that studies write to docs/.

Exit status: 0 all well; 1 the time asked for is impossible, or sized gains may ask for too much torque; 2 the input is wrong; others as of `orchestrate`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from orchestration import InputError
from orchestration.cli.console import say
from orchestration.cli.overrides import overridden
from orchestration.cli.status import Commands
from orchestration.quantities import SECOND, QuantityError, Unit, parse_unit, value_in
from orchestration.runner.read import read as read_source

from .allocators import make as allocator_runs
from .allocators import page as allocator_page
from .estimator import make as estimates
from .flight import make as flights
from .flight.tune import search
from .momentum_bound import balance
from .processor import make as cost
from .reproduction import make as paper
from .satellites import make as satellites_flown
from .sensors import make as sensor_figures
from .setup import read
from .sizing import setup_of, study, table

IMPOSSIBLE = 1
_DIPOLE = Unit("A.m2", (0, 2, 0, 1, 0, 0, 0, 0))
_ANGLE, _RATE, _TORQUE = parse_unit("rad"), parse_unit("rad/s"), parse_unit("N.m")


@click.group(cls=Commands)
def main() -> None:
    """Studies of the loop."""


def _jobs(command: Callable[..., Any]) -> Callable[..., Any]:
    return click.option("--jobs", default=2, show_default=True, type=click.IntRange(1, 64), help="Processes at work.")(
        command
    )


def _quantity(option: str, text: str | None, unit: Unit) -> float | None:
    """A positive number of an option, or None where it is not given."""
    if text is None:
        return None
    try:
        number: Any = text
        with contextlib.suppress(ValueError):
            number = float(text)
        value = value_in(number, unit)
    except QuantityError as error:
        raise InputError(f"{option} {text}: {error}") from None
    if not 0.0 < value < float("inf"):
        raise InputError(f"{option} {text}: expected above zero, found {value:g} {unit.name}")
    return value


@main.command("momentum-bound")
@click.argument("scenario", type=click.Path(path_type=Path))
@click.option("--time", metavar="T", help="Whether the manoeuvre is possible within this time; in s or with a unit.")
@click.option("--dipole-max", metavar="M", help="Limit of each rod instead of the plant's; in A.m2 or with a unit.")
@click.option("--horizon", default="1 h", show_default=True, metavar="T", help="Longest time that is looked at.")
@click.option("--set", "sets", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="A start value; may be repeated.")
@click.pass_context
def momentum_bound(
    ctx: click.Context, scenario: Path, time: str | None, dipole_max: str | None, horizon: str, sets: tuple[str, ...]
) -> None:
    """The least time that the balance of angular momentum allows SCENARIO's manoeuvre: a proven lower bound."""
    wanted = _quantity("--time", time, SECOND)
    limit = _quantity("--dipole-max", dipole_max, _DIPOLE)
    longest = _quantity("--horizon", horizon, SECOND) or 0.0
    setup = read(overridden(read_source(scenario), sets))
    bound = balance(setup, limit, max(longest, wanted or 0.0))
    times = bound.least_time()
    rods = setup.loop.plant.dipole_max if limit is None else limit
    say(
        f"{setup.scenario.name}: rods of {rods:g} A m2, together at most {bound.rho:.4f} A m2; wheel {1e3 * bound.l_max:g} mN m s"
    )
    say(f"initial momentum {bound.H0_size:.4f} N m s")
    for what, least in (("least time", times.least), ("  along the momentum alone", times.simple)):
        say(f"{what}: " + (f"beyond {times.horizon:g} s" if least is None else f"{least:.1f} s"), bold=what[0] == "l")
    if wanted is None:
        return
    v = bound.at(wanted)
    if v.possible:
        say(f"within {wanted:g} s: not excluded")
        return
    direction = ", ".join(f"{x:.5f}" for x in v.direction)
    say(f"within {wanted:g} s: impossible, {v.gap:.4f} N m s are short", bold=True)
    say(f"  along the inertial direction ({direction})")
    say(f"  needed beyond what the wheel can keep {v.needed:.4f} N m s")
    say(f"  largest impulse of the rods           {v.impulse:.4f}")
    say(f"  disturbances and tolerances           {v.slack:.4f}")
    ctx.exit(IMPOSSIBLE)


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--time", required=True, metavar="T", help="Wished time to settle; in s or with a unit.")
@click.option(
    "--attitude-error", metavar="A", help="Largest initial error, by default the scenario's; in rad or with a unit."
)
@click.option(
    "--rate", metavar="W", help="Largest initial rate error, by default the scenario's; in rad/s or with a unit."
)
@click.option(
    "--torque",
    metavar="T",
    help="Torque that the actuators give, instead of what rods and wheel give; in N.m or with a unit.",
)
@click.option("--damping", type=float, help="Damping ratio, instead of the one with the least torque.")
@click.option(
    "--schedule",
    type=click.Choice(["constant", "error"]),
    default="constant",
    show_default=True,
    help="Gains that are constant, or follow the errors [10].",
)
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write the start values to this file.")
@click.option("--set", "sets", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="A start value; may be repeated.")
@click.pass_context
def sizing(
    ctx: click.Context,
    file: Path,
    time: str,
    attitude_error: str | None,
    rate: str | None,
    torque: str | None,
    damping: float | None,
    schedule: str,
    out: Path | None,
    sets: tuple[str, ...],
) -> None:
    """Gains of `controller` for FILE, a scenario or a satellite: start values as YAML, and what of them is guaranteed.

    Exit status 1 where the guaranteed torque is above what the actuators give.
    """
    setup = setup_of(overridden(read_source(file), sets))
    found = study(
        setup,
        _quantity("--time", time, SECOND) or 0.0,
        _quantity("--attitude-error", attitude_error, _ANGLE),
        _quantity("--rate", rate, _RATE),
        _quantity("--torque", torque, _TORQUE),
        damping,
        schedule,
    )
    shown = Table("", "value", "formula", "standing")
    for row in table(found, found.fly(setup.loop.controller)):
        shown.add_row(*row)
    Console(stderr=True).print(shown)
    text = found.yaml()
    if out is None:
        click.echo(text, nl=False)
    else:
        out.write_text(text, "utf-8")
        say(f"written: {out}")
    if found.sizing.torque_max > found.sizing.wish.torque:
        ctx.exit(IMPOSSIBLE)


@main.command()
def sensors() -> None:
    """Make the figures of docs/sensors.md: an eclipse, and the Allan deviation of gyros."""
    say(f"written: {sensor_figures()}")


@main.command()
def processor() -> None:
    """Make docs/processor.md: the flight code on an emulated Cortex-M7, in the loop through the link."""
    say(f"written: {cost.make()}")


@main.command()
@_jobs
def reproduction(jobs: int) -> None:
    """Make docs/reproduction.md and its figures, all from runs."""
    say(f"written: {paper.make(jobs)}")


@main.command()
@_jobs
@click.option("--fly", is_flag=True, help="Fly all that docs/allocators.md shows and keep it in docs/allocators.csv.")
@click.option("--page", is_flag=True, help="Write docs/allocators.md and its figure from docs/allocators.csv.")
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
@click.option(
    "--cases",
    default=1000,
    show_default=True,
    type=click.IntRange(2, 1000),
    help="Random tumbles of each kind; fewer write to results/.",
)
@click.option("--page", is_flag=True, help="Write page and figures from docs/flight.csv, without flying its cases.")
def flight(jobs: int, cases: int, page: bool) -> None:
    """Make docs/flight.md and its figures from campaigns; one that was interrupted goes on."""
    say(f"written: {flights.publish() if page else flights.make(cases, jobs)}")


@main.command()
@_jobs
@click.option(
    "--runs", default=200, show_default=True, type=click.IntRange(2, 10000), help="Tumbles for the consistency."
)
def estimator(jobs: int, runs: int) -> None:
    """The tables of docs/estimation.md, and its figures; half a minute. Needs the package ahrs (pip install ahrs)."""
    for shown in estimates.make(runs, jobs):
        Console().print(shown)


@main.command("flight-case")
@click.argument("group")
@click.argument("run", type=int)
def flight_case(group: str, run: int) -> None:
    """Fly one case of docs/flight.md, such as nominal 17, and write its scenario."""
    flown = flights.fly_case(group, run)
    for name, value in flown.metrics.items():
        say(f"{name:14} {value}")
    say(f"written: {flown.file}")


@main.command("flight-tune")
@_jobs
def flight_tune(jobs: int) -> None:
    """Search the gains of law [8] in SI units that docs/flight.md compares with."""
    for line in search(jobs):
        say(line)


@main.command()
@_jobs
@click.option("--cases", default=100, show_default=True, type=click.IntRange(1, 1000), help="Tumbles of each class.")
def satellites(jobs: int, cases: int) -> None:
    """Fly tumbles of satellites from 1U to 500 kg by their data alone, and print the table of docs/satellites.md."""
    for line in satellites_flown.lines(cases, jobs):
        say(line)


if __name__ == "__main__":
    main(prog_name="python -m studies")
