"""`orchestrate campaign`: a scenario flown again and again, and a verdict on each requirement.

Tests: tests/orchestration/campaign/test_engine.py, tests/orchestration/campaign/report/test_page.py.
"""

from __future__ import annotations

import math
from pathlib import Path

import click

from ..campaign import engine
from ..campaign.case import Case, read_campaign
from ..campaign.flying import batches
from ..campaign.replay import Replayed, replay, worst
from ..campaign.report.page import metrics_of
from ..campaign.report.plots import Metric
from ..campaign.sums import read
from ..errors import InputError
from ..expectations.metrics import MetricError
from ..quantities import shown, with_unit
from ..results.inputs import value_text
from ..results.place import check_writable, refuse_links
from .campaign_summary import summary
from .console import Progress, complain, notes, open_page, say, say_table
from .help import examples
from .options import OPEN, QUIET, SET, out_folder
from .overrides import settings
from .paths import PATH
from .status import BLOCK_FAILED, EXPECTATION_FAILED, SIGNALLED
from .summary import judged, save
from .summary import summary as run_summary
from .watch import watched


@click.command(
    "campaign",
    epilog=examples(
        "orchestrate campaign scenarios/campaigns/paper_settling.yaml",
        "orchestrate campaign campaign.yaml --runs 200 --workers 4 --open",
        "orchestrate campaign campaign.yaml --replay worst",
    ),
)
@click.argument("file", type=PATH)
@out_folder("Folder for the results; default: results/NAME, NAME being the campaign's.")
@click.option("--runs", type=int, metavar="N", help="Number of runs instead of the file's.")
@click.option("--seed", type=int, metavar="N", help="Seed instead of the file's.")
@SET
@click.option(
    "--workers",
    type=click.IntRange(min=0),
    metavar="N",
    help="Processes that fly; 0: this one. Default: one for each core.",
)
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="A Dask cluster that flies.")
@click.option(
    "--dashboard", is_flag=True, help="Open Dask's dashboard on a port of this machine, and print its address."
)
@click.option(
    "--replay",
    "index",
    metavar="INDEX|worst",
    help="Only write the scenario of this run, or of the worst case that a search found, and fly it.",
)
@OPEN
@QUIET
@click.pass_context
def command(
    ctx: click.Context,
    file: Path,
    out: Path | None,
    runs: int | None,
    seed: int | None,
    sets: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
    dashboard: bool,
    index: str | None,
    open_: bool,
    quiet: bool,
) -> None:
    """Fly a scenario many times, with values that vary.

    FILE is a campaign: the scenario, what varies, and requirements on the runs.
    The same command goes on where it was stopped.
    Exit status: 0 all requirements met, 1 one not met or undecided, 2 wrong input, 3 every run failed.
    """
    overrides = {key: value for key, value in (("runs", runs), ("seed", seed)) if value is not None}
    case = read_campaign(file, overrides, settings(sets))
    target = out or Path("results") / case.campaign.name
    if workers == 0 or index is not None:
        ctx.with_resource(watched(case.scenario, lost="runs that are written are kept"))
    if index is not None:
        ctx.exit(_replay(case, index, target, quiet, open_))
    if not quiet:
        notes(case.notes)
    bar = Progress(case.runs, not quiet, "runs")

    def tell(at: batches.Progress) -> None:
        rate = f"{at.fresh / at.seconds:.3g} runs/s" if at.seconds > 0.0 else ""
        bar.status = rate + (f", {at.failed} failed" if at.failed else "")
        bar(at.flown)

    try:
        finished = engine.fly(
            case, target, workers, scheduler, dashboard, tell, (lambda text: None) if quiet else _note
        )
    except batches.CrewLost as error:
        complain(str(error))
        ctx.exit(BLOCK_FAILED)
    finally:
        bar.close()
    if not quiet:
        summary(read(target), finished.reason, _metrics(target) if finished.flown else ())
        say(f"\nresults in {target}" + ("" if finished.page is None else f", report in {finished.page}"))
    if open_ and finished.page is not None:
        open_page(finished.page)
    ctx.exit(_status(case, finished, quiet))


