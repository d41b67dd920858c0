"""`orchestrate validate`: all checks of a scenario that need no run, and what a run of it would be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..fmu.archive import shown
from ..fmu.interfaces import is_path
from ..results import formats
from ..results.figures import require
from ..runner.limits import limits
from ..runner.open import Opened, open_scenario
from ..scenario.faults import sentence
from ..swap.own_claims import own_claims
from .console import folded, notes, say, table
from .help import examples
from .options import DURATION, FIGURES, FLAVOUR, FORMAT, MAP, SET, STEP, SWAP, pacing
from .overrides import loaded
from .paths import PATH


@click.command(
    "validate",
    epilog=examples(
        "orchestrate validate loop.yaml",
        "orchestrate validate loop.ssp",
        "orchestrate validate loop.yaml --set plant.inclination='51.6 deg' --duration '2 orbits'",
        "orchestrate validate loop.yaml --swap allocator=vendor.fmu --map mapping.yaml",
    ),
)
@click.argument("scenario", type=PATH)
@SET
@SWAP
@MAP
@STEP
@DURATION
@FLAVOUR
@pacing
@FORMAT
@FIGURES
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
def command(
    scenario: Path,
    sets: tuple[str, ...],
    swaps: tuple[str, ...],
    maps: tuple[str, ...],
    step: str | None,
    duration: str | None,
    flavour: str | None,
    format_: str,
    figures: bool,
    quiet: bool,
    **pace: Any,
) -> None:
    """Check a scenario without running it, and say what would run.

    Takes the options of run. The FMUs are opened and held against the scenario, but none of their code runs: what an FMU
    refuses in its initialization shows in a run only. Exit status: 0 it can run, 2 it cannot.
    """
    formats.check(format_)
    chosen = loaded(scenario, sets, swaps, maps, pace, step=step, duration=duration, flavour=flavour)
    if figures:
        require(chosen)
    opened = open_scenario(chosen)
    formats.check_names(opened.plan.columns, opened.plan.models, format_)
    if quiet:
        return
    claims = (
        str(finding)
        for block in (text.partition("=")[0].strip() for text in swaps)
        for finding in own_claims(opened.plan.scenario, block, [v.name for v in opened.plan.models[block].of("output")])
    )
    notes([*opened.plan.notes, *claims])
    _print(opened, scenario)


def _print(opened: Opened, path: Path) -> None:
    plan = opened.plan
    scenario, clock = plan.scenario, plan.clock
    say(f"{scenario.name}: valid {'SSP archive' if path.suffix == '.ssp' else 'scenario'}; nothing was run", bold=True)
    if scenario.description:
        say(folded(" ".join(scenario.description.split())))
    say()
    rows = []
    for name in plan.order.blocks:
        entry, fmu = scenario.blocks[name], opened.fmus[name]
        kind = "" if is_path(entry.fmu) else f", {entry.flavour or scenario.flavour}"
        where = "own process" if limits(scenario, name) else "this process"
        own = str(shown(fmu.path)) if is_path(entry.fmu) else entry.fmu
        rows.append((name, f"{own}{kind}", f"{entry.every * clock.step:.10g} s", where, str(len(plan.starts[name]))))
    for line in table(("block, in order", "FMU", "stepped every", "runs in", "start values"), rows):
        say(line)
    say()
    duration, interval = clock.time(clock.steps), clock.time(clock.interval)
    samples = clock.steps // clock.interval + 1 + (clock.steps % clock.interval > 0)
    facts = [
        ("steps", f"{clock.steps} of {clock.step:.10g} s: {duration:.10g} s, {scenario.exchange}"),
        ("connections", str(len(scenario.connections))),
        ("records", f"{len(plan.columns)} signals every {interval:.10g} s: {samples} samples"),
        (
            "expectations",
            str(len(plan.checks)) + (f", and {n} not evaluated" if (n := len(plan.not_evaluated)) else ""),
        ),
        *(("real time", entry.text) for entry in [scenario.realtime] if entry is not None),
        *(("fault", sentence(fault)) for fault in scenario.faults),
    ]
    for line in table(("", ""), facts)[1:]:
        say(line)
