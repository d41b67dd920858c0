"""Variables that share a value reference: aliases of one another, as FMI 2.0 allows them (2.2.7)."""

from __future__ import annotations

from itertools import groupby
from typing import Any

from ..swap.findings import Finding

_BASE = {"Enumeration": "Integer"}
"""Value references are counted apart for each type of fmi2SetXXX, and fmi2SetInteger sets enumerations."""
_SET = ("input", "parameter")


def look(description: Any, findings: list[Finding]) -> None:
    """Adds what the standard forbids of the aliases; and a note of those that it allows among inputs and outputs."""
    by_reference = sorted(description.modelVariables, key=_place)
    for (base, reference), group in groupby(by_reference, key=_place):
        alike = list(group)
        if len(alike) < 2:
            continue
        text = f"{_listed(alike)} share the value reference {reference} of type {base}"
        if wrong := _wrong(alike):
            findings.append(Finding("error", "alias", f"{text}{wrong}", "correct it in the exporting tool"))
        elif any(v.causality in ("input", "output") for v in alike):
            findings.append(
                Finding("note", "alias", f"{text}: each has the value of the others", "none needed, if that is meant")
            )


def _place(variable: Any) -> tuple[str, int]:
    return _BASE.get(variable.type, variable.type), variable.valueReference


def _wrong(alike: list[Any]) -> str:
    """What is wrong with variables of one type and reference; empty where nothing is."""
    if len(settable := [v for v in alike if v.causality in _SET]) > 1:
        return f", and {_listed(settable)} can be set; expected at most one that can, since a value set for one is set for all"
    constant = [v for v in alike if v.variability == "constant"]
    if constant and len(constant) < len(alike):
        return f", of which {_listed(constant)} {'is' if len(constant) == 1 else 'are'} constant; expected all of them or none"
    if len(starts := {v.start for v in constant}) > 1:
        return f", constants with the start values {', '.join(map(str, sorted(starts, key=str)))}; expected one value"
    if len(units := {unit for v in alike if v.type == "Real" and (unit := _unit(v))}) > 1:
        return f", in the units {', '.join(sorted(units))}; expected one unit"
    return ""


def _unit(variable: Any) -> str | None:
    declared = variable.declaredType
    unit: str | None = variable.unit if variable.unit is not None or declared is None else declared.unit
    return unit


def _listed(variables: list[Any]) -> str:
    names = [v.name for v in variables[:5]] + ([f"{len(variables) - 5} more"] if len(variables) > 5 else [])
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
