"""Finds the start values of an FMU that differ from ours. Tests: tests/orchestration/acceptance/test_check.py."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..fmu.model import Element
from ..quantities import suffix
from ..swap.as_ours import in_ours
from ..swap.findings import Finding, Fit, Link


def look(fitted: Fit, starts: Mapping[Element, Any], findings: list[Finding]) -> None:
    """Adds a note for each parameter and input."""
    differing = []
    for name, link in fitted.links.items():
        if link.ours.causality == "output" or not all(element in starts for element in link.theirs):
            continue
        theirs = in_ours(link, [starts[element] for element in link.theirs])
        ours = [fitted.reference.starts.get(element) for element in link.ours.elements]
        if theirs is not None and not all(_equal(a, b) for a, b in zip(theirs, ours, strict=True)):
            unit = suffix(link.ours.unit)
            differing.append(f"{name}: {_value(link, theirs)}{unit}, ours {_value(link, ours)}{unit}")
    for text in differing:
        findings.append(Finding("note", "start", text, "none needed where a scenario connects it or gives it a value"))


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, float) and isinstance(b, (int, float)):
        return abs(a - b) <= 1e-6 * max(abs(a), abs(b)) + 1e-12
    return bool(a == b)


def _value(link: Link, values: list[Any]) -> str:
    names = {number: item for item, number in link.ours.items}
    texts = [f"{v:.6g}" if isinstance(v, float) else str(names.get(v, v)) for v in values]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"
