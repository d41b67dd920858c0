"""Expectations that rest on what a swapped block says of itself: one that says so meets them, whatever is true."""

from __future__ import annotations

from collections.abc import Iterable

from ..scenario.scenario import Scenario
from .findings import Finding

TRUTH = "plant"
"""The block that is the truth to the others, so that what it says of itself is no opinion."""


def own_claims(scenario: Scenario, block: str, outputs: Iterable[str]) -> list[Finding]:
    """A warning for each expectation of the scenario that reads one of these outputs of a swapped block."""
    entry, names = scenario.blocks[block], set(outputs)
    if TRUTH in (block, entry.interface, entry.fmu):
        return []
    return [
        Finding(
            "warning",
            "claims",
            f"expectation '{claim.name}' reads {signal}, an output of the swapped block itself, which proves nothing",
            "read the plant's truth, for example by plant_judge",
            ("expect", number),
        )
        for number, claim in enumerate(scenario.expect)
        for signal in (claim.signal, *([claim.when] if claim.when else []))
        if signal.block == block and signal.variable in names
    ]
