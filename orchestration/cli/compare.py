"""`orchestrate compare`: compares another team's FMU back to back with ours.

Tests: tests/orchestration/acceptance/test_compare.py.
"""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..acceptance.compare import Comparison, compare
from ..acceptance.page import write
from ..acceptance.verdict import DIFFERENCES, colour, explanation, meaning, rows_of_differences, summary, verdict
from ..errors import BlockError, InputError, writing
from ..results.place import refuse_foreign
from ..results.whole import put
from ..session.read import load
from ..swap.option import swapped
from .console import complain, folded, notes, open_page, say, say_json
from .help import examples
from .options import OPEN, as_json, changes, out_folder
from .overrides import Changes
from .paths import PATH
from .status import BLOCK_FAILED, NOT_EQUIVALENT
from .summary import judged, save
from .watch import watched

FILES = ("ours", "theirs", "comparison.html", "comparison.json")
"""Names of what it leaves in its folder."""


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
@changes("swaps", "maps", "sets", "step", "duration")
@click.option(
    "--tolerance",
    "wanted",
    multiple=True,
    metavar="[OUTPUT=]VALUE|FILE",
    help="Of an output ('0.2 A.m2', '1 %'), of all ('0.1 %'), or a YAML of them; default: 1e-6 of our largest value.",
)
@out_folder("Folder of the report; default: results/NAME-BLOCK.")
@OPEN
@as_json("the comparison")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    wanted: tuple[str, ...],
    out: Path | None,
    open_: bool,
    json_: bool,
) -> None:
    """Compare an FMU with the block that it replaces.

    It is compared on the same inputs, and in the loop. Writes a page, comparison.html, with both runs.
    Exit status: 0 equivalent within the tolerances and all expectations met, 1 not, 2 wrong input, 3 an FMU failed.
    """
    if len(change.swaps) != 1:
        raise InputError("--swap: one block is compared at a time")
    source, (block,) = change.unswapped(scenario), change.blocks
    theirs = swapped(source, change.given)
    target = out or Path("results") / f"{load(source).name}-{block}"
    refuse_foreign(target, FILES)
    ctx.with_resource(watched(load(theirs), lost="nothing of this comparison is written"))
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
    judged(DIFFERENCES, rows_of_differences(comparison))
    say("\nclosed loop: the expectations of the scenario")
    left = "not evaluated"
    rows = [
        (b.status if b else left, (a.name, a.text, b.text if b else left, a.expected)) for a, b in comparison.claims
    ]
    judged(("expectation", "ours", "theirs", "expected"), rows)
    say()
    say(folded(verdict(comparison)), bold=True, fg=colour(comparison))
    for line in explanation(comparison):
        say(folded(line, "  "))
    for sentence in meaning(comparison):
        say(folded(sentence, "  "))
    say(f"report in {page}")
