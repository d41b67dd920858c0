"""Requirements held against what was flown: verdict, margin, number of runs, seeds, and the worst case with its replay.

Requirement: RV-1. Tests: tests/design/review/test_verify.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from orchestration.campaign.flying.rows import Rows
from orchestration.campaign.statistics.verdicts import Requirement, verdicts
from orchestration.quantities import Unit, with_unit

from . import tumbles
from .content import Section, Table
from .manoeuvres import Worst
from .options import DRAWN, METRICS, RADIAN, Asked, Options

COLUMNS = ["id", "requirement", "limit", "required", "verdict", "margin", "runs, seed", "worst case", "why"]


def section(options: Options, rows: Rows, single: Mapping[str, Worst], latest: float) -> tuple[Section, list[str]]:
    """Returns a row for each requirement, and the verdicts; `single` has the metrics that one flight or none
    gives, with its name. A time later than `latest`, s, is none: tumbles.last_moment."""
    if not options.requirements:
        text = "No requirements were given: --requirements FILE takes a list with id, text, metric, limit, probability."
        return Section("Requirements", notes=[text]), []
    lines = [_line(one, options, rows, single, latest) for one in options.requirements]
    notes = [
        "Met: the lower bound of the probability, at the confidence asked for, is at least the one required. Not met: "
        "the upper bound is below it. Undecided: neither; --runs with more of them decides.",
    ]
    if any(one.wrong for one in options.requirements):
        notes.append(f"Metrics of a review: {', '.join(METRICS)}.")
    return Section("Requirements", [Table("Requirements", COLUMNS, lines)], notes=notes), [row[4] for row in lines]


def _line(one: Asked, options: Options, rows: Rows, single: Mapping[str, Worst], latest: float) -> list[str]:
    required = f"{one.probability:g} at {100 * one.confidence:g}%"
    head = [one.id, one.text, f"{one.metric} {one.limit}"]
    if one.wrong:
        return [*head, required, "not verifiable", "–", "–", "–", one.wrong]
    study, unit, _ = METRICS[one.metric]
    if study != DRAWN:
        return _of_one(one, head, *single.get(one.metric, (math.nan, "")), study)
    if one.metric not in {m["name"] for m in rows.manifest["metrics"]}:
        return [
            *head,
            required,
            "not verifiable",
            "–",
            "–",
            "–",
            "the tumbles have no value of it: no estimator to judge, or a window or drift longer than an orbit",
        ]
    met, count, margin = tumbles.counted(rows, one, latest)
    verdict = verdicts([Requirement(one.id, one.probability, one.confidence)], {one.id: met}, count)[0]
    worst = tumbles.worst(rows, one, latest)
    replay = f"run {worst}: orchestrate campaign tumbles.yaml --out tumbles --replay {worst}"
    shown = _told(margin, unit) if math.isfinite(margin) else "none: it is never met by that share"
    return [*head, required, verdict.status, shown, f"{count}, seed {options.seed}", replay, verdict.text]


def _told(value: float, unit: Unit) -> str:
    """Returns a value with its unit, an angle in degrees."""
    return with_unit(math.degrees(value), "deg") if unit == RADIAN else with_unit(value, unit.name)


def _of_one(one: Asked, head: list[str], value: float, flight: str, study: str) -> list[str]:
    """Returns the row of a metric without an ensemble, of which no probability can be said."""
    if math.isnan(value):
        return [
            *head,
            "–",
            "not verifiable",
            "–",
            "–",
            "–",
            f"the review has no value of {one.metric} for this scenario",
        ]
    bound = one.below if one.below is not None else one.above
    assert bound is not None
    margin = bound - value if one.below is not None else value - bound
    status = "met" if margin > 0.0 else "not met"
    unit = METRICS[one.metric][1]
    shown = _told(margin, unit) if math.isfinite(margin) else "–"
    found = _told(value, unit) if math.isfinite(value) else "never"
    why = f"{study}: {found}, {METRICS[one.metric][2]}; single flights, no probability"
    replay = f"orchestrate flights/{flight}.yaml" if flight else "–"
    return [*head, "–", status, shown, "1" if flight else "–", replay, why]
