"""Finds what the standard forbids of variables that share a value reference."""

from __future__ import annotations

from typing import Any

from ..fmu.aliases import aliases, listed, set_together
from ..swap.findings import Finding


def look(description: Any, findings: list[Finding]) -> None:
    """Adds what the standard forbids of the aliases; and a note of those that it allows among inputs and outputs."""
    for alike, text in aliases(description):
        if wrong := _wrong(alike):
            findings.append(Finding("error", "alias", f"{text}{wrong}", "correct it in the exporting tool"))
        elif any(v.causality in ("input", "output") for v in alike):
            findings.append(
                Finding("note", "alias", f"{text}: each has the value of the others", "none needed, if that is meant")
            )


def _wrong(alike: list[Any]) -> str:
    """Returns what is wrong with variables of one type and reference; empty where nothing is."""
    if text := set_together(alike):
        return text
    constant = [v for v in alike if v.variability == "constant"]
    if constant and len(constant) < len(alike):
        are = "is" if len(constant) == 1 else "are"
        return f", of which {listed(constant)} {are} constant; expected all of them or none"
    if len(starts := {v.start for v in constant}) > 1:
        return f", constants with the start values {', '.join(map(str, sorted(starts, key=str)))}; expected one value"
    if len(units := {unit for v in alike if v.type == "Real" and (unit := _unit(v))}) > 1:
        return f", in the units {', '.join(sorted(units))}; expected one unit"
    return ""


def _unit(variable: Any) -> str | None:
    declared = variable.declaredType
    unit: str | None = variable.unit if variable.unit is not None or declared is None else declared.unit
    return unit
