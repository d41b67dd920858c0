"""`orchestrate compare`: another team's FMU back to back with ours."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from ..acceptance.compare import Comparison, compare
from ..acceptance.page import write
from ..acceptance.verdict import DIFFERENCES, colour, meaning, rows_of_differences, summary, verdict
from ..errors import BlockError, InputError, writing
from ..results.place import put, refuse_foreign
from ..session.read import load, read
from ..swap.option import swapped, swaps_of
from .console import complain, folded, notes, open_page, say, say_json, table
from .help import examples
from .options import DURATION, OPEN, SET, STEP, out_folder
from .overrides import overridden
from .paths import PATH
from .status import BLOCK_FAILED, NOT_EQUIVALENT
from .summary import mark, save

FILES = ("ours", "theirs", "comparison.html", "comparison.json")
"""What it leaves in its folder."""


@click.command(
    "compare",
    epilog=examples(
        "orchestrate compare loop.yaml --swap allocator=vendor.fmu --map mapping.yaml",
        "orchestrate compare loop.yaml --swap allocator=vendor.fmu --tolerance '0.1 %' --open",
        "orchestrate compare loop.yaml --swap allocator=vendor.fmu --tolerance dipole_cmd='0.2 A.m2'",
        "orchestrate compare loop.yaml --swap allocator=vendor.fmu --tolerance tolerances.yaml -o out",
    ),
)
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
@SET
@out_folder("Folder of the report; default: results/NAME-BLOCK.")
@STEP
@DURATION
@OPEN
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
    open_: bool,
    json_: bool,
) -> None:
    """Compare an FMU with the block that it replaces.

    It is compared on the same inputs, and in the loop. Writes a page, comparison.html, with both runs. Exit status: 0 equivalent within the tolerances and all expectations met,
    1 not, 2 wrong input, 3 an FMU failed.
    """
    if len(swaps) != 1:
        raise InputError("--swap: one block is compared at a time")
    source = overridden(read(scenario), sets, step=step, duration=duration)
    (swap,) = swaps_of(swaps, maps)
    block, theirs = swap.block, swapped(source, [swap])
    target = out or Path("results") / f"{load(source).name}-{block}"
    refuse_foreign(target, FILES)
    try:
        comparison = compare(source, theirs, block, wanted)
    except BlockError as error:
        if error.result is not None:
            error.result.save(target / "ours")
        complain(f"ours: {error}")
        ctx.exit(BLOCK_FAILED)
    save(comparison.ours, target / "ours")
    if len(comparison.theirs.time):
        comparison.theirs.save(target / "theirs")
    data = summary(comparison)
    with writing(target):
        put(target / "comparison.json", json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    page = write(comparison, target)
    if json_:
        say_json(data)
    else:
        _print(comparison, page)
    if open_:
        open_page(page)
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
    _table(DIFFERENCES, rows)
    say("\nclosed loop: the expectations of the scenario")
    claims = [(a.name, a.text, "not evaluated" if b is None else b.text, a.expected) for a, b in comparison.claims]
    statuses = ("not evaluated" if b is None else b.status for _, b in comparison.claims)
    _table(("expectation", "ours", "theirs", "expected"), list(zip(statuses, claims, strict=True)))
    say()
    say(folded(verdict(comparison)), bold=True, fg=colour(comparison))
    for sentence in meaning(comparison):
        say(folded(sentence, "  "))
    say(f"report in {page}")


def _table(header: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> None:
    """Prints a table, before each row its status."""
    if not rows:
        return
    width = 2 + max(len(status) for status, _ in rows)
    first, *lines = table(header, [cells for _, cells in rows], width)
    say(first, head=mark(width=width))
    for (status, _), line in zip(rows, lines, strict=True):
        say(line, head=mark(status, width))
