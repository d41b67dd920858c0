"""The page of a campaign, campaign.html, in the style of a run's report and with its plots.

However many the runs, the page keeps some thousand numbers of each plot, so it stays below 2 MB.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from ...results.html import Page, joined
from ...results.inputs import value_text
from ...results.report import manifest_fold
from ...results.whole import put
from ..statistics.bounds import quantile, share
from ..statistics.sensitivity import RANKED
from ..statistics.verdicts import probability
from . import plots
from .influence import ranked, sensitivity, signed
from .overview import basis, failures, header, outcome, two, verdicts
from .plots import Metric
from .template import part, piece, rows

if TYPE_CHECKING:
    from ..flying.rows import Rows

_PLOTS = 120
"""Scatter plots on a page at most."""
_WORST = 5
"""Worst runs of each metric that the page lists."""


def write(folder: Path) -> Path:
    """Writes campaign.html beside campaign.json and returns its path."""
    path = folder / "campaign.html"
    put(path, page(folder))
    return path


def page(folder: Path) -> str:
    """Returns the page of the campaign whose files are in the folder."""
    from ..flying.rows import Rows  # it needs PyArrow, and all commands and their help do without  # noqa: PLC0415

    runs = Rows(folder)
    manifest, made = runs.manifest, Page()
    metrics = metrics_of(runs) if len(runs) else []
    varied = ([v["name"], v["text"], "drawn for expressions only" if v["drawn"] else ""] for v in manifest["varied"])
    parts = [
        header(manifest),
        part("verdicts", rows("verdicts", verdicts(manifest)), basis=basis(manifest)),
        part("varied", rows("varied", varied)),
    ]
    searched, design = manifest.get("search"), sensitivity(manifest.get("sensitivity"))
    if len(runs):
        failed = int(runs.failed.sum())
        ranks, scatter, worst = _against(runs, metrics, made)
        parts += [
            part("metrics", rows("metrics", (_metric(m, failed, manifest["early"]) for m in metrics))),
            part("distributions", joined(_distribution(m, made, manifest["early"]) for m in metrics)),
            *(ranks, design, scatter, _search(manifest, searched, metrics, made), worst),
            part("failures", rows("failures", failures(runs.reasons()))),
            part("expectations", rows("expectations", _expectations(runs))),
        ]
    parts.append(manifest_fold("campaign.json", "the campaign as resolved, FMUs, versions, platform", manifest))
    more = {"flights": _flights(folder, manifest), "replay": _replay(manifest, "RUN --open")}
    return made.html(f"{manifest['campaign']}: {outcome(manifest)[1]}", parts, more=more)


def _flights(folder: Path, manifest: dict[str, Any]) -> dict[str, str]:
    """Returns the reports of runs that were kept or flown again, by the index of the run."""
    found = {str(run): f"kept/{run}/report.html" for run in manifest.get("kept") or ()}
    again = folder.glob("replay-*/report.html")
    return found | {path.parent.name.removeprefix("replay-"): f"{path.parent.name}/report.html" for path in again}


def metrics_of(runs: Rows) -> list[Metric]:
    """Returns the metrics of all runs, each with what is asked of it."""
    asked: dict[str, dict[str, Any]] = {}
    for requirement in runs.manifest["requirements"]:  # the first one of a metric is the one that is drawn
        if requirement.get("metric"):
            asked.setdefault(requirement["metric"], requirement)
    made = []
    for m in runs.manifest["metrics"]:
        r = asked.get(m["name"])
        bounds = {key: r[key] for key in ("low", "high", "probability", "confidence")} if r else {}
        met = runs.true(r["column"]) if r else None
        made.append(Metric(m["name"], m["text"], m["unit"] or "", runs.numbers(m["column"]), met=met, **bounds))
    return made


def _metric(metric: Metric, failed: int, early: bool) -> list[object]:
    """Returns a row of the table of metrics: quantiles from the good end on."""
    sign = -1.0 if metric.lower_is_worse else 1.0
    bad = sign * metric.values
    bad = np.where(np.isnan(bad), np.inf, bad)
    than = "\N{GREATER-THAN OR EQUAL TO}" if metric.lower_is_worse else "\N{LESS-THAN OR EQUAL TO}"

    def cell(part: float) -> Markup:
        at, bounds = quantile(bad, part, 0.95, early)
        ends = sorted(sign * b for b in (bounds.low, bounds.high) if np.isfinite(b))
        told = "never or failed" if not np.isfinite(at) else f"{than} {metric.with_unit(sign * at)}"
        some = ("from " if (bounds.high == np.inf) != metric.lower_is_worse else "up to ") if len(ends) == 1 else ""
        return two(told, some + " to ".join(metric.with_unit(end) for end in ends))

    there = sign * metric.values[~np.isnan(metric.values)]
    worst = metric.with_unit(sign * there.max()) if len(there) else "\N{EN DASH}"
    never = int(np.isinf(metric.values).sum())
    return [two(metric.name, metric.text), cell(0.5), cell(0.95), cell(0.9973), worst, f"{never:,}", f"{failed:,}"]


def _distribution(metric: Metric, made: Page, early: bool) -> Markup:
    shown = [plots.distribution(metric, made.arrays, early, tail) for tail in (False, True)]
    drawn = [plot for plot in shown if plot is not None]
    if not drawn:
        return Markup("")
    notes = plots.bound_notes(metric, drawn)
    if never := int(np.isposinf(metric.values).sum()):
        notes.append(f"{never:,} run{'s' * (never > 1)} without a finite value")
    if any(plot.get("stepped") for plot in drawn):
        notes.append(f"about {plots.STEPS} steps are drawn")
    if len(drawn) > 1:
        notes.append("right: near the required probability")
    return made.figure(metric.name, drawn, metric.text, notes, f"n{len(drawn)}")


def _against(runs: Rows, metrics: list[Metric], made: Page) -> list[Markup]:
    """Rank correlations, scatter plots and worst runs, which need the varied values."""
    # What an expression gives depends on the other values alone, and moves with them.
    units = {column: v["unit"] for v in runs.manifest["varied"] for column in v["columns"] if v["coordinates"][1]}
    chosen = plots.shown_runs(metrics, runs.failed)
    worst = [np.argsort(-np.where(runs.failed, -np.inf, m.badness), kind="stable")[:_WORST] for m in metrics]
    columns: dict[str, np.ndarray] = {}
    shown: dict[str, tuple[np.ndarray, list[str] | None]] = {}
    told: dict[str, list[list[str]]] = {}
    for column in units:
        values, items = runs.values(column)
        columns[column] = values[:RANKED].copy()  # not all of it kept
        shown[column] = values[chosen], items
        told[column] = [[items[int(v)] if items else f"{v:.5g}" for v in values[at]] for at in worst]
    numbers = {name: values for name, values in columns.items() if shown[name][1] is None}
    tables, strengths = ranked(metrics, numbers)
    few = (
        f"{len(chosen):,} of {len(runs):,} runs are drawn: some at random, and the worst of each metric."
        if len(chosen) < len(runs)
        else ""
    )
    folds: list[Markup] = []
    left = _PLOTS
    for metric, strong in zip(metrics, strengths, strict=True):
        order = sorted(units, key=lambda name: -abs(strong.get(name, 0.0)))[:left]
        left -= len(order)
        drawn = []
        for name in order:
            x, items = shown[name]
            label = f"{name}, {units[name]}" if units[name] else name
            plot = plots.scatter(metric, chosen, x, label, items, runs.index, made.arrays)
            drawn.append(
                made.figure(name, [plot], f"rank correlation {signed(strong[name])}" if name in strong else "")
            )
        opened = Markup(" open") if not folds else ""
        folds.append(
            piece("scatter_metric").format(metric=metric.name, text=metric.text, plots=joined(drawn), open=opened)
        )
    if len(metrics) * len(units) > _PLOTS:
        few += f" Only the first {_PLOTS} plots are drawn."
    return [
        part("ranks", tables, basis=f"From the first {RANKED:,} runs." if len(runs) > RANKED else ""),
        part("scatter", joined(folds), basis=few),
        _worst(runs, metrics, worst, {f"{name}, {units[name]}" if units[name] else name: told[name] for name in told}),
    ]


def _worst(runs: Rows, metrics: list[Metric], worst: list[np.ndarray], told: dict[str, list[list[str]]]) -> Markup:
    kept = set(runs.manifest.get("kept") or ())
    head = joined(Markup('<th scope="col">{}</th>').format(name) for name in told)
    tables = []
    for place, (metric, at) in enumerate(zip(metrics, worst, strict=True)):
        lines = [
            [
                Markup('<a href="kept/{0}/report.html">{0}</a>').format(run) if run in kept else run,
                metric.with_unit(metric.values[row]),
                *(told[name][place][i] for name in told),
            ]
            for i, (row, run) in enumerate(zip(at, runs.index[at].tolist(), strict=True))
            if not runs.failed[row]
        ]
        first = Markup('<th scope="col">{}</th>').format(metric.name)
        tables.append(
            part(
                "worst_table",
                rows("worst_table", lines, metric.name, *told),
                metric=metric.name,
                text=metric.text,
                head=first + head,
            )
        )
    return part("worst", joined(tables), command=_replay(runs.manifest, "RUN"))


def _replay(manifest: dict[str, Any], run: str) -> str:
    return f"orchestrate campaign {shlex.quote(manifest['campaign_file'] or 'CAMPAIGN.yaml')} --replay {run}"


def _search(manifest: dict[str, Any], searched: dict[str, Any] | None, metrics: list[Metric], made: Page) -> Markup:
    if searched is None:
        return Markup("")
    metric = next((m for m in metrics if m.name == searched["metric"]), Metric(searched["metric"], "", "", np.empty(0)))
    own = metric.values[~np.isnan(metric.values)]
    mine = (own.max() if searched["worst"] == "largest" else own.min()) if len(own) else None
    if searched["values"] is None:
        text = f"The search found no case: all of its {searched['runs']:,} runs failed."
    else:
        value = "never" if searched["value"] is None else metric.with_unit(searched["value"])
        text = f"The {searched['worst']} {metric.name} that {searched['runs']:,} runs of a search found is {value}"
        text += (
            f"; that of the campaign's {len(metric.values):,} runs is {metric.with_unit(mine)}."
            if mine is not None
            else "."
        )
    shown = plots.search(searched, metric, made.arrays)
    return piece("search").format(
        found=text,
        command=_replay(manifest, "worst") if searched["values"] is not None else "",
        failed=f"{searched['failed']:,} of its runs failed, which it takes for no case." if searched["failed"] else "",
        content=rows("search", ([name, value_text(value)] for name, value in (searched["values"] or {}).items())),
        figure=made.figure(f"{searched['worst']} {metric.name} up to a number of runs", [shown], kind="n1")
        if shown
        else "",
    )


def _expectations(runs: Rows) -> list[list[object]]:
    lines: list[list[object]] = []
    for expectation in runs.manifest.get("expectations", ()):
        met, n = int(runs.true(expectation["column"]).sum()), len(runs)
        interval = share(met, n, 0.95)
        ends = f"{probability(interval.low)} to {probability(interval.high, up=True)}"
        lines.append([expectation["name"], f"{met:,} of {n:,}", f"{met / n:.5g}", ends])
    return lines
