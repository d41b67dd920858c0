"""Variables of FMI 2.0 that share a value reference: aliases of one another (2.2.7)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

_BASE = {"Enumeration": "Integer"}
"""Value references are counted apart for each type of fmi2SetXXX, and fmi2SetInteger sets enumerations."""
_SET = ("input", "parameter")


def aliases(description: Any) -> Iterator[tuple[list[Any], str]]:
    """The variables of each shared value reference of a description of FMI 2.0, and a sentence that says so."""
    by_reference = sorted(description.modelVariables, key=_place)
    for (base, reference), group in groupby(by_reference, key=_place):
        if len(alike := list(group)) > 1:
            yield alike, f"{listed(alike)} share the value reference {reference} of type {base}"


def set_together(alike: Sequence[Any]) -> str:
    """Returns what is wrong where a value that is set for one is set for another, too; empty where nothing is."""
    settable = [v for v in alike if v.causality in _SET]
    if len(settable) < 2:
        return ""
    return (
        f", and {listed(settable)} can be set; expected at most one that can, since a value set for one is set for all"
    )


def listed(variables: Sequence[Any]) -> str:
    """Their names as text."""
    names = [v.name for v in variables[:5]] + ([f"{len(variables) - 5} more"] if len(variables) > 5 else [])
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]


def _place(variable: Any) -> tuple[str, int]:
    return _BASE.get(variable.type, variable.type), variable.valueReference
