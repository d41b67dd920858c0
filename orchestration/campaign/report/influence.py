"""The tables of a campaign's page that say what a metric depends on, with a bar for each number."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ...results.html import joined
from ..statistics.sensitivity import RANKED, ranks
from .plots import Metric
from .template import part, piece, rows

_SHOWN = 8
"""Varied values in a table of rank correlations at most."""


def ranked(metrics: list[Metric], columns: dict[str, NDArray[np.float64]]) -> tuple[Markup, list[dict[str, float]]]:
    """Returns a table of rank correlations for each metric, the strongest first, and these by varied value."""
    tables, strengths = [], []
    for metric in metrics:
        correlations = dict(zip(columns, ranks(columns.values(), metric.values[:RANKED]), strict=True))
        known = {name: r for name, r in correlations.items() if r is not None}
        strengths.append({name: r["rho"] for name, r in known.items()})
        lines = [
            [
                name,
                bar(r["rho"], r["low"], r["high"], -1.0, 1.0),
                signed(r["rho"]),
                f"{signed(r['low'])} to {signed(r['high'])}",
                signed(r["partial"]),
            ]
            for name, r in sorted(known.items(), key=lambda entry: -abs(entry[1]["rho"]))
        ]
        if len(lines) > _SHOWN:
            lines = [*lines[:_SHOWN], [f"{len(lines) - _SHOWN} weaker ones", "", "", "", ""]]
        tables.append(part("rank_table", rows("rank_table", lines), metric=metric.name, text=metric.text))
    return joined(tables), strengths


def sensitivity(analysis: dict[str, Any] | None) -> Markup:
    """Returns the indices of a design of its own, in a table for each metric, the most important entry first."""
    if analysis is None:
        return Markup("")
    sobol = analysis["method"] == "sobol"
    tables = []
    for metric, indices in analysis["metrics"].items():
        entries = analysis["entries"] if "total" in indices or "effect" in indices else []
        key = "total" if sobol else "effect"
        order = sorted(range(len(entries)), key=lambda i: -(indices[key][i] or 0.0))
        if sobol:
            lines = [[entries[i], *(_index(indices, kind, i) for kind in ("total", "first"))] for i in order]
        else:
            ends = ((indices["effect"][i] or 0.0) + (indices["effect_error"][i] or 0.0) for i in order)
            top = max(ends, default=1.0) or 1.0
            lines = [[entries[i], _effect(indices, i, top), _number(indices["spread"][i])] for i in order]
        table = "sobol_table" if sobol else "morris_table"
        tables.append(piece(table).format(metric=metric, note=indices["note"], content=rows(table, lines)))
    failed = f"{analysis['failed']:,} of them failed." if analysis["failed"] else ""
    return part(
        analysis["method"],
        joined(tables),
        runs=f"{analysis['runs']:,}",
        points=f"{analysis['points']:,}",
        failed=failed,
    )


def _index(indices: dict[str, Any], kind: str, i: int) -> Markup:
    value, error = (indices[key][i] or 0.0 for key in (kind, f"{kind}_error"))
    return bar(value, value - error, value + error, 0.0, 1.0, f"{signed(value)} \N{PLUS-MINUS SIGN} {error:.2f}")


def _effect(indices: dict[str, Any], i: int, top: float) -> Markup:
    value, error = (indices[key][i] or 0.0 for key in ("effect", "effect_error"))
    return bar(value, value - error, value + error, 0.0, top, f"{value:.4g} \N{PLUS-MINUS SIGN} {error:.2g}")


def _number(value: float | None) -> str:
    return "\N{EN DASH}" if value is None else f"{value:.4g}"


def signed(value: float) -> str:
    """Returns a coefficient to two decimals, with a true minus sign."""
    return "\N{EN DASH}" if np.isnan(value) else f"{round(value, 2) + 0.0:.2f}".replace("-", "\N{MINUS SIGN}")


def bar(value: float, low: float, high: float, least: float, most: float, text: str = "") -> Markup:
    """Returns a bar from 0 to a value on a scale from `least` to `most`, and a line from `low` to `high` across it."""

    def at(number: float) -> float:
        return 100.0 * min(max((number - least) / (most - least), 0.0), 1.0)

    zero, end = at(0.0), at(value)
    return piece("range").format(
        left=f"{min(zero, end):.1f}",
        width=f"{abs(end - zero):.1f}",
        from_=f"{at(low):.1f}",
        span=f"{at(high) - at(low):.1f}",
        text=text,
    )
