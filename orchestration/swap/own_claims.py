"""Expectations that rest on what a swapped block says of itself: one that says so meets them, whatever is true."""

from __future__ import annotations

from collections.abc import Iterable

from fmus.interface import TRUTH

from ..scenario.scenario import Scenario
from .findings import Finding


def own_claims(scenario: Scenario, block: str, outputs: Iterable[str]) -> list[Finding]:
    """Returns a warning for each expectation of the scenario that reads one of these outputs of a swapped block."""
    entry, names = scenario.blocks[block], set(outputs)
    if TRUTH.keys() & {block, entry.interface, entry.fmu}:
        return []
    return [
        Finding(
            "warning",
            "claims",
            f"expectation '{claim.name}' reads {signal}, an output of the swapped block itself, which proves nothing",
            f"read {' or '.join(TRUTH.values())}",
            ("expect", number),
        )
        for number, claim in enumerate(scenario.expect)
        for signal in (claim.signal, *([claim.when] if claim.when else []))
        if signal.block == block and signal.variable in names
    ]
