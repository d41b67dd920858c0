"""`orchestrate validate`: makes all checks of a scenario that need no run, and says what a run would be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InputError, lacking
from ..fmu.archive import shown
from ..fmu.interfaces import is_path
from ..live.system import checked
from ..results import formats
from ..results.figures import require
from ..scenario.scenario import Scenario
from ..session.limits import limits
from ..session.open import Opened, open_scenario
from ..session.read import read
from ..swap.own_claims import own_claims
from ..system import acting
from .console import folded, notes, say, say_table
from .help import examples
from .noted import noted
from .options import FIGURES, FORMAT, QUIET, changes
from .overrides import Changes, settings
from .paths import PATH

if TYPE_CHECKING:
    from ..campaign.case import Case


@click.command(
    "validate",
    epilog=examples(
        "orchestrate validate loop.yaml",
        "orchestrate validate loop.ssp",
        "orchestrate validate loop.yaml --set plant.inclination='51.6 deg' --duration '2 orbits'",
        "orchestrate validate loop.yaml --swap allocator=vendor.fmu --map mapping.yaml",
        "orchestrate validate scenarios/campaigns/paper_settling.yaml",
    ),
)
@click.argument("scenario", type=PATH)
@changes()
@FORMAT
@FIGURES
@QUIET
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    format_: str,
    figures: bool,
    quiet: bool,
) -> None:
    """Check a scenario or campaign and say what would run.

    Takes the options of run that change what would run (not --out, --open, --loop, --log); with a campaign only --set.
    The FMUs are opened and compared with the scenario, but none of their code runs:
    what an FMU refuses in its initialization shows in a run only. Exit status: 0 it can run, 2 it cannot.
    """
    formats.check(format_)
    if _is_campaign(scenario):
        case = _campaign(ctx, scenario, change.sets)
        if not quiet:
            notes(case.notes)
            _print_campaign(case)
        return
    chosen = change.scenario(scenario)
    if figures:
        require(chosen)
    opened = open_scenario(chosen)
    formats.check_names(opened.plan.columns, opened.plan.models, format_)
    if quiet:
        return
    claims = (
        str(finding)
        for block in change.blocks
        for finding in own_claims(opened.plan.scenario, block, [v.name for v in opened.plan.models[block].of("output")])
    )
    notes([*opened.plan.notes, *claims, *_of_live(chosen), *noted(chosen)])
    _print(opened, scenario)


def _of_live(scenario: Scenario) -> list[str]:
    """Returns what in `live` does not fit the blocks: no run takes notice of it."""
    if scenario.live is None:
        return []
    try:
        checked(scenario)
    except InputError as error:
        return [f"{message} (orchestrate live refuses this)" for message in error.messages]
    return []


def _is_campaign(path: Path) -> bool:
    """Returns whether the file names a scenario that it varies, which a scenario does not."""
    data = None if path.suffix == ".ssp" else read(path).data
    return isinstance(data, dict) and "scenario" in data and "blocks" not in data


def _campaign(ctx: click.Context, path: Path, sets: Sequence[str]) -> Case:
    for option in ctx.command.params:
        given = ctx.get_parameter_source(option.name or "") is click.core.ParameterSource.COMMANDLINE
        if given and option.name not in ("scenario", "sets", "quiet"):
            raise InputError(
                f"{option.opts[-1]}: {path.name} is a campaign; remedy: give it in the campaign's scenario"
            )
    try:
        from ..campaign.case import read_campaign  # here, since only campaigns need SciPy  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise lacking("a campaign", error.name) from None
    return read_campaign(path, None, settings(sets), loads=False)


def _print_campaign(case: Case) -> None:
    campaign, job = case.campaign, case.job
    _head(campaign.name, "campaign", campaign.description)
    scenario, clock = job.opened.plan.scenario, job.opened.plan.clock
    facts = [
        ("scenario", f"{scenario.name}: {clock.steps} steps of {clock.step:.10g} s"),
        ("runs", f"{case.runs}, {campaign.sampling}, seed {campaign.seed}"),
        *(("varied", f"{draw.name}: {draw.text}") for draw in job.draws.draws),
        *(("metric", measure.metric.name) for measure in job.measures),
        *(
            ("requirement", f"{one.name}: {one.expected} in {one.probability:g} of the runs")
            for one in job.requirements
        ),
    ]
    say_table(("", ""), facts)


def _head(name: str, kind: str, description: str | None) -> None:
    say(f"{name}: valid {kind}; nothing was run", bold=True)
    if description:
        say(folded(" ".join(description.split())))
    say()


def _print(opened: Opened, path: Path) -> None:
    plan = opened.plan
    scenario, clock = plan.scenario, plan.clock
    _head(scenario.name, "SSP archive" if path.suffix == ".ssp" else "scenario", scenario.description)
    rows = []
    for name in plan.order.blocks:
        entry, fmu = scenario.blocks[name], opened.fmus[name]
        kind = "" if entry.telemetry or is_path(entry.fmu) else f", {entry.flavour or scenario.flavour}"
        where = "own process" if limits(scenario, name) else "this process"
        own = str(shown(fmu.path)) if is_path(entry.fmu) else entry.fmu
        own = f"record {entry.telemetry.file}" if entry.telemetry else own
        rows.append((name, f"{own}{kind}", f"{entry.every * clock.step:.10g} s", where, str(len(plan.starts[name]))))
    say_table(("block, in order", "FMU", "stepped every", "runs in", "start values"), rows)
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
        *(("fault", text) for text in acting.fault_sentences(scenario, plan.models)),
        *(("timeline", text) for text in acting.timeline_sentences(scenario)),
    ]
    say_table(("", ""), facts)
