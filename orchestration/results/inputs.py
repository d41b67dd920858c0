"""The start values that a scenario states, as pages show them. Tests: tests/orchestration/results/test_report.py."""

from __future__ import annotations

import re
from typing import Any

from markupsafe import Markup

from ..scenario.scenario import Scenario
from .html import facts


def inputs(scenario: Scenario) -> Markup:
    """Returns the start values that the scenario states, shared ones first."""
    stated = [("", scenario.shared), *((f"{name}.", entry.start) for name, entry in scenario.blocks.items())]
    return facts({f"{of}{name}": value_text(value) for of, values in stated for name, value in values.items()})


def value_text(value: Any) -> str:
    """Returns a start value with its numbers to six figures."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(value_text, value))}]"
    if isinstance(value, dict):
        return ", ".join(f"{key} {value_text(item)}" for key, item in value.items())
    return re.sub(r"-?\d+\.\d{6,}(e[-+]?\d+)?", lambda match: f"{float(match[0]):.6g}", str(value))
