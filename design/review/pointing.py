"""The pointing budget: errors of pointing and of knowledge in the hold, by contributor and together.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from orchestration.campaign.case import Case
from plant.so3 import Array

from . import budget, studies, tumbles
from .content import Curves, Section, Table
from .facts import Facts
from .flights import INTERVAL, Flight, Flown
from .options import Options

SETTLED, OBSERVED = 0.5, 1.0
"""Orbits: how long the estimate has to settle, and how long the hold is looked at."""
ALL, NONE = "all errors", "no error"
DRAWN = 800
"""Samples of the figure, about."""
FEWER = 5
"""A contributor has a fifth of the members."""


def cases(facts: Facts) -> dict[str, list[str]]:
    """Returns by name of a case the contributors that are taken away."""
    each = studies.contributors(facts)
    found = {ALL: [], NONE: each}
    for name in each:
        found[f"{name} alone"] = [other for other in each if other != name]
        found[f"without {name}"] = [name]
    return found


def flights(facts: Facts, options: Options, case: Case) -> list[Flight]:
    """Returns the holds that are flown: the same members with the same draws in each case."""
    signals = [f"{facts.plant}.{name}" for name in ("R_NB", "r_N", "v_N")]
    if "estimator" in facts.blocks:
        signals.append(f"{facts.blocks['estimator']}.R_NB")
    duration = f"{(SETTLED + OBSERVED) * facts.period:.6g} s"
    made = []
    for name, away in cases(facts).items():
        for member in range(members(options, name)):
            drawn: dict[str, dict[str, object]] = {}
            for key, value in tumbles.draw(case, member).items():
                block, _, variable = key.partition(".")
                if variable not in ("Q0", "omega_B0"):
                    drawn.setdefault(block, {})[variable] = value
            blocks = studies.merged(drawn, studies.hold(facts), studies.without(facts, away))
            made.append(Flight(_named(name, member), {"duration": duration, "blocks": blocks}, tuple(signals)))
    return made


def members(options: Options, name: str) -> int:
    """Returns how many flights a case has."""
    return options.members if name == ALL else max(options.members // FEWER, 1)


def _named(name: str, member: int) -> str:
    return f"hold-{name.replace(' ', '_')}-{member}"


Errors = dict[str, dict[str, list[Array]]]
"""By `pointing` and `knowledge`, and by case, the errors (n, 3) rad of each flight."""


def errors(facts: Facts, options: Options, flown: Mapping[str, Flown]) -> tuple[Errors, int]:
    """Returns the errors of the flights, and how many flights failed."""
    found: Errors = {"pointing": {}, "knowledge": {}}
    failed = 0
    for name in cases(facts):
        for member in range(members(options, name)):
            one = flown[_named(name, member)]
            late = one.time >= SETTLED * facts.period
            if one.failure or not late.any():
                failed += 1
                continue
            found["pointing"].setdefault(name, []).append(_of_pointing(facts, one, late))
            if "estimator" in facts.blocks:
                found["knowledge"].setdefault(name, []).append(_of_knowledge(facts, one, late)[0])
    return found, failed


def _of_pointing(facts: Facts, one: Flown, rows: NDArray[np.bool_] | slice) -> Array:
    """Returns the errors (n, 3) rad of some rows of a flight."""
    R, r, v = (one[f"{facts.plant}.{name}"][rows] for name in ("R_NB", "r_N", "v_N"))
    return budget.rotation_vectors(budget.to_lvlh(R, r, v, facts.R_d0))


def _of_knowledge(facts: Facts, one: Flown, rows: NDArray[np.bool_] | slice) -> tuple[Array, NDArray[np.bool_]]:
    """Returns the errors (m, 3) rad where the attitude is known, and whether it is in each of the rows (n,)."""
    R, estimated = (one[f"{block}.R_NB"][rows] for block in (facts.plant, facts.blocks["estimator"]))
    known = np.abs(estimated).sum(axis=(1, 2)) > 0.0  # a matrix of zeros is no attitude
    return budget.rotation_vectors(estimated[known].transpose(0, 2, 1) @ R[known]), known


def section(facts: Facts, options: Options, flown: Mapping[str, Flown]) -> Section:
    """Returns the budget as tables."""
    found, failed = errors(facts, options, flown)
    tables = []
    percent = f"{100.0 * options.confidence:.4g}%"
    for kind, by_case in found.items():
        if not by_case:
            continue
        each = {
            name: budget.of_flights(flights, INTERVAL, options.window, options.drift, options.confidence)
            for name, flights in by_case.items()
        }
        total = each.get(ALL)
        if total is None:
            continue
        rows = [[index, *map(_deg, total[index])] for index in budget.INDICES]
        tables.append(Table(f"Errors of {kind}", ["error", "ensemble, deg", "temporal, deg", "mixed, deg"], rows))
        tables.append(_by_contributor(facts, kind, each))
    notes = [
        f"Hold at rest from {SETTLED:g} to {SETTLED + OBSERVED:g} orbits after its start; {options.members} flights "
        f"with all errors, {members(options, NONE)} of each other case, with the same draws; {failed} failed. Replay: "
        "orchestrate flights/hold-CASE-MEMBER.yaml",
        f"Sizes of rotation vectors, at {percent}. Ensemble: a share of {percent} of the flights never exceeds it. "
        f"Temporal: the worst flight does not exceed it for {percent} of the time. Mixed: {percent} of all samples.",
        f"Absolute: the error itself. Mean: over windows of {options.window:g} s. Relative: the rest within a window. "
        f"Drift: difference of the means of two windows {options.drift:g} s apart.",
        "ECSS-E-ST-60-10C names errors of these kinds and statistics; its text was not at hand, and no clause of it is "
        "cited. The sums are the plain ones: linear, and the root of the sum of squares of what each adds.",
    ]
    if "estimator" not in facts.blocks:
        notes.append("There is no block estimator: errors of knowledge are not told.")
    return Section("Pointing budget", tables, _figures(facts, flown), notes)


def _by_contributor(facts: Facts, kind: str, each: Mapping[str, Mapping[str, budget.Statistics]]) -> Table:
    """Returns the mixed statistics of each contributor alone and left out, and both sums beside all together."""

    def value(case: str, index: str) -> float:
        return each[case][index].mixed if case in each else math.nan

    shown = ("absolute", "relative")
    rows = []
    for name in studies.contributors(facts):
        alone, left = f"{name} alone", f"without {name}"
        rows.append([name, *(_deg(value(case, index)) for index in shown for case in (alone, left))])
    rows.append(["none of them", *(text for index in shown for text in (_deg(value(NONE, index)), "–"))])
    sums = {
        index: budget.summed(value(NONE, index), [value(f"{n} alone", index) for n in studies.contributors(facts)])
        for index in shown
    }
    for place, name in enumerate(("linear sum", "root of the sum of squares")):
        rows.append([name, *(text for index in shown for text in (_deg(sums[index][place]), "–"))])
    rows.append([ALL, *(text for index in shown for text in (_deg(value(ALL, index)), "–"))])
    columns = ["contributor", *(f"{index}, {case}, deg" for index in shown for case in ("alone", "left out"))]
    return Table(
        f"Errors of {kind} by contributor",
        columns,
        rows,
        "Mixed statistics. A sum above the value of all together is a budget on the safe side; one below it says that "
        "the errors act together, and that the loop is not linear in them.",
    )


def _figures(facts: Facts, flown: Mapping[str, Flown]) -> list[Curves]:
    one = flown.get(_named(ALL, 0))
    if one is None or one.failure:
        return []
    whole = slice(None)
    curves = {"of pointing": np.degrees(np.linalg.norm(_of_pointing(facts, one, whole), axis=1))}
    if "estimator" in facts.blocks:
        vectors, known = _of_knowledge(facts, one, whole)
        curves["of knowledge"] = np.full(len(known), np.nan)
        curves["of knowledge"][known] = np.degrees(np.linalg.norm(vectors, axis=1))
    every = slice(None, None, max(len(one.time) // DRAWN, 1))
    minutes = (one.time[every] / 60.0).tolist()
    listed = {name: [v if v == v else 0.0 for v in values[every].tolist()] for name, values in curves.items()}
    return [Curves("Errors of the first flight", minutes, "time, min", "error, deg", listed, log=True)]


def _deg(value: float) -> str:
    return f"{math.degrees(value):.3g}" if value == value else "–"
