"""`orchestrate margins`: measures the stability margins of a loop. Tests: tests/orchestration/cli/test_margins.py."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from ..errors import InputError, Place, Problem, writing
from ..margins.block import closed, linearized
from ..margins.floquet import SEGMENT, coordinates
from ..margins.inject import Rig
from ..margins.linear import realized
from ..margins.measure import LONGEST, measure
from ..margins.report import HEADER, Found
from ..margins.search import Change, expectations_are_met, lost, pulse_dies_out, scaled
from ..margins.site import site
from ..quantities import SECOND, QuantityError, value_in
from ..results.place import check_writable, refuse_links
from ..scenario.text import parse
from ..session.open import open_scenario
from ..session.session import Session
from .console import complain, notes, say, say_json, say_table
from .help import examples
from .linear import data_of, save, tell_model, told_of_loop
from .options import changes, out_folder
from .overrides import Changes
from .paths import PATH
from .repeated import followed, multipliers, samples_of
from .status import EXPECTATION_FAILED
from .watch import watched

LEAST = 16
"""Samples of a window, at least."""


@click.command(
    "margins",
    epilog=examples(
        "orchestrate margins loop.yaml --at allocator.tau_cmd_B",
        "orchestrate margins loop.yaml --at plant.wheel_torque_cmd --when '3000 s' --out results/margins",
        "orchestrate margins loop.yaml --at plant.wheel_torque_cmd --change delay=0..20 --change plant.J_B=1..5",
        "orchestrate margins loop.yaml --model plant --state plant.R_NB --state plant.omega_B",
    ),
)
@click.argument("scenario", type=PATH)
@changes("swaps", "maps", "sets", "step", "flavour")
@click.option("--at", "ports", multiple=True, metavar="BLOCK.PORT", help="Where the loop is opened.")
@click.option("--model", metavar="BLOCK", help="Give the linear model of this block instead of margins.")
@click.option("--when", metavar="T", help="When the injection begins; default: the scenario's duration.")
@click.option("--window", metavar="T", help="Longest time that is looked at after a pulse.")
@click.option(
    "--change",
    "changed",
    multiple=True,
    metavar="NAME=FROM..TO",
    help="Seek the least change that loses the loop: gain, delay (s), or a factor on block.parameter; may be repeated.",
)
@click.option(
    "--lost",
    "criterion",
    type=click.Choice(["pulse", "expectations"]),
    default="pulse",
    show_default=True,
    help="Lost is a loop in which a pulse grows, or whose expectations fail.",
)
@click.option("--orbit", metavar="T", help="Period of the motion: gives Floquet multipliers instead of margins.")
@click.option("--piece", metavar="T", help="Length of a piece of the period; for --orbit; default: 200 samples.")
@click.option(
    "--periods",
    type=click.IntRange(2, 1000),
    help="Follow the answers to pulses over so many periods; for --orbit and controllers with hidden states.",
)
@click.option(
    "--state",
    "states",
    multiple=True,
    metavar="BLOCK.PORT",
    help="An output that is the state; for --orbit and --model, else for a linear model of the closed loop.",
)
@click.option(
    "--sensitivity",
    "sensitive",
    multiple=True,
    metavar="BLOCK.PARAMETER",
    help="How the decay over a period depends on this; for --orbit.",
)
@out_folder("Folder for table, plot and data; default: results/NAME-margins.")
@click.option("--json", "json_", is_flag=True, help="Print the result as JSON.")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    ports: tuple[str, ...],
    model: str | None,
    when: str | None,
    window: str | None,
    changed: tuple[str, ...],
    criterion: str,
    orbit: str | None,
    piece: str | None,
    periods: int | None,
    states: tuple[str, ...],
    sensitive: tuple[str, ...],
    out: Path | None,
    json_: bool,
) -> None:
    """Measure the stability margins of a loop.

    Or its Floquet multipliers (--orbit), or the linear model of a block (--model).

    Small pulses are added to the signal at BLOCK.PORT, an input (for it alone) or an output (for all that it feeds),
    and what comes back is compared with a flight without them. Gives gain, phase, delay and disk margins of each
    element with the others closed, and the disk margin of all at once. --at may be repeated.

    Exit status: 0 measured, 1 the loop has no margins there (with the reason), 2 wrong input, 3 an FMU failed.
    """
    if not ports and model is None:
        raise InputError(Problem(expected="--at BLOCK.PORT or --model BLOCK", found="none"))
    lost_ = criterion if criterion != "pulse" else None
    given: dict[str, object] = {
        "--at": ports,
        "--change": changed,
        "--orbit": orbit,
        "--lost": lost_,
        "--window": window,
    }
    given |= {"--sensitivity": sensitive, "--piece": piece, "--periods": periods}
    _refuse_idle([name for name, value in given.items() if value], model is not None, orbit is not None)
    loaded = change.scenario(scenario)
    target = out or Path("results") / f"{loaded.name}-margins"
    check_writable(target)
    refuse_links(target)
    ctx.with_resource(watched(loaded, lost="nothing is written"))
    with Session(open_scenario(loaded)) as session:
        plan = session.opened.plan
        begin = seconds("--when", when, loaded.duration)
        if model is not None:
            longest = None if window is None else seconds("--window", window, 0.0)
            found_ = linearized(session, model, round(begin / plan.clock.step), states, longest)
            ctx.exit(tell_model(found_, begin, target, json_))
        rig = Rig(session, site(plan, ports), max(round(begin / plan.clock.step), 1))  # nothing is taken before a step
        changes_, seen = [Change.of(text) for text in changed], coordinates(plan, states)
        for option, names in (("--change", [one.name for one in changes_]), ("--sensitivity", sensitive)):
            for name in names:
                if option == "--sensitivity" or name not in ("gain", "delay"):
                    scaled(rig, name, 1.0, option)  # it is refused before anything is flown
        if orbit is not None:
            pieces = max(round(seconds("--piece", piece, SEGMENT * rig.period) / rig.period), 1)
            period = samples_of(rig, seconds("--orbit", orbit, 0.0), states)
            if periods is None:
                ctx.exit(multipliers(rig, period, pieces, seen, sensitive, changes_, json_))
            ctx.exit(followed(rig, period, periods, pieces, seen, sensitive, changes_, json_))
        longest = seconds("--window", window, LONGEST * rig.period)
        if longest < LEAST * rig.period:
            expected = f"at least {LEAST} samples, {LEAST * rig.period:g} s"
            raise InputError(Problem(expected=expected, found=f"{longest:g} s", place=Place("--window")))
        found = Found.of(loaded.name, rig.first * plan.clock.step, measure(rig, int(longest / rig.period)))
        looped = None
        if not found.response.refused:
            samples = len(found.response.pulse)
            dies = pulse_dies_out(rig, 3 * samples // 2, found.response.amplitude)
            holds = dies if criterion == "pulse" else expectations_are_met(rig)
            found.searched.extend(lost(rig, one, holds) for one in changes_)
            looped = closed(rig, seen, samples) if states else None
    if not found.response.refused:
        _write(found, target)
        if looped is not None and not looped.refused:
            save(looped.model, target, "loop")
    if json_:
        said = {} if looped is None else {"loop": data_of(looped)}
        say_json({**found.data(), **said})
    else:
        _print(found, target)
        if looped is not None:
            notes(looped.notes)
            say(
                f"Closed loop: no linear model: {looped.refused}"
                if looped.refused
                else told_of_loop(looped.model, "loop")
            )
    ctx.exit(EXPECTATION_FAILED if found.response.refused else 0)


def seconds(option: str, text: str | None, default: float) -> float:
    """Returns the time of an option, which is not negative. Raises InputError."""
    if text is None:
        return default
    place = Place(f"{option} {text}")
    try:
        value = value_in(parse(text, f"{option} {text}").data, SECOND)
    except QuantityError as error:
        raise InputError(Problem(str(error), place=place)) from None
    if not 0.0 <= value < 1e9:
        raise InputError(Problem(expected="a time of 0 s to 1e9 s", found=text, place=place))
    return value


def _refuse_idle(given: Sequence[str], model: bool, orbit: bool) -> None:
    """Raises InputError for an option that would have no effect beside the others."""
    for name in given:
        if model and name != "--window":
            raise InputError(Problem(f"{name} has no effect with --model; remedy: leave out one of them"))
        if name in ("--sensitivity", "--piece", "--periods") and not orbit:
            raise InputError(Problem(f"{name} has an effect with --orbit only; remedy: state the period by --orbit"))
        if name in ("--window", "--lost") and orbit:
            raise InputError(Problem(f"{name} has no effect with --orbit; remedy: leave out one of them"))


def _write(found: Found, folder: Path) -> None:
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "margins.json").write_text(json.dumps(found.data(), indent=2) + "\n", "utf-8")
        found.figure().savefig(folder / "margins.png", dpi=120)
    found.save_table(folder / "response.csv")
    save(realized(found.response), folder)


def _print(found: Found, folder: Path) -> None:
    response = found.response
    notes(response.warnings)
    if response.refused:
        complain(f"no margins: {response.refused}")
        return
    say(f"{found.name}: loop opened at {', '.join(response.labels)} from {found.when:g} s", bold=True)
    say_table(HEADER, found.rows())
    for line in found.lines():
        say(line)
    low, high, error = response.omega[0], response.omega[-1], 100 * response.error.max()
    say(
        f"{response.flights} flights, {low:.3g} to {high:.3g} rad/s, response within {error:.2g} %; written to {folder}"
    )
