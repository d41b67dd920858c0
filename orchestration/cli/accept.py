"""`orchestrate accept`: one report whether another team's FMU can take a block's place.

Tests: tests/orchestration/acceptance/test_accept.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..acceptance.accept import accept, scenario_for, summary
from ..acceptance.accept_page import FILES, write
from ..acceptance.vector import part_of
from ..fmu.archive import shown
from ..results.place import refuse_foreign
from .console import complain, open_page, say, say_json, say_table
from .help import examples
from .options import OPEN, as_json, out_folder
from .paths import PATH
from .status import BLOCK_FAILED, NOT_EQUIVALENT


@click.command(
    "accept",
    epilog=examples(
        "orchestrate accept vendor.fmu --as allocator",
        "orchestrate accept vendor.fmu --as allocator --map mapping.yaml --open",
        "orchestrate accept vendor.fmu --as allocator --scenario loop.yaml -o out",
    ),
)
@click.argument("fmu", type=PATH)
@click.option("--as", "as_", required=True, metavar="BLOCK", help="The block that it replaces.")
@click.option("--map", "map_", type=PATH, metavar="FILE", help="Mapping of its ports to ours; else one is proposed.")
@click.option("--scenario", type=PATH, metavar="FILE", help="The loop to fly; default: one of the project's own.")
@out_folder("Folder of the report; default: results/NAME-acceptance.")
@OPEN
@as_json("the report")
@click.pass_context
def command(
    ctx: click.Context,
    fmu: Path,
    as_: str,
    map_: Path | None,
    scenario: Path | None,
    out: Path | None,
    open_: bool,
    json_: bool,
) -> None:
    """Accept or refuse an FMU in a block's place.

    Checks interface, libraries and reference data, flies the loop with it beside ours, tries resets, states, threads,
    other steps and bad inputs, and times its calls. Writes acceptance.html and acceptance.json.

    Exit status: 0 accepted, 1 not accepted, 2 wrong input, 3 the FMU failed.
    """
    path = scenario or scenario_for(as_)
    source, block = part_of(path, as_)
    target = out or Path("results") / f"{fmu.stem}-acceptance"
    refuse_foreign(target, FILES)
    made = accept(fmu, as_, map_, source, block)
    page = write(made, target)
    if json_:
        say_json(summary(made))
    else:
        say(f"{shown(fmu)} as {as_}, in {made.scenario}", bold=True)
        say()
        styles = {"met": "green", "failed": "bold red", "": "yellow"}
        rows = [(one.status or "not tested", one.name, one.text) for one in made.requirements]
        say_table(("", "requirement", "found"), rows, [styles[one.status] for one in made.requirements])
        say()
        if made.corrected:
            say("the mapping that corrects its wiring:")
            for line in made.corrected.splitlines():
                say(f"  {line}")
            say()
        say("accepted" if made.passed else "not accepted", bold=True, fg="green" if made.passed else "red")
        say(f"report in {page}")
    if open_:
        open_page(page)
    if made.failure is not None:
        complain(str(made.failure))
        ctx.exit(BLOCK_FAILED)
    ctx.exit(0 if made.passed else NOT_EQUIVALENT)
