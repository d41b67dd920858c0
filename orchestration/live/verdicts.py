"""A scenario's expectations for a page's worker, which evaluates them after every base step as outcomes.py does."""

from __future__ import annotations

import math
from typing import Any

from ..expectations.checks import Check
from ..quantities import shown
from ..session.plan import Plan
from ..system.phases import Phase
from ..system.wiring import Node

OBSERVED = 1024
"""Base steps of which the page keeps what expectations look at, at a time."""


def observed(plan: Plan) -> list[Node]:
    """Returns what expectations look at after every base step."""
    return list(dict.fromkeys(node for check in plan.checks for node in check.needed))


def verdicts(plan: Plan) -> list[dict[str, Any]]:
    """Returns each expectation: where the observed values lie that it reads, its bound, and which samples count."""
    places = {node: i for i, node in enumerate(observed(plan))}
    return [_verdict(check, places) for check in plan.checks]


def _verdict(check: Check, places: dict[Node, int]) -> dict[str, Any]:
    expectation, limits, sight = check.expectation, check.limits, check.sight
    return {
        "name": expectation.name,
        "expected": check.expected,
        "unit": "" if expectation.zeros is not None else shown(limits.unit),
        "items": {f"{value:g}": name for value, name in check.items.items()},
        "columns": [places[node] for node in sight.nodes],
        "norm": expectation.measure == "norm",
        "factor": limits.factor,
        "offset": limits.offset,
        "low": _finite(limits.low),
        "high": _finite(limits.high),
        "strict": limits.strict,
        "how": "zeros" if expectation.zeros is not None else "always" if expectation.always else "ever",
        "zeros": expectation.zeros,
        "after": expectation.after,
        "before": expectation.before,
        "when": None if sight.when is None else places[sight.when],
        "phases": [_phase(phase, places) for phase in sight.during],
    }


def _phase(phase: Phase, places: dict[Node, int]) -> dict[str, Any]:
    return {
        "signal": None if phase.signal is None else places[phase.signal],
        "value": phase.value,
        "spans": [[begin, _finite(end)] for begin, end in phase.spans],
    }


def _finite(value: float) -> float | None:
    """Returns a number as JSON has it; None for infinity."""
    return value if math.isfinite(value) else None
