"""On which varied entries a metric depends: Sobol' indices, Morris' effects, and rank correlation from plain samples.

A Sobol' index is a share of the metric's variance: the first-order one is due to an entry alone, the total one includes
its interactions (Saltelli et al., Comput. Phys. Commun. 181, 2010). Morris' mu* is the mean size of a metric's change
when an entry moves across two thirds of its range, relative to the whole range, and sigma tells interaction or
curvature (Technometrics 33, 1991; Campolongo et al., Environ. Model. Softw. 22, 2007). SALib draws the designs and
evaluates them. The coordinates of one entry, such as the three of an attitude, move together.

A run that failed, or that has no finite value of a metric, has no place in these formulas. The base point or trajectory
to which it belongs is left out. Where a tenth of them or more is lost, what is left is another distribution; then the
indices are those of the loss itself (1 without a value, 0 with one), which say what it depends on.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import rankdata

from ...errors import InputError
from ..file.analysis import Sensitivity
from .metric_function import Floats, MetricFunction

LOST = 0.1
"""Share of base points or trajectories from which on no indices are given."""
RANKED = 200_000
"""Runs that a rank correlation uses at most, the first ones; its error is below 0.005 then."""
_EDGE = 2.0**-40
"""How near to 0 and 1 a coordinate may come."""


def run(section: Sensitivity, function: MetricFunction, seed: int) -> dict[str, Any]:
    """Flies the design and returns the indices of each metric by varied entry, for campaign.json."""
    from SALib.analyze import morris, sobol  # here, since they take 2 s to import  # noqa: PLC0415
    from SALib.sample import morris as morris_design  # noqa: PLC0415
    from SALib.sample import sobol as sobol_design  # noqa: PLC0415

    problem, entries = _problem(function)
    if section.method == "sobol":
        unit = sobol_design.sample(problem, section.points, calc_second_order=False, seed=seed + 1)
    else:
        unit = morris_design.sample(problem, section.points, num_levels=4, seed=seed + 1)
        ends = np.where(function.bounded, 0.0, 0.5 * (1.0 - 0.9973))
        unit = ends + (1.0 - 2.0 * ends) * unit
    before = dict(function.reasons)
    flown = function.fly(np.clip(unit, _EDGE, 1.0 - _EDGE))
    size = len(unit) // section.points

    def indices(values: Floats) -> dict[str, Any]:
        rows = values.reshape(section.points, size)
        used = np.isfinite(rows).all(axis=1)
        lost = int(section.points - used.sum())
        what = f"{lost} of {section.points} {'base points' if section.method == 'sobol' else 'trajectories'}"
        if lost >= LOST * section.points:
            lacking = indices((~np.isfinite(values)).astype(float))
            return {**lacking, "of": "loss", "note": f"{what} have a run without a value: these are indices of that"}
        note = f"{what} are left out: they have a run without a value" if lost else ""
        y = rows[used].ravel()
        if np.ptp(y) <= 1e-12 * np.abs(y).max():
            return {"used": int(used.sum()), "of": "nothing", "note": "it is the same in all runs"}
        if section.method == "sobol":
            s = sobol.analyze(problem, y, calc_second_order=False, seed=seed + 1)
            named = {"first": "S1", "first_error": "S1_conf", "total": "ST", "total_error": "ST_conf"}
        else:
            s = morris.analyze(problem, unit[np.repeat(used, size)], y, num_levels=4, seed=seed + 1)
            named = {"effect": "mu_star", "effect_error": "mu_star_conf", "spread": "sigma"}
        given = {key: _plain(s[name]) for key, name in named.items()}
        return {"used": int(used.sum()), "of": "value", "note": note, **given}

    metrics = {name: indices(values) for name, values in flown.items()}
    reasons = {text: more for text, count in function.reasons.items() if (more := count - before.get(text, 0))}
    return {
        "method": section.method,
        "points": section.points,
        "runs": len(unit),
        "failed": sum(reasons.values()),
        "reasons": reasons,
        "entries": entries,
        "metrics": metrics,
    }


def _problem(function: MetricFunction) -> tuple[dict[str, Any], list[str]]:
    """Returns SALib's problem, and the entries whose indices it gives: coordinates where only one entry varies."""
    entries = [(name, count) for name, _, count in function.entries if count]
    if len(entries) == 1:
        entries = [(name, 1) for name in function.coordinates]
    if len(entries) < 2:
        raise InputError("sensitivity: expected two varied entries at least; nothing to compare one with")
    groups = [name for name, count in entries for _ in range(count)]
    problem = {
        "num_vars": function.dimension,
        "names": list(function.coordinates),
        "groups": groups,
        "bounds": [[0.0, 1.0]] * function.dimension,
    }
    return problem, [name for name, _ in entries]


def _plain(values: Any) -> list[float | None]:
    return [float(v) if np.isfinite(v) else None for v in np.ma.filled(values, np.nan)]


def ranks(columns: Iterable[Floats], metric: Floats) -> list[dict[str, float] | None]:
    """Spearman's rank correlation of a metric (n,) with each of the columns (n,), and the partial one.

    The partial one is what is left when the linear dependence of the ranks on all other columns is taken away. Bounds
    are those of Bonett and Wright, Psychometrika 65, 2000. Runs with nan are left out, infinite values keep their rank;
    None for a column that is constant.
    """
    table = np.column_stack([metric, *columns])
    table = table[~np.isnan(table).any(axis=1)][:RANKED]
    n, k = table.shape
    if n < 5:
        return [None] * (k - 1)
    ranked = np.column_stack([rankdata(column) for column in table.T])
    spread = ranked.std(axis=0)
    moving = np.flatnonzero(spread[1:] > 0.0) + 1
    if spread[0] == 0.0 or not len(moving):
        return [None] * (k - 1)
    kept = np.r_[0, moving]
    correlation = np.corrcoef(ranked[:, kept], rowvar=False)
    inverse = np.linalg.pinv(correlation, hermitian=True)
    z = float(ndtri(0.975))  # 95%, two-sided
    correlations: list[dict[str, float] | None] = [None] * (k - 1)
    for i, place in enumerate(moving, start=1):
        rho = float(correlation[0, i])
        width = z * np.sqrt((1.0 + 0.5 * rho**2) / (n - 3))
        middle = np.arctanh(np.clip(rho, -1.0 + 1e-15, 1.0 - 1e-15))
        partial = -inverse[0, i] / np.sqrt(inverse[0, 0] * inverse[i, i]) if n > len(kept) + 2 else np.nan
        correlations[place - 1] = {
            "rho": rho,
            "low": float(np.tanh(middle - width)),
            "high": float(np.tanh(middle + width)),
            "partial": float(partial),
        }
    return correlations
