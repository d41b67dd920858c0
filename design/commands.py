"""The commands `orchestrate sizing`, `orchestrate momentum-bound` and `orchestrate plausible`, registered in
pyproject.toml.

Exit status: 0 all well; 1 the time asked for is impossible, or sized gains may ask for too much torque; 2 wrong input.
"""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from orchestration import load as load_scenario
from orchestration.cli.console import say
from orchestration.cli.help import examples
from orchestration.cli.options import Between, quantity
from orchestration.cli.overrides import overridden
from orchestration.quantities import SECOND, Unit, parse_unit
from orchestration.session.read import read as read_source

from .gains import setup_of, study, table
from .loop import read
from .momentum import balance
from .plausible import findings

IMPOSSIBLE = 1
_DIPOLE = Unit("A.m2", (0, 2, 0, 1, 0, 0, 0, 0))
_ANGLE, _RATE, _TORQUE = parse_unit("rad"), parse_unit("rad/s"), parse_unit("N.m")


@click.command(
    "momentum-bound",
    epilog=examples(
        "orchestrate momentum-bound scenarios/paper_no_singularity.yaml",
        "orchestrate momentum-bound scenarios/paper_singularity.yaml --time '5 min'",
    ),
)
@click.argument("scenario", type=click.Path(path_type=Path))
@click.option("--time", metavar="T", help="Whether the manoeuvre is possible within this time; in s or with a unit.")
@click.option("--dipole-max", metavar="M", help="Limit of each rod instead of the plant's; in A.m2 or with a unit.")
@click.option("--horizon", default="1 h", show_default=True, metavar="T", help="Longest time that is looked at.")
@click.option("--set", "sets", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="A start value; may be repeated.")
@click.pass_context
def momentum_bound(
    ctx: click.Context, scenario: Path, time: str | None, dipole_max: str | None, horizon: str, sets: tuple[str, ...]
) -> None:
    """Compute a proven lower bound of a manoeuvre's time.

    No controller flies SCENARIO's manoeuvre sooner, by the balance of angular momentum. Exit status 1 where --time is
    impossible."""
    wanted = quantity("--time", time, SECOND)
    limit = quantity("--dipole-max", dipole_max, _DIPOLE)
    longest = quantity("--horizon", horizon, SECOND) or 0.0
    setup = read(overridden(read_source(scenario), sets))
    bound = balance(setup, limit, max(longest, wanted or 0.0))
    times = bound.least_time()
    rods = setup.loop.plant.dipole_max if limit is None else limit
    say(
        f"{setup.scenario.name}: rods of {rods:g} A m2, together at most {bound.rho:.4f} A m2; "
        f"wheel {1e3 * bound.l_max.sum():g} mN m s"
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


@click.command(
    epilog=examples(
        "orchestrate sizing scenarios/paper_no_singularity.yaml --time '193 s'",
        "orchestrate sizing scenarios/paper_no_singularity.yaml --time '10 min' --out gains.yaml",
    )
)
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
@click.option(
    "--damping", type=Between(0.0, min_open=True), help="Damping ratio, instead of the one with the least torque."
)
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
    """Compute gains of `controller` for a wished time to settle.

    FILE is a scenario or a satellite. Prints start values as YAML, and what of them is guaranteed.

    Exit status 1 where the guaranteed torque is above what the actuators give.
    """
    setup = setup_of(overridden(read_source(file), sets))
    found = study(
        setup,
        quantity("--time", time, SECOND) or 0.0,
        quantity("--attitude-error", attitude_error, _ANGLE),
        quantity("--rate", rate, _RATE),
        quantity("--torque", torque, _TORQUE),
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


@click.command(
    epilog=examples(
        "orchestrate plausible scenarios/flight_cubesat.yaml",
        "orchestrate plausible mine/tumble.yaml --mass '4 kg'",
    )
)
@click.argument("scenario", type=click.Path(path_type=Path))
@click.option(
    "--mass", metavar="M", help="Mass of the satellite, to compare with its inertia; default: that of the file."
)
@click.option("--set", "sets", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="A start value; may be repeated.")
@click.pass_context
def plausible(ctx: click.Context, scenario: Path, mass: str | None, sets: tuple[str, ...]) -> None:
    """Compare a satellite's values with each other.

    Nothing is flown.

    Each finding has its number, the bound and what to change. None is an error: what is meant can be flown. Exit status
    1 where there is a finding.
    """
    loaded = load_scenario(overridden(read_source(scenario), sets))
    found = findings(loaded, quantity("--mass", mass, parse_unit("kg")))
    for finding in found:
        say(f"{finding}")
    say(f"{loaded.name}: {len(found) or 'no'} finding{'s' if len(found) != 1 else ''}", bold=True)
    if found:
        ctx.exit(1)
