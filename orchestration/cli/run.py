"""`orchestrate run`: runs a scenario, prints a summary and writes the folder of the results.

Tests: tests/orchestration/cli/test_cli.py, test_realtime.py, tests/orchestration/results/test_outputs.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path

import click

from ..errors import InputError, hint
from ..fmu.model import Model
from ..instances.record.play import RECORD
from ..results import formats
from ..results.figures import require
from ..results.place import refuse_foreign, refuse_other, reserved
from ..results.result import Result
from ..session import run as runner
from ..session.realtime import PRIORITIES, pacer, prioritized
from ..swap.option import swapped
from ..swap.own_claims import own_claims
from ..system.wiring import Node
from .console import Progress, complain, folded, notes, open_page, say
from .help import examples
from .keyboard import KEYS, keyboard
from .noted import noted
from .options import FIGURES, FORMAT, OPEN, QUIET, changes, out_folder
from .overrides import Changes
from .paths import PATH
from .status import BLOCK_FAILED, EXPECTATION_FAILED, SIGNALLED
from .summary import save, summary
from .watch import watched

CALLS = "calls"
"""The folder, among the results, of recorded calls."""
_DIAGNOSIS, _SEARCH = 20.0, 6.0
"""Seconds after which a failed swap is left without a diagnosis, and those of them for wirings."""


@click.command(
    "run",
    epilog=examples(
        "orchestrate scenarios/minimal.yaml",
        "orchestrate scenarios/paper_singularity.yaml --figures --open",
        "orchestrate loop.yaml --set plant.inclination='51.6 deg' -o results/other",
        "orchestrate loop.yaml --swap allocator=vendor.fmu --map mapping.yaml",
        "orchestrate loop.yaml --realtime --late stop",
        "orchestrate loop.yaml --record-calls allocator",
        "orchestrate loop.ssp --duration '2 orbits' --format parquet -q",
    ),
)
@click.argument("scenario", type=PATH)
@changes()
@out_folder(
    "Folder for the results; default: results/NAME, NAME being the scenario's, or the file's of an SSP archive."
)
@FORMAT
@FIGURES
@OPEN
@click.option(
    "--loop",
    type=click.Choice(["compiled", "python"]),
    default="compiled",
    help="The step loop: compiled C where possible (the default), or Python; the results are the same.",
)
@click.option(
    "--realtime-priority",
    "priority",
    is_flag=False,
    flag_value="80",
    metavar="[1-99]",
    type=click.IntRange(PRIORITIES[0], PRIORITIES[-1]),
    help="Let a run in real time go before all other programs, with its memory locked (Linux, SCHED_FIFO); 80 "
    "by default.",
)
@click.option("--log", is_flag=True, help="Print the log messages of the FMUs during the run.")
@click.option(
    "--record-calls",
    "recorded",
    multiple=True,
    metavar="BLOCK",
    help="Write the FMI calls of this block to calls/BLOCK of the results, with a C program that plays them; may be "
    "repeated.",
)
@QUIET
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    out: Path | None,
    format_: str,
    figures: bool,
    open_: bool,
    loop: str,
    priority: int | None,
    log: bool,
    recorded: tuple[str, ...],
    quiet: bool,
) -> None:
    """Run a scenario (the default command).

    SCENARIO is a YAML file or an SSP archive. Writes signals, a manifest and a report, and prints a summary.
    """
    formats.check(format_)
    chosen = change.scenario(scenario)
    if figures:
        require(chosen)
    target = out or Path("results") / (scenario.stem if scenario.suffix == ".ssp" else chosen.name)
    refuse_foreign(target, [CALLS])
    records = {block: target / CALLS / block for block in recorded}
    for block in recorded:
        if block not in chosen.blocks:
            raise InputError(f"--record-calls {block}: there is no such block{hint(block, chosen.blocks)}")

    def accept(columns: Iterable[Node], models: Mapping[str, Model]) -> None:
        formats.check_names(columns, models, format_)
        if out is None:
            refuse_other(target, str(scenario))

    progress = Progress(chosen.duration, not quiet)
    with watched(chosen, [folder / RECORD for folder in records.values()]), reserved(target):
        with keyboard() if chosen.realtime else nullcontext() as keys:
            pace_keeper = pacer(chosen, keys, priority)
            if pace_keeper is not None:
                progress.status = lambda: pace_keeper.status
                if keys is not None and not quiet:
                    say(KEYS)
            try:
                with prioritized(priority):
                    compiled = loop == "compiled"
                    result = runner.execute(chosen, progress, log, compiled, accept, pacer=pace_keeper, records=records)
            finally:
                progress.close()
        for block in change.blocks:
            outputs = [variable.name for variable in result.models[block].of("output")]
            result.warnings += [str(finding) for finding in own_claims(result.scenario, block, outputs)]
        if not quiet:
            notes([*result.warnings, *noted(chosen)])
            if len(result.time):
                summary(result)
        status = _status(result, quiet)
        save(result, target, format_)
        if figures and len(result.time):
            result.draw(target / "figures")
    if change.swaps and status in (BLOCK_FAILED, EXPECTATION_FAILED):
        tell = complain if quiet else say
        tell("a block is swapped, and the run does not pass; what it does otherwise than ours, and the mapping:")
        for line in change.diagnosis(scenario):
            tell(f"  {line}")
        for line in () if quiet else _diagnosed(scenario, change):
            say(folded(line))
    if not quiet:
        say(f"\nresults in {target}")
        for block, folder in records.items():
            say(f"calls of {block} in {folder}: orchestrate replay-calls {folder / RECORD}, or make there")
    if open_:
        open_page(target / "report.html")
    ctx.exit(status)


def _diagnosed(scenario: Path, change: Changes) -> list[str]:
    """Returns what explains how the one swapped block differs from ours; nothing where that takes too long."""
    if len(change.blocks) != 1:
        return []
    # Here, since a run that passes needs none of it.
    from ..acceptance.polarity.apart import within  # noqa: PLC0415
    from ..acceptance.polarity.mend import as_yaml, in_words, mend  # noqa: PLC0415

    source = change.unswapped(scenario)
    mended = within(_DIAGNOSIS, mend, source, swapped(source, change.given), change.blocks[0], _SEARCH)
    if mended is None:
        return []
    lines = in_words(mended)
    return [*lines, "the mapping that corrects it:", *as_yaml(mended.mapping).splitlines()] if mended.behaves else lines


def _status(result: Result, quiet: bool) -> int:
    """Returns the exit status of a run; prints why it is not 0, where the summary has not."""
    if result.failure is not None:
        complain(str(result.failure))
        return BLOCK_FAILED
    if result.interrupted:
        return SIGNALLED + result.interrupted
    for outcome in result.outcomes if quiet else ():
        if not outcome.passed:
            complain(f"expectation {outcome.status}: {outcome.name}")
    return 0 if result.passed else EXPECTATION_FAILED
