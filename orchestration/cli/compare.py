"""`orchestrate compare`: another team's FMU back to back with ours."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..acceptance.compare import DIFFERENCES, Comparison, compare, rows_of_differences, summary, verdict
from ..acceptance.page import write
from ..errors import BlockError, InputError
from ..results.place import check_writable, put
from ..runner.read import load, read
from ..swap.option import swapped
from .console import complain, notes, say, say_json, table
from .overrides import overridden
from .paths import PATH
from .status import BLOCK_FAILED, NOT_EQUIVALENT
from .summary import mark


@click.command("compare")
@click.argument("scenario", type=PATH)
@click.option(
    "--swap", "swaps", multiple=True, required=True, metavar="BLOCK=FILE.fmu", help="The FMU in a block's place."
)
@click.option("--map", "maps", multiple=True, metavar="FILE", help="Mapping of its ports to ours.")
@click.option(
    "--tolerance",
    "wanted",
    multiple=True,
    metavar="[OUTPUT=]VALUE|FILE",
    help="Of an output ('0.2 A.m2', '1 %'), of all ('0.1 %'), or a YAML of them; default: 1e-6 of our largest value.",
)
@click.option("--set", "sets", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="A start value, for both.")
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the report; default: results/NAME-BLOCK.")
@click.option("--step", metavar="T", help="Base step instead of the scenario's, for both.")
@click.option("--duration", metavar="T", help="Duration instead of the scenario's, for both.")
@click.option("--json", "json_", is_flag=True, help="Print the comparison as JSON.")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    swaps: tuple[str, ...],
    maps: tuple[str, ...],
    wanted: tuple[str, ...],
    sets: tuple[str, ...],
    out: Path | None,
    step: str | None,
    duration: str | None,
    json_: bool,
) -> None:
    """Compare an FMU with the block that it replaces: on the same inputs, and in the loop.

    Writes a page, comparison.html, with both runs. Exit status: 0 equivalent within the tolerances and all expectations met,
    1 not, 2 wrong input, 3 an FMU failed.
    """
    if len(swaps) != 1:
        raise InputError("--swap: one block is compared at a time")
    source = overridden(read(scenario), sets, step=step, duration=duration)
    block = swaps[0].partition("=")[0].strip()
    theirs = swapped(source, swaps, maps)
    target = out or Path("results") / f"{load(source).name}-{block}"
    check_writable(target)
    try:
        comparison = compare(source, theirs, block, wanted)
    except BlockError as error:
        if error.result is not None:
            error.result.save(target / "ours")
        complain(f"ours: {error}")
        ctx.exit(BLOCK_FAILED)
    comparison.ours.save(target / "ours")
    if len(comparison.theirs.time):
        comparison.theirs.save(target / "theirs")
    data = summary(comparison)
    put(target / "comparison.json", json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    page = write(comparison, target)
    if json_:
        say_json(data)
    else:
        _print(comparison, page)
    if comparison.failure is not None:
        complain(f"theirs: {comparison.failure}")
        ctx.exit(BLOCK_FAILED)
    ctx.exit(0 if comparison.passed else NOT_EQUIVALENT)


def _print(comparison: Comparison, page: Path) -> None:
    scenario = comparison.ours.scenario
    notes(comparison.theirs.warnings)
    say(f"{scenario.name}: {comparison.block} against {Path(comparison.fmu).name}", bold=True)
    say(f"\nopen loop: what ours was given, every {comparison.interval:.10g} s, given to theirs")
    rows = rows_of_differences(comparison)
    header, *lines = table(DIFFERENCES, [cells for _, cells in rows])
    say(header, head=mark())
    for (passed, cells), line in zip(rows, lines, strict=True):
        say(line, head=mark("" if cells[5] == "" else "ok" if passed else "differs"))
    say("\nclosed loop: the expectations of the scenario")
    claims = [(a.name, a.text, "not evaluated" if b is None else b.text, a.expected) for a, b in comparison.claims]
    header, *lines = table(("expectation", "ours", "theirs", "expected"), claims)
    say(header, head=mark())
    for (_, b), line in zip(comparison.claims, lines, strict=True):
        say(line, head=mark("" if b is None else b.status))
    say()
    say(verdict(comparison), bold=True, fg="green" if comparison.passed else "red")
    say(f"report in {page}")
