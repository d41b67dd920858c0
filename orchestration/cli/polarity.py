"""`orchestrate polarity`: finds what shows a wrong sign, axis, unit or attitude at each port of a loop.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..acceptance.polarity import page
from ..acceptance.polarity.card import card
from ..acceptance.polarity.fly import Loop
from ..acceptance.polarity.mend import as_yaml, in_words
from ..acceptance.polarity.swaps import Looked, look
from ..acceptance.polarity.trials import Trials, run
from ..results.place import check_writable, refuse_links
from ..scenario.source import Source
from ..session.read import load
from ..swap.option import swapped
from .console import Progress, complain, folded, notes, say, say_json, say_table
from .help import examples
from .options import as_json, changes, out_folder
from .overrides import Changes
from .paths import PATH
from .status import EXPECTATION_FAILED


@click.command(
    "polarity",
    epilog=examples(
        "orchestrate polarity loop.yaml",
        "orchestrate polarity loop.yaml --port allocator.h_w",
        "orchestrate polarity loop.yaml --swap allocator=vendor.fmu",
    ),
)
@click.argument("scenario", type=PATH)
@changes("swaps", "maps", "sets", "duration")
@click.option("--port", "chosen", multiple=True, metavar="BLOCK.PORT", help="Only this port; may be repeated.")
@click.option("--workers", type=click.IntRange(1, 64), help="Processes that fly; default: one a core.")
@out_folder("Folder for the tables; default: results/NAME-polarity.")
@as_json("the result")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    chosen: tuple[str, ...],
    workers: int | None,
    out: Path | None,
    json_: bool,
) -> None:
    """Show which wrong signs, axes and units are detected.

    Every port is wired wrongly in every usual way, including transposed attitudes, and the loop is flown until an
    expectation or a consistency check of the scenario fails. Writes the tables and a ground test card.
    With --swap the ports of that block only; where the FMU behaves as one that is wired wrongly,
    the mapping that corrects it is printed.

    Exit status: 0 the loop as wired is sound, 1 it is not, 2 wrong input, 3 an FMU failed.
    """
    ours = source = change.unswapped(scenario)
    blocks = change.blocks or None
    target = out or Path("results") / f"{load(source).name}-polarity"
    check_writable(target)
    refuse_links(target)
    looked: Looked | None = None
    if change.given:
        looked = look(ours, swapped(source, change.given), change.blocks)
        source = looked.source
        if not json_:
            _tell(looked, target)
        page.write_mappings(looked, target)
    trials = _flown(source, blocks, chosen, workers, json_)
    if trials.nominal is not None:
        by, time = trials.nominal.by, trials.nominal.time
        complain(
            f"the loop as it is wired does not pass at {time:.5g} s ({by}), "
            "so wrong wirings cannot be distinguished from it"
        )
        ctx.exit(EXPECTATION_FAILED)
    made = card(Loop(source)) if not chosen else None
    files = page.write(trials, made, target, trials.scenario, looked)
    if json_:
        say_json(page.summary(trials, looked))
    else:
        _print(trials, files)
        if looked is not None and looked.mended and (unseen := page.unobservable(trials)):
            names = ", ".join(dict.fromkeys(name for name, *_ in unseen))
            complain(
                "the loop does not confirm all of the mapping: "
                f"some wrong wirings of {names} change nothing that it sees"
            )
    wrong = looked is not None and (looked.wrong is not None or any(m.behaves for m in looked.mended))
    ctx.exit(EXPECTATION_FAILED if wrong else 0)


def _flown(
    source: Source, blocks: list[str] | None, chosen: tuple[str, ...], workers: int | None, quiet: bool
) -> Trials:
    progress = Progress(1.0, not quiet, "wirings")

    def tell(done: int, total: int) -> None:
        progress.duration = total
        progress(done)

    try:
        return run(source, blocks, chosen, workers, tell)
    finally:
        progress.close()


def _tell(looked: Looked, target: Path) -> None:
    """Prints which mappings were proposed, and what mends the swapped FMUs."""
    for block in looked.proposed:
        say(f"{block}: its ports do not fit without a mapping; one is proposed: {target / f'{block}.proposed.yaml'}")
        if names := ", ".join(looked.ignored[block]):
            say(
                f"{block}: no input of its FMU is left for {names} of ours, so what flows there is ignored", fg="yellow"
            )
    if looked.wrong is not None:
        complain(f"as wired the loop does not pass: {looked.wrong.by}, at {looked.wrong.time:.5g} s")
    for mended in looked.mended:
        for line in in_words(mended):
            say(folded(line, "  " if line.startswith(" ") else ""), fg="yellow" if not mended.behaves else None)
        if mended.behaves:
            say(f"the mapping that corrects it ({target / f'{mended.block}.mapping.yaml'}):")
            for line in as_yaml(mended.mapping).splitlines():
                say(f"  {line}")
        if not mended.complete and not mended.named:
            say("  the search ended before all pairs of ports were tried", fg="yellow")
    if looked.wrong is None:
        return
    with_it = "with it " if any(mended.behaves for mended in looked.mended) else ""
    if looked.left is None:
        say(f"{with_it}the loop meets all expectations and consistency checks", fg="green")
    else:
        say(f"{with_it}the loop still does not pass: {looked.left.by}, at {looked.left.time:.5g} s", fg="red")
    say()


def _print(trials: Trials, files: list[Path]) -> None:
    notes(trials.notes)
    say(f"{trials.scenario}: {page.verdict(trials)}", bold=True)
    say()
    say_table(page.HEADER, page.table(trials))
    for name, wrongs, reason, remedy in page.unobservable(trials):
        some = ", ".join(wrongs[:4]) + (f" and {len(wrongs) - 4} more" if len(wrongs) > 4 else "")
        say()
        say(folded(f"not observable: {name}: {some}: {reason}"), fg="yellow")
        say(folded(f"-> add {remedy}", "  "))
    say(f"\ntables in {files[0].parent}: {', '.join(path.name for path in files)}")
