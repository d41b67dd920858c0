"""The pointing budget: errors of pointing and of knowledge in the hold, by contributor and together.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from orchestration.campaign.case import Case
from orchestration.campaign.flying.rows import Rows
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


Errors = dict[str, dict[str, dict[int, Array]]]
"""By `pointing` and `knowledge`, case and member, the errors (n, 3) rad of a flight."""


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
            found["pointing"].setdefault(name, {})[member] = _of_pointing(facts, one, late)
            if "estimator" in facts.blocks:
                found["knowledge"].setdefault(name, {})[member] = _of_knowledge(facts, one, late)[0]
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


def section(facts: Facts, options: Options, flown: Mapping[str, Flown], rows: Rows) -> Section:
    """Returns the budget as tables, beside what the tumbles hold in their second orbit."""
    found, failed = errors(facts, options, flown)
    tables = []
    percent = f"{100.0 * options.confidence:.4g}%"
    tumbled = len(rows)
    for kind, by_case in found.items():
        if not by_case:
            continue
        if ALL not in by_case:
            continue
        total = _statistics(options, by_case[ALL])
        after = {index: _after_tumbles(kind, index, rows, options.confidence) for index in budget.INDICES}
        listed = [[index, *map(_deg, total[index]), *after[index]] for index in budget.INDICES]
        columns = ["error", "ensemble, deg", "temporal, deg", "mixed, deg"]
        columns += [f"{percent} of tumbles, deg", "worst tumble, deg"]
        tables.append(Table(f"Errors of {kind}", columns, listed))
        tables.append(_by_contributor(facts, options, kind, by_case))
    notes = [
        f"Hold at rest from {SETTLED:g} to {SETTLED + OBSERVED:g} orbits after its start; {options.members} flights "
        f"with all errors, {members(options, NONE)} of each other case, with the same draws; {failed} failed. Replay: "
        "orchestrate flights/hold-CASE-MEMBER.yaml",
        f"Sizes of rotation vectors, at {percent}. Ensemble: a share of {percent} of the flights never exceeds it. "
        f"Temporal: the worst flight does not exceed it for {percent} of the time. Mixed: {percent} of all samples.",
        f"Absolute: the error itself. Mean: over windows of {options.window:g} s, one from each sample on. Relative: "
        "the rest within a window. "
        f"Drift: difference of the means of two windows {options.drift:g} s apart.",
        f"Of tumbles: the largest error in the second orbit of each; {percent} of the {tumbled} are not above it. "
        "A tumble leaves other states than a start at rest: momentum in wheels, what estimator and controller have "
        "learned, errors that have not settled. Where these values are above the ensemble's, count with them.",
        f"With {options.members} flights the largest bounds {percent} of all with a confidence of "
        f"{_confidence(options.members, options.confidence)}, with {tumbled} tumbles of "
        f"{_confidence(tumbled, options.confidence)} (Wilks): values below the largest are estimates.",
        "ECSS-E-ST-60-10C names errors of these kinds and statistics; its text was not at hand, and no clause of it is "
        "cited. The sums are the plain ones: linear, and the root of the sum of squares of what each adds.",
    ]
    if "estimator" not in facts.blocks:
        notes.append("There is no block estimator: errors of knowledge are not told.")
    return Section("Pointing budget", tables, _figures(facts, flown), notes)


def _confidence(flights: int, share: float) -> str:
    return f"{100.0 * budget.largest_covers(flights, share):.3g}%"


def _statistics(options: Options, flights: Mapping[int, Array]) -> Mapping[str, budget.Statistics]:
    return budget.of_flights(list(flights.values()), INTERVAL, options.window, options.drift, options.confidence)


def _after_tumbles(kind: str, index: str, rows: Rows, confidence: float) -> list[str]:
    """Returns what a share of the tumbles has at most in the second orbit, and the worst; dashes where none is kept."""
    name = f"{index}_error" if kind == "pointing" else "knowledge_error" if index == "absolute" else ""
    if name not in {metric["name"] for metric in rows.manifest["metrics"]}:
        return ["–", "–"]
    values = rows.numbers(name)
    values = np.where(np.isnan(values), np.inf, values)
    found = [budget.quantile(values, confidence), float(values.max())]
    return [_deg(math.radians(v) if tumbles.in_degrees(name) else v) for v in found]


def _by_contributor(facts: Facts, options: Options, kind: str, by_case: Mapping[str, Mapping[int, Array]]) -> Table:
    """Returns the mixed statistics of each contributor alone, and both sums beside all together; and by how much all
    errors are less without it, of flights with the same draws."""
    count = members(options, NONE)
    kept = {case: {i: e for i, e in flights.items() if i < count} for case, flights in by_case.items()}
    each = {case: _statistics(options, flights) for case, flights in kept.items()}
    alike = {(case, i): _statistics(options, {i: e}) for case, flights in kept.items() for i, e in flights.items()}

    def value(case: str, index: str) -> float:
        return each[case][index].mixed if case in each else math.nan

    def less(case: str, index: str) -> str:
        both = [i for i in kept.get(ALL, {}) if i in kept.get(case, {})]
        whole, without = ([alike[one, i][index].mixed for i in both] for one in (ALL, case))
        mean, spread = budget.difference(whole, without, options.confidence)
        if math.isnan(spread):
            return "one flight" if both else "–"
        return f"{_deg(mean)} ± {_deg(spread)}" if abs(mean) > spread else f"not distinguishable: ± {_deg(spread)}"

    shown = ("absolute", "relative")
    rows = []
    for name in studies.contributors(facts):
        told = ((_deg(value(f"{name} alone", index)), less(f"without {name}", index)) for index in shown)
        rows.append([name, *(text for pair in told for text in pair)])
    rows.append(["none of them", *(text for index in shown for text in (_deg(value(NONE, index)), "–"))])
    sums = {
        index: budget.summed(value(NONE, index), [value(f"{n} alone", index) for n in studies.contributors(facts)])
        for index in shown
    }
    for place, name in enumerate(("linear sum", "root of the sum of squares")):
        rows.append([name, *(text for index in shown for text in (_deg(sums[index][place]), "–"))])
    rows.append([ALL, *(text for index in shown for text in (_deg(value(ALL, index)), "–"))])
    columns = ["contributor", *(f"{index}, {case}, deg" for index in shown for case in ("alone", "less without it"))]
    return Table(
        f"Errors of {kind} by contributor",
        columns,
        rows,
        f"Alone: mixed statistics of {count} flight{'s' * (count > 1)}. Less without it: mean over the same of what "
        f"each has less, with its interval at {100.0 * options.confidence:.4g}% by Student's t; not distinguishable: "
        "zero lies in an interval of this half width. A sum above the value of all together is on the safe side; "
        "one below it says that the errors act together, and that the loop is not linear in them.",
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
    return f"{math.degrees(value):.3g}" if math.isfinite(value) else "–"
