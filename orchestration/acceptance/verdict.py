"""Puts a comparison in words: what was compared, the rows of its table, and the verdict.

Tests: tests/orchestration/acceptance/test_compare.py, test_words.py.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ..quantities import with_unit
from .compare import Comparison
from .difference import ROUNDING, Difference
from .polarity.mend import in_words
from .polarity.mend import summary as of_mended

DIFFERENCES = ("output", "our largest", "largest difference", "rms difference", "tolerance", "when")
"""The columns of the open loop."""


def summary(comparison: Comparison) -> dict[str, Any]:
    """Returns the comparison as plain data."""
    return {
        "block": comparison.block,
        "fmu": comparison.fmu,
        "passed": comparison.passed,
        "equivalent": comparison.equivalent,
        "verdict": verdict(comparison),
        "meaning": meaning(comparison),
        "claims_hold": comparison.met,
        "failure": None if comparison.failure is None else str(comparison.failure),
        "instants": comparison.instants,
        "interval": comparison.interval,
        "end": comparison.end,
        "open_loop": [asdict(difference) for difference in comparison.differences],
        "explained": None if comparison.mended is None else of_mended(comparison.mended),
        "claims": [
            {"name": a.name, "ours": asdict(a), "theirs": None if b is None else asdict(b)}
            for a, b in comparison.claims
        ],
        "notes": comparison.theirs.warnings,
    }


def verdict(comparison: Comparison) -> str:
    """Returns the verdict in a sentence."""
    compared = [d for d in comparison.differences if d.largest is not None]
    within = sum(d.passed for d in compared)
    outcomes = comparison.theirs.outcomes
    met = sum(outcome.passed for outcome in outcomes)
    left = len(comparison.ours.outcomes) - len(outcomes)
    how = (
        "not equivalent"
        if not comparison.equivalent
        else "equivalent within wide tolerances"
        if wide(comparison)
        else "equivalent"
    )
    text = f"{how}: {within} of {len(compared)} outputs within tolerance; "
    text += f"{met} of {len(outcomes)} expectations met" + (f", {left} not evaluated" if left else "")
    return f"an FMU failed; {text}" if comparison.failure is not None else text


def colour(comparison: Comparison) -> str:
    """Returns the colour of the verdict: a difference that is no small one is not shown in green."""
    return "red" if not comparison.passed else "yellow" if wide(comparison) else "green"


def wide(comparison: Comparison) -> list[Difference]:
    """Returns the differences that only a wide tolerance allows."""
    return [difference for difference in comparison.differences if difference.wide]


def meaning(comparison: Comparison) -> list[str]:
    """Returns sentences that say what was compared, and what the verdict rests on."""
    every = f", every {comparison.interval:.10g} s" if comparison.interval else ""
    sentences = [
        "Equivalent means: given what ours was given in its run, theirs gave each output within its tolerance "
        f"at {comparison.instants} instants{every}, from 0 to {comparison.end:.10g} s.",
        "The largest difference is that of all elements and instants, "
        "the rms difference that of the worst element over all instants; "
        "beside each, in brackets, its share of our largest value.",
        f"A difference up to {ROUNDING:g} of the nominal value (1 in the output's unit, where the FMU declares none) "
        "is rounding and counts as 0.",
    ]
    for d in wide(comparison):
        what = d.note + " differ" if d.note else f"its largest difference is {d.share:.2g} of our largest value"
        sentences.append(f"{d.output}: {what}; only its tolerance, {d.tolerance}, allows that.")
    return sentences


def explanation(comparison: Comparison) -> list[str]:
    """Returns what explains the difference on the same inputs, or that nothing does; empty where there is none."""
    return in_words(comparison.mended) if comparison.mended is not None else []


def status(difference: Difference) -> str:
    """Returns the status of an output in a word; empty where nothing was compared."""
    if difference.largest is None:
        return "" if difference.passed else "differs"
    return "differs" if not difference.passed else "allowed" if difference.wide else "ok"


def rows_of_differences(comparison: Comparison) -> list[tuple[str, tuple[str, ...]]]:
    """Returns the status and the cells of each output, as DIFFERENCES names them."""
    return [(status(d), _cells(d)) for d in comparison.differences]


def _cells(d: Difference) -> tuple[str, ...]:
    if d.largest is None:
        return d.output, "", d.note, "", "", ""
    when = f"{d.time:.5g} s" if d.time is not None else ""
    if d.note:
        return d.output, "", f"{d.note} ({d.share:.2g})", "", d.tolerance, when and f"first at {when}"
    at = f"{d.element} at {when}" if d.element else when
    largest, rms = (
        "0" if value <= d.zero else with_unit(value, d.unit) + ("" if share is None else f" ({share:.2g})")
        for value, share in ((d.largest, d.share), (d.rms or 0.0, d.rms_share))
    )
    scale = d.scale or 0.0
    return d.output, "0" if scale <= d.zero else with_unit(scale, d.unit), largest, rms, d.tolerance, at
