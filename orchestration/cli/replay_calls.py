"""`orchestrate replay-calls`: plays the recorded calls of an FMU, and says where its answers differ.

Tests: tests/orchestration/instances/record/test_play.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..instances.record.play import play
from .console import complain, say
from .help import examples
from .options import Between
from .paths import PATH
from .status import BLOCK_FAILED, EXPECTATION_FAILED


@click.command(
    "replay-calls",
    epilog=examples(
        "orchestrate replay-calls results/loop/calls/plant/calls.bin",
        "orchestrate replay-calls calls.bin --fmu corrected.fmu --tolerance 1e-12",
        "orchestrate replay-calls calls.bin --shortest shortest.bin",
    ),
)
@click.argument("record", type=PATH)
@click.option("--fmu", type=PATH, metavar="FILE", help="Another FMU than the one beside the record.")
@click.option(
    "--tolerance",
    type=Between(0.0),
    default=0.0,
    show_default=True,
    help="What a number may differ by, as a share of the largest value of its port so far.",
)
@click.option("--until", type=click.IntRange(1), metavar="N", help="Play the first N calls.")
@click.option(
    "--shortest",
    type=PATH,
    metavar="FILE",
    help="Write the record up to the first call that differs, fails or does not return.",
)
@click.option("--log", is_flag=True, help="Print what the FMU logs.")
@click.pass_context
def command(
    ctx: click.Context,
    record: Path,
    fmu: Path | None,
    tolerance: float,
    until: int | None,
    shortest: Path | None,
    log: bool,
) -> None:
    """Play the recorded calls of an FMU.

    RECORD is what `orchestrate run --record-calls BLOCK` wrote. Prints the first call whose answer differs, with port
    and values; the FMU runs in a process of its own.

    Exit status: 0 all answers are as recorded, 1 they are not, 2 wrong input, 3 the FMU ended the process.
    """
    played = play(record, fmu, tolerance=tolerance, until=until, shortest=shortest, log=log)
    for line in played.log:
        say(line)
    for line in played.lines:
        say(line)
    if played.ended:
        complain(f"the FMU {played.ended}")
        ctx.exit(BLOCK_FAILED)
    ctx.exit(0 if played.same else EXPECTATION_FAILED)
