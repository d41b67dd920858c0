"""`orchestrate card`: the ground test card of another team's FMU, in its own names, units and axes.

Tests: tests/orchestration/acceptance/test_vendor_card.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..acceptance.check import check
from ..acceptance.polarity import card_page
from ..acceptance.polarity.card import card
from ..acceptance.polarity.fly import Loop
from ..acceptance.polarity.vendor_card import lines, settings
from ..acceptance.vector import part_of, scenario_of
from ..errors import InputError
from ..fmu.archive import shown
from ..results.place import check_writable
from ..session.read import load
from ..swap.findings import unfed
from .console import open_page, say
from .help import examples
from .options import OPEN, out_folder
from .paths import PATH


@click.command(
    "card",
    epilog=examples(
        "orchestrate card vendor.fmu --as allocator --map mapping.yaml",
        "orchestrate card vendor.fmu --as allocator --map mapping.yaml --scenario loop.yaml --open",
    ),
)
@click.argument("fmu", type=PATH)
@click.option("--as", "as_", required=True, metavar="BLOCK", help="The block that it replaces.")
@click.option("--map", "map_", type=PATH, metavar="FILE", help="Mapping of its ports to ours.")
@click.option("--scenario", type=PATH, metavar="FILE", help="The run of which the stimuli are parts.")
@out_folder("Folder of the card; default: results/NAME-card.")
@OPEN
def command(fmu: Path, as_: str, map_: Path | None, scenario: Path | None, out: Path | None, open_: bool) -> None:
    """Write the ground test card of an FMU.

    Stimuli, and what has to answer, with sign, value and tolerance, in the names, units and axes of the FMU: a page
    that prints, card.html, and a script that plays it at a device, card.py. No code of the FMU runs.

    Exit status: 0 the card is written, 2 wrong input.
    """
    findings, fitted = check(fmu, as_, map_)
    wrong = [finding for finding in findings if finding.level == "error" and not unfed(finding)]
    if fitted is None or wrong:
        raise InputError(
            f"{shown(fmu)} does not fit as {as_}: {wrong[0] if wrong else 'it cannot be read'}; "
            f"remedy: orchestrate check {shown(fmu)} --as {as_} --suggest"
        )
    path = scenario or scenario_of(as_)
    source, block = part_of(path, as_)
    target = out or Path("results") / f"{fmu.stem}-card"
    check_writable(target)
    loop = Loop(source)
    made = lines(card(loop, [block]).trials, fitted)
    if not made:
        raise InputError(f"{shown(fmu)}: no stimulus of {shown(path)} changes an output that it has")
    about = {"fmu": fmu.name, "as": as_, "mapping": map_.name if map_ else "none", "stimuli of": load(source).name}
    files = card_page.write(made, about, target, settings(fitted, loop.plan.starts[block]))
    answers = sum(len(line.outputs) for line in made)
    say(f"{shown(fmu)} as {as_}: {len(made)} stimuli, {answers} answers", bold=True)
    say(f"card in {target}: {', '.join(path.name for path in files)}")
    if open_:
        open_page(files[0])
