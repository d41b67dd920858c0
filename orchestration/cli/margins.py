"""`orchestrate margins`: measures the stability margins of a loop. Tests: tests/orchestration/cli/test_margins.py.

Longer than 250 lines: one command with its options, and what it writes and prints of each measure.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from ..errors import InputError, Place, Problem, writing
from ..margins.block import BlockModel, closed, linearized
from ..margins.floquet import PULSE, SEGMENT, Coordinates, Repeated, coordinates
from ..margins.inject import Altered, Rig
from ..margins.linear import Linear, realized
from ..margins.measure import LONGEST, measure
from ..margins.periods import Followed, follow
from ..margins.report import HEADER, Found
from ..margins.search import Change, Slope, Starts, expectations_are_met, lost, pulse_dies_out, scaled
from ..margins.site import site
from ..quantities import SECOND, QuantityError, value_in
from ..results.place import check_writable, refuse_links
from ..scenario.text import parse
from ..session.open import open_scenario
from ..session.session import Session
from .console import complain, notes, say, say_json, say_table
from .help import examples
from .options import changes, out_folder
from .overrides import Changes
from .paths import PATH
from .status import EXPECTATION_FAILED

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
    with Session(open_scenario(loaded)) as session:
        plan = session.opened.plan
        begin = seconds("--when", when, loaded.duration)
        if model is not None:
            longest = None if window is None else seconds("--window", window, 0.0)
            found_ = linearized(session, model, round(begin / plan.clock.step), states, longest)
            ctx.exit(_model(found_, begin, target, json_))
        rig = Rig(session, site(plan, ports), max(round(begin / plan.clock.step), 1))  # nothing is taken before a step
        changes_, seen = [Change.of(text) for text in changed], coordinates(plan, states)
        for option, names in (("--change", [one.name for one in changes_]), ("--sensitivity", sensitive)):
            for name in names:
                if option == "--sensitivity" or name not in ("gain", "delay"):
                    scaled(rig, name, 1.0, option)  # it is refused before anything is flown
        if orbit is not None:
            pieces = max(round(seconds("--piece", piece, SEGMENT * rig.period) / rig.period), 1)
            period = _period(rig, seconds("--orbit", orbit, 0.0), states)
            if periods is None:
                ctx.exit(_multipliers(rig, period, pieces, seen, sensitive, changes_, json_))
            ctx.exit(_followed(rig, period, periods, pieces, seen, sensitive, changes_, json_))
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
            _save(looped.model, target, "loop")
    if json_:
        said = {} if looped is None else {"loop": _data(looped)}
        say_json({**found.data(), **said})
    else:
        _print(found, target)
        if looped is not None:
            notes(looped.notes)
            say(f"Closed loop: no linear model: {looped.refused}" if looped.refused else _told(looped.model, "loop"))
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


def _model(found: BlockModel, when: float, folder: Path, json_: bool) -> int:
    """Writes and prints the linear model of a block; the status is 1 where it has none."""
    model = found.model
    if json_:
        say_json(_data(found))
    else:
        notes(found.notes)
    if found.refused:
        complain(f"no linear model: {found.refused}")
        return EXPECTATION_FAILED
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    _save(model, folder)
    if not json_:
        sizes = f"{len(model.inputs)} inputs, {len(model.outputs)} outputs, {len(model.A)} states"
        say(f"linear model at {when:g} s, each {model.step:g} s: {sizes}", bold=True)
        if model.states:
            say(f"states: {', '.join(model.states)}")
            say("eigenvalues of A: " + ", ".join(f"{value:.6g}" for value in model.eigenvalues))
        say(model.verdict)
        say(f"written to {folder / 'model.npz'} and model.mat")
    return 0


def _data(found: BlockModel) -> dict[str, Any]:
    model = found.model
    matrices = {name: getattr(model, name).tolist() for name in "ABCD"}
    names = {"inputs": model.inputs, "outputs": model.outputs, "states": model.states}
    said = {"sample": model.step, "error": model.error, "verdict": model.verdict, "notes": found.notes}
    return {**names, **matrices, **said, "refused": found.refused or None}


def _told(model: Linear, name: str) -> str:
    """Returns what is told of the closed loop."""
    sizes = ", ".join(f"{abs(value):.6g}" for value in model.eigenvalues)
    return f"Closed loop from sample to sample, |eigenvalues| {sizes}; {model.verdict}; written to {name}.npz and .mat"


def _save(model: Linear, folder: Path, name: str = "model") -> None:
    for suffix in ("npz", "mat"):
        model.save(folder / f"{name}.{suffix}")


def _refuse_idle(given: Sequence[str], model: bool, orbit: bool) -> None:
    """Raises InputError for an option that would have no effect beside the others."""
    for name in given:
        if model and name != "--window":
            raise InputError(Problem(f"{name} has no effect with --model; remedy: leave out one of them"))
        if name in ("--sensitivity", "--piece", "--periods") and not orbit:
            raise InputError(Problem(f"{name} has an effect with --orbit only; remedy: state the period by --orbit"))
        if name in ("--window", "--lost") and orbit:
            raise InputError(Problem(f"{name} has no effect with --orbit; remedy: leave out one of them"))


def _period(rig: Rig, period: float, states: Sequence[str]) -> int:
    """Returns the samples of a period. Raises InputError."""
    samples = round(period / rig.period)
    if not states or samples < 2:
        expected = "--state BLOCK.PORT with --orbit" if not states else "a period of some samples"
        found = "none" if not states else f"{period:g} s"
        raise InputError(Problem(expected=expected, found=found, place=Place("--orbit")))
    return samples


def _followed(
    rig: Rig,
    period: int,
    periods: int,
    piece: int,
    seen: Coordinates,
    names: Sequence[str],
    changes_: Sequence[Change],
    json_: bool,
) -> int:
    """Prints what is left of disturbances from period to period; the status is 1 where the loop is not linear."""

    def flown(altered: Altered, starts: Starts) -> Followed:
        return follow(rig, seen, period, periods, piece, altered, starts)

    def holds(altered: Altered, starts: Starts) -> bool:
        found = flown(altered, starts)
        return not found.refused and found.left < 1.0

    def log(starts: Starts) -> float:
        changed = follow(rig, seen, period, periods, piece, starts=starts, sizes=(found.size,))
        return math.log(changed.decay) if changed.repeats == found.repeats else math.nan

    found = flown(Altered(), None)
    slopes = {name: Slope.of(rig, name, math.log(found.decay), log) for name in names if not found.refused}
    searched = [lost(rig, one, holds) for one in changes_ if not found.refused]
    if json_:
        windows = [
            {"ratio": one.ratio, "most": one.most, "least": one.least, "error": one.error, "rest": one.rest}
            for one in found.windows
        ]
        said = {"period": period * rig.period, "windows": windows, "refused": found.refused or None}
        say_json({**said, **_slopes(slopes), "searched": [one.data() for one in searched]})
        return EXPECTATION_FAILED if found.refused else 0
    if found.refused:
        complain(f"no number: {found.refused}")
        return EXPECTATION_FAILED
    say(f"Answers to pulses over periods of {period * rig.period:g} s, of {', '.join(found.labels)}:", bold=True)
    what = "the largest multiplier" if found.repeats else "what is left after the last period"
    for line in [*found.lines(), *(slope.line(name, what) for name, slope in slopes.items()), *map(str, searched)]:
        say(line)
    return 0


def _slopes(slopes: Mapping[str, Slope]) -> dict[str, dict[str, float | None]]:
    """Returns sensitivities for JSON, and by how much they differ upwards and downwards."""
    parts = {"sensitivity": "value", "sensitivity_error": "apart"}
    of = {key: {name: getattr(slope, part) for name, slope in slopes.items()} for key, part in parts.items()}
    return {key: {name: None if math.isnan(v) else v for name, v in values.items()} for key, values in of.items()}


def _multipliers(
    rig: Rig,
    samples: int,
    piece: int,
    seen: Coordinates,
    names: Sequence[str],
    changes_: Sequence[Change],
    json_: bool,
) -> int:
    """Prints the Floquet multipliers; the status is 1 where the state is not seen."""
    repeated = Repeated.of(rig, seen, samples, PULSE * rig.scales, piece)
    found = repeated.nominal
    slopes = {name: repeated.sensitivity(name) for name in names}
    searched = [lost(rig, one, repeated.decays) for one in changes_ if found.known]
    if json_:
        logs = [[log.real, log.imag] for log in found.logs]
        said = {"period": found.period, "logs": logs, "rest": found.rest, "spread": found.spread}
        say_json({**said, **_slopes(slopes), "searched": [one.data() for one in searched]})
    else:
        say(f"Floquet multipliers over {found.period:g} s, of {', '.join(found.labels)}:", bold=True)
        for line in found.lines():
            say(line)
        for name, slope in slopes.items():
            say(slope.line(name, "the largest multiplier"))
        for one in searched:
            say(str(one))
    return 0 if found.known else EXPECTATION_FAILED


def _write(found: Found, folder: Path) -> None:
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "margins.json").write_text(json.dumps(found.data(), indent=2) + "\n", "utf-8")
        found.figure().savefig(folder / "margins.png", dpi=120)
    found.save_table(folder / "response.csv")
    _save(realized(found.response), folder)


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
