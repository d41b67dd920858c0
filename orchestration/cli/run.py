"""`orchestrate run`: runs a scenario, prints a summary and writes the folder of the results."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from ..results import formats
from ..results.figures import require
from ..results.place import reserved
from ..results.result import Result
from ..runner import run as runner
from ..runner.read import load, read
from ..swap.option import swapped
from ..swap.own_claims import own_claims
from .console import Progress, complain, lost, notes, say
from .overrides import overridden
from .paths import PATH
from .status import BLOCK_FAILED, EXPECTATION_FAILED, SIGNALLED, UNWRITTEN
from .summary import summary


@click.command("run")
@click.argument("scenario", type=PATH)
@click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="BLOCK.PARAMETER=VALUE",
    help="A start value, such as plant.angle='51.6 deg' or plant.x=[1,2,3]; may be repeated.",
)
@click.option(
    "--swap", "swaps", multiple=True, metavar="BLOCK=FILE.fmu", help="Another FMU in a block's place; may be repeated."
)
@click.option(
    "--map",
    "maps",
    multiple=True,
    metavar="[BLOCK=]FILE",
    help="Mapping of the swapped FMU's ports to ours; with several swaps BLOCK=FILE.",
)
@click.option(
    "--out",
    type=PATH,
    metavar="DIR",
    help="Folder for the results; default: results/NAME, NAME being the scenario's.",
)
@click.option("--step", metavar="T", help="Base step instead of the scenario's, in s or with a unit.")
@click.option("--duration", metavar="T", help="Duration instead of the scenario's, in s or with a unit.")
@click.option("--flavour", metavar="native|python", help="Build of the project's own blocks instead of the scenario's.")
@click.option(
    "--format", "format_", default="csv", show_default=True, metavar="csv|parquet|mat", help="Format of the signals."
)
@click.option("--figures", is_flag=True, help="Draw the scenario's figures into DIR/figures.")
@click.option(
    "--loop",
    type=click.Choice(["compiled", "python"]),
    default="compiled",
    help="The step loop: compiled C where possible (the default), or Python; the results are the same.",
)
@click.option("--log", is_flag=True, help="Print the log messages of the FMUs during the run.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    sets: tuple[str, ...],
    swaps: tuple[str, ...],
    maps: tuple[str, ...],
    out: Path | None,
    step: str | None,
    duration: str | None,
    flavour: str | None,
    format_: str,
    figures: bool,
    loop: str,
    log: bool,
    quiet: bool,
) -> None:
    """Run a scenario (the default command)."""
    formats.check(format_)
    source = read(scenario)
    if swaps or maps:
        source = swapped(source, swaps, maps)
    loaded = load(overridden(source, sets, step=step, duration=duration, flavour=flavour))
    if figures:
        require(loaded)
    target = out or Path("results") / loaded.name
    progress = Progress(loaded.duration, not quiet)
    with reserved(target):
        try:
            result = runner.execute(
                loaded, progress, log, loop == "compiled", partial(formats.check_names, format=format_)
            )
        finally:
            progress.close()
        for block in (text.partition("=")[0].strip() for text in swaps):
            outputs = [variable.name for variable in result.models[block].of("output")]
            result.warnings += [str(finding) for finding in own_claims(result.scenario, block, outputs)]
        if not quiet:
            notes(result.warnings)
            if len(result.time):
                summary(result)
        status = _status(result, quiet)
        noted = len(result.warnings)
        result.save(target, format_)
        if not quiet:
            notes(result.warnings[noted:])
        if figures and len(result.time):
            result.draw(target / "figures")
    if not quiet:
        say(f"\nresults in {target}")
    ctx.exit(UNWRITTEN if lost() else status)


def _status(result: Result, quiet: bool) -> int:
    """The exit status of a run; prints why it is not 0, where the summary has not."""
    if result.failure is not None:
        complain(str(result.failure))
        return BLOCK_FAILED
    if result.interrupted:
        return SIGNALLED + result.interrupted
    for outcome in result.outcomes if quiet else ():
        if not outcome.passed:
            complain(f"expectation {outcome.status}: {outcome.name}")
    return 0 if result.passed else EXPECTATION_FAILED
