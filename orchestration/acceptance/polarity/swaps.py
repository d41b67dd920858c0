"""Proposes a mapping of a swapped FMU where none is given, and mends it where it is wrong.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...scenario.load import load
from ...scenario.scenario import Scenario
from ...scenario.source import Source
from ...scenario.text import parse
from ...swap.findings import unfed
from ..check import check
from ..suggest import suggest
from .apart import flown
from .fly import Found, Loop
from .mend import Mended, mend


@dataclass
class Looked:
    """A scenario with swapped FMUs, and what was done so that it flies as ours."""

    source: Source
    """With the mappings that are proposed or mended."""
    proposed: dict[str, str] = field(default_factory=dict)
    """By block: the mapping proposed, as YAML."""
    ignored: dict[str, list[str]] = field(default_factory=dict)
    """By block: inputs of ours that the mapping proposed ignores, since no input of theirs is left for them."""
    wrong: Found | None = None
    """The first that the loop as wired did not meet."""
    mended: list[Mended] = field(default_factory=list)
    left: Found | None = None
    """The first that it does not meet in the end."""


def look(ours: Source, theirs: Source, blocks: Sequence[str]) -> Looked:
    """Proposes and mends mappings of the swapped blocks, as far as that is needed. Raises InputError and BlockError."""
    looked = Looked(theirs)
    for block in blocks:
        if (text := proposal(load(looked.source), block)) is not None:
            looked.proposed[block] = text
            data: Any = parse(text, f"the mapping proposed for {block}").data
            looked.source = looked.source.with_entry(("blocks", block, "map"), data)
    loop = Loop(looked.source)
    for block in looked.proposed:
        ignored = loop.opened.prepared.fits[block].ignored.values()
        looked.ignored[block] = [variable.name for variable in ignored if variable.causality == "input"]
    looked.wrong, failure = flown(looked.source)
    looked.left = looked.wrong
    for block in blocks:
        found = mend(ours, looked.source, block)
        looked.mended.append(found)
        if found.behaves:
            looked.source = looked.source.with_entry(("blocks", block, "map"), found.mapping)
    if any(found.behaves for found in looked.mended):
        looked.left = looked.mended[-1].left if len(blocks) == 1 else flown(looked.source)[0]
    elif failure is not None and failure.time is None:  # no wiring explains it: the FMU fails by itself
        raise failure
    return looked


def proposal(scenario: Scenario, block: str) -> str | None:
    """Returns the mapping proposed for a block; None where one is given, or the FMU fits without."""
    entry = scenario.blocks[block]
    if entry.map is not None or entry.interface is None:
        return None
    _findings, fitted = check(
        Path(scenario.source.folder / entry.fmu), entry.interface, lenient=entry.validation == "lenient"
    )
    if fitted is None or not any(f.level == "error" and not unfed(f) for f in fitted.findings):
        return None
    return suggest(fitted)
