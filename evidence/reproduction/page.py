"""The fields of docs/evidence/reproduction.md, each a number or a table from the results; page.md.j2 has the words."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from .. import markdown
from ..paper import LIMITS, READINGS
from . import findings, sweep
from .claims import CLAIMS, Claim, all_hold, hold_outcome
from .seen import Seen

SHOWN = ("a", "c")
"""Readings that have a column; times and angles of (b) are those of (a)."""


def text(done: dict[str, Any]) -> str:
    """The page."""
    fields: dict[str, Any] = {}
    for part in (
        _head,
        _claims,
        _open,
        findings.bound,
        findings.latch,
        findings.convergence,
        findings.robustness,
        findings.orbit,
    ):
        fields |= part(done)
    return markdown.render(Path(__file__).parent, **fields)


def _head(done: dict[str, Any]) -> dict[str, Any]:
    met = all(bool(all_hold(w, done[f"{w}: run a"].seen)[0]) for w in CLAIMS)
    gaps = [v.gap for v in done["V.B: bound 15 A m2"].at_claim]
    code = hold_outcome(done["latch 0.65 0.9"])
    limit, time = LIMITS["V.B"]
    return {
        "verdict": "every claim of both manoeuvres is met" if met else "not every claim is met",
        "nodes_kept": int(all_hold("V.C", done["latch 0.65 0.9"]).sum()),
        "short": f"{min(gaps):.2f} to {max(gaps):.2f}",
        "vb_limit": f"{limit:g}",
        "vb_time": f"{time:.0f}",
        "excluded": f"{sum(gap > 0.0 for gap in gaps)} of {len(gaps)}",
        "latched": int(np.isin(code, (3, 4)).sum()),
        "converge_error": markdown.finite(done["random starts, error"].converged),
    }


def _cell(claim: Claim, seen: Seen) -> str:
    value, margin = float(claim.value(seen)[0]), float(claim.margin(seen)[0])
    word = "met" if margin > 0.0 else "**not met**"
    shown = claim.show(value)
    unit = f" {claim.unit}" if claim.unit and math.isfinite(value) else ""
    if shown in ("yes", "no"):
        return f"{word}: {shown}"
    return f"{word}: {shown}{unit}"


def _claims(done: dict[str, Any]) -> dict[str, Any]:
    tables = {}
    for which, claims in CLAIMS.items():
        runs = [done[f"{which}: run {letter}"] for letter in SHOWN]
        rows = [
            [claim.text, claim.paper + (" (implied)" if claim.implied else "")] + [_cell(claim, r.seen) for r in runs]
            for claim in claims
        ]
        tables[which] = rows
    settled = np.concatenate([done[f"{w}: SI for an orbit"].settled for w in CLAIMS])
    return {
        "readings": "; ".join(f"({r.letter}) {r.text}" for r in READINGS.values()),
        "claims": tables,
        "si_runs": len(settled),
        "si_settled": int(np.isfinite(settled).sum()),
    }


def _number(value: float, constant: sweep.Constant) -> str:
    return f"{value:.2g}" if constant.name in ("bend of Φ", "factor on drag") else f"{value:g}"


def _range(constant: sweep.Constant, which: str, seen: Seen) -> str:
    """Returns where every claim is met."""
    ends = sweep.interval(constant, which, seen)
    if ends is None:
        return "none"
    low, high = ends
    unit = f" {constant.unit}" if constant.unit and constant.unit != "°" else constant.unit
    return f"{_number(low, constant)} to {_number(high, constant)}{unit}"


def _open(done: dict[str, Any]) -> dict[str, Any]:
    rows, kept = [], []
    for i, constant in enumerate(sweep.ONE_BY_ONE):
        tried = f"{_number(float(constant.values[0]), constant)} to {_number(float(constant.values[-1]), constant)}"
        ranges = [_range(constant, w, done[f"{w}: one by one"][i]) for w in CLAIMS]
        if all(cell.removesuffix(f" {constant.unit}") == tried for cell in ranges):
            kept.append(f"{constant.name} ({tried}{f' {constant.unit}' if constant.unit else ''})")
        else:
            rows.append([constant.name, constant.taken, tried, *ranges])
    return {"open": rows, "kept": ", ".join(kept)}
