"""Looks at inputs that only theirs has and that the mapping connects: their signals, and what these are in a run.

Tests: tests/orchestration/acceptance/test_compare.py, tests/orchestration/swap/test_inputs.py.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..fmu.model import Floats
from ..results.result import Result
from ..scenario.references import Connection
from ..session.open import Opened
from ..swap.as_ours import model
from ..swap.findings import Finding, Fit
from ..system.wiring import Link, links


def look(fitted: Fit, findings: list[Finding]) -> None:
    """Holds each against the project's block of that name, with unit and shape. A scenario may have other blocks."""
    others, name = fitted.reference.others, fitted.reference.name
    for theirs, signal in fitted.fed.items():
        key = f"input {theirs} = {signal}"
        if signal.block not in others:
            text = f"{key}: whether a scenario has the block {signal.block} is seen when it runs"
            findings.append(Finding("note", "input", text, "none needed"))
            continue
        try:
            _, warnings = links(Connection(f"{signal} -> {name}.{theirs}"), {**others, name: model(fitted)}, {})
        except InputError as error:
            remedy = "connect a signal of its unit and shape, each element of its own if need be"
            findings.append(Finding("error", "input", f"{key}: {error}", remedy))
        else:
            findings += [Finding("warning", "input", warning, "declare the unit in the FMU") for warning in warnings]


def theirs_alone(swapped: Opened, block: str) -> list[Link]:
    """Returns the links of a swapped block to inputs that only theirs has."""
    fit = swapped.prepared.fits.get(block)
    feeding = fit.feeding if fit is not None else {}
    wired = swapped.plan.wiring.links
    return [link for link in wired if link.target[0].block == block and link.target[0].element.variable in feeding]


def given(ours: Result, links: Sequence[Link], swapped: Opened) -> dict[str, Floats]:
    """Returns what these would have passed in the run of ours, (instants, *shape) by input, in the inputs' units."""
    values: dict[str, Floats] = {}
    instants = len(ours.time)
    for link in links:
        for source, target in zip(link.source, link.target, strict=True):
            variable = swapped.prepared.models[target.block].variables[target.element.variable]
            into = values.setdefault(variable.name, np.zeros((instants, *variable.shape))).reshape(instants, -1)
            rows = ours[f"{source.block}.{source.element.variable}"].reshape(instants, -1)
            into[:, target.element.position] = link.factor * rows[:, source.element.position] + link.offset
    return values