def _metrics(folder: Path) -> list[Metric]:
    from ..campaign.flying.rows import Rows  # it needs PyArrow, and the help does without  # noqa: PLC0415

    return metrics_of(Rows(folder))


def _note(text: str) -> None:
    notes([text])


def _status(case: Case, finished: engine.Finished, quiet: bool) -> int:
    if finished.interrupted:
        complain(f"interrupted after {finished.flown} of {case.runs} runs; the same command goes on from there")
        return SIGNALLED + finished.interrupted
    if finished.flown and finished.failed == finished.flown:
        complain(f"every run failed, the first with: {finished.reason}")
        return BLOCK_FAILED
    for verdict in finished.verdicts if quiet else ():
        if verdict.status != "met":
            complain(f"requirement {verdict.status}: {verdict.name}")
    return 0 if all(verdict.status == "met" for verdict in finished.verdicts) else EXPECTATION_FAILED


def _replay(case: Case, index: str, target: Path, quiet: bool, open_: bool) -> int:
    """Flies one run again, prints it and writes its folder; the exit status is that of a run."""
    if index != "worst" and not (index.isdecimal() and len(index) <= 10):  # no campaign has more runs
        raise InputError(f"--replay {index:.20}: expected the index of a run, 0 to {case.runs - 1}, or 'worst'")
    folder = target / f"replay-{index}"
    check_writable(folder)
    refuse_links(target)
    try:
        again = worst(case, target, folder) if index == "worst" else replay(case, int(index), folder, target)
    except MetricError as error:
        complain(str(error))
        return BLOCK_FAILED
    result = again.result
    if not quiet:
        _print_replay(case, index, again)
    save(result, folder)
    if not quiet:
        say(f"\nscenario in {again.file}, results in {folder}")
    if (target / "campaign.html").exists():
        engine.page(target, _note)  # whose plots lead to this flight
    if open_:
        open_page(folder / "report.html")
    if result.failure is not None:
        complain(str(result.failure))
    if again.differs:
        run = "the worst case" if index == "worst" else f"run {index}"
        complain(
            f"{run}, flown again on fresh instances, is not as in {target}: {'; '.join(again.differs)}; an FMU keeps "
            "something beyond its reset, or is not deterministic; remedy: the campaign in another folder (--out)"
        )
    if result.failure is not None or again.differs:
        return BLOCK_FAILED
    return 0 if all(again.met.values()) and result.passed else EXPECTATION_FAILED


def _print_replay(case: Case, index: str, again: Replayed) -> None:
    notes(again.result.warnings)
    say(f"{'worst case' if index == 'worst' else f'run {index}'} of the campaign {case.campaign.name}", bold=True)
    say_table(("varied", "value"), _varied(case, again))
    units = {m.metric.name: shown(m.unit) for m in case.job.measures}
    metrics = {name: _measured(x, units[name]) for name, x in again.metrics.items()}
    if metrics:
        say()
        say_table(("metric", "value"), metrics.items())
    rows = []
    for one in case.job.requirements:
        why = ""
        if not again.met[one.name]:
            name = None if one.metric is None else case.job.measures[one.metric].metric.name
            why = ", the run failed" if again.result.failure else f"; {name} is {metrics[name]}" if name else ""
        rows.append(("met" if again.met[one.name] else "not met", (f"{one.name}: {one.expected}{why}",)))
    judged(("",), rows)
    say()
    if len(again.result.time):
        run_summary(again.result)


def _varied(case: Case, again: Replayed) -> list[tuple[str, str]]:
    """Returns what varies with its values, each with the unit that it is in."""
    ports = {draw.name: draw.port for draw in case.job.draws.draws if draw.numbers and draw.unit is None}
    texts = {name: value_text(value) for name, value in again.values.items()}
    return [(name, f"{text} {ports.get(name) or ''}".rstrip()) for name, text in texts.items()]


def _measured(value: float | None, unit: str) -> str:
    return "none" if value is None else "never" if value == math.inf else with_unit(value, unit)
