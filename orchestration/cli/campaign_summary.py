"""Prints what the console shows of a campaign at its end. Tests: tests/orchestration/campaign/report/test_page.py."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..campaign.report.plots import Metric
from ..campaign.statistics.verdicts import percent, probability
from ..quantities import with_unit
from .console import say, say_table
from .summary import colour

_DASH = "\N{EN DASH}"
_NAMED = 4
"""Varied entries that are named for each metric at most."""


def summary(manifest: Mapping[str, Any], reason: str | None = None, metrics: Sequence[Metric] = ()) -> None:
    """Prints the verdicts of a campaign, its metrics, what they depend on, and the worst case, from its campaign.json.

    `reason` is why the first run failed that did.
    """
    runs = manifest["runs"]
    seconds = manifest.get("wall_time") or 0.0
    few = f" of {runs['wanted']:,}" if runs["flown"] < runs["wanted"] else ""
    say(f"{manifest['campaign']}: {runs['flown']:,}{few} runs, {manifest['state']}, in {seconds:.3g} s", bold=True)
    if runs["failed"]:
        fail = "runs failed and meet" if runs["failed"] > 1 else "run failed and meets"
        failed = f"{runs['failed']:,} {fail} no requirement"
        say(f"{failed}; the first: {reason}" if reason else failed, fg="yellow")
    if manifest["verdicts"]:
        _verdicts(manifest)
        for verdict in manifest["verdicts"]:
            if verdict["status"] == "undecided":
                say(f"{verdict['name']}: undecided: {verdict['text']}", fg="yellow")
    _spread(metrics)
    _influence(manifest.get("sensitivity"))
    _worst(manifest.get("search"), {m["name"]: m["unit"] for m in manifest["metrics"]})


def _verdicts(manifest: Mapping[str, Any]) -> None:
    asked = {requirement["name"]: requirement for requirement in manifest["requirements"]}
    rows = []
    for v in manifest["verdicts"]:
        share = f"{v['share']:.5g}" if v["share"] is not None else _DASH
        required = f"{v['probability']:g} at {percent(v['confidence'])}"
        low, high = probability(v["low"]), probability(v["high"], up=True)
        bounds = f"(\N{GREATER-THAN OR EQUAL TO} {low}, \N{LESS-THAN OR EQUAL TO} {high})"
        rows.append((v["status"], v["name"], asked[v["name"]]["expected"], required, f"{share} {bounds}"))
    say()
    styles = [colour(v["status"]) for v in manifest["verdicts"]]
    say_table(("verdict", "requirement", "bound", "required", "share, bounds"), rows, styles, whole=True)


def _spread(metrics: Sequence[Metric]) -> None:
    """Prints of each metric what half and 90% of the runs are not worse than, and the worst; a failed run is worse
    than all.
    """
    rows = []
    for metric in metrics:
        sign = -1.0 if metric.lower_is_worse else 1.0
        bad = np.where(np.isnan(metric.values), np.inf, sign * metric.values)
        ends = [float(sign * np.quantile(bad, part, method="inverted_cdf")) for part in (0.5, 0.9, 1.0)]
        rows.append((metric.name, *(metric.with_unit(x) if np.isfinite(x) else "never or failed" for x in ends)))
    if rows:
        say()
        say_table(("metric", "half of the runs", "90%", "worst"), rows)


def _influence(found: Mapping[str, Any] | None) -> None:
    if found is None:
        return
    key, title = ("total", "total Sobol index") if found["method"] == "sobol" else ("effect", "mean Morris effect")
    say(f"\n{title}, from {found['runs']:,} runs of their own, {found['failed']:,} failed")
    for metric, indices in found["metrics"].items():
        if key not in indices:
            say(f"  {metric}: {indices['note']}", fg="yellow")
            continue
        named = sorted(zip(indices[key], found["entries"], strict=True), key=lambda entry: -(entry[0] or 0.0))
        more = f", {len(named) - _NAMED} more" if len(named) > _NAMED else ""
        say(f"  {metric}: {', '.join(f'{name} {value:.2g}' for value, name in named[:_NAMED])}{more}")
        if indices["note"]:
            say(f"    {indices['note']}", fg="yellow")


def _worst(found: Mapping[str, Any] | None, units: Mapping[str, str]) -> None:
    if found is None:
        return
    at = f"{found['worst']} {found['metric']} of a search with {found['runs']:,} runs"
    if found["values"] is None:
        say(f"\n{at}: none, all of them failed", fg="yellow")
        return
    value = "never" if found["value"] is None else with_unit(found["value"], units.get(found["metric"], ""))
    failed = f", {found['failed']:,} failed" if found["failed"] else ""
    say(f"\n{at}: {value}{failed}; --replay worst flies it")
