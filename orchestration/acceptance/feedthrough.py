"""Finds out whether an FMU's direct feedthrough would close an algebraic loop with the project's other blocks.

Tests: tests/orchestration/acceptance/test_check.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..fmu.model import Element, Model
from ..swap.as_ours import model
from ..swap.findings import Finding, Fit
from ..system import order


def look(fitted: Fit, findings: list[Finding]) -> None:
    """Adds findings on loops that what it declares would close with the other blocks of the project."""
    theirs, ours = model(fitted), fitted.reference.model
    silent = [
        v.name
        for v in theirs.of("output")
        if v.name in ours.variables and theirs.feedthrough.get(v.elements[0]) is None
    ]
    if silent:
        depend = "depends" if len(silent) == 1 else "depend"
        text = (
            f"it does not say on which inputs {', '.join(silent)} {depend} directly; what our interface says is taken"
        )
        findings.append(Finding("warning", "feedthrough", text, "list the dependencies in its ModelStructure"))
    fed = frozenset(element for name in fitted.feeding for element in theirs.variables[name].elements)
    direct: dict[Element, frozenset[Element]] = {}
    for element, known in ours.feedthrough.items():
        declared = theirs.feedthrough.get(element)
        direct[element] = (known or frozenset()) | fed if declared is None else declared
    loops = _loops(fitted, theirs, direct)
    for loop in loops:
        text = f"an algebraic loop through {loop}: all of these depend on each other at one instant"
        remedy = "let it act on inputs of the step before, or break the loop by 'delays' in the scenario"
        findings.append(Finding("error", "feedthrough", text, remedy))
    more = sorted(
        {
            f"{e.variable} on {i.variable}"
            for e, known in direct.items()
            for i in known - (ours.feedthrough.get(e) or frozenset())
        }
    )
    if not loops and more:
        findings.append(
            Finding(
                "note", "feedthrough", f"depends directly where ours does not: {', '.join(more)}; no loop comes of it"
            )
        )
    elif not loops and not silent:
        findings.append(Finding("ok", "feedthrough", "closes no algebraic loop"))


def _loops(fitted: Fit, theirs: Model, direct: Mapping[Element, frozenset[Element]]) -> list[str]:
    interface = fitted.reference
    models = {**interface.others, interface.name: theirs}
    sources: dict[Element, list[tuple[str, Element]]] = {}
    for block, kind in models.items():
        for variable in kind.of("output"):
            for element in variable.elements:
                sources.setdefault(element, []).append((block, element))

    for name, signal in fitted.feeding.items():
        output = interface.others.get(signal.block, theirs).variables.get(signal.variable)
        if signal.block in interface.others and output is not None:
            into = theirs.variables[name].elements
            sources.update((e, [(signal.block, given) for given in output.elements]) for e in into)

    def needs(block: str, element: Element) -> list[tuple[str, Element]]:
        known = direct.get(element, frozenset()) if block == interface.name else models[block].feedthrough.get(element)
        inputs = (sources.get(e, []) for e in sorted(known or ()))
        return [source for several in inputs for source in several if source[0] != block]

    graph: Any = {source: needs(*source) for several in sources.values() for source in several}
    loops = []
    for group in order.components(graph):
        if len(group) > 1:
            loops.append(
                " -> ".join(dict.fromkeys(f"{block}.{e.variable}" for block, e in reversed(order.cycle(graph, group))))
            )
    return loops
