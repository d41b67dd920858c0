"""Prints what the console shows of a run at its end. Tests: tests/orchestration/cli/test_cli.py."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..quantities import with_unit
from ..results.result import Result
from ..system import acting
from .console import folded, notes, say, say_table

_LISTED = 5
"""Late steps that are printed."""


def colour(status: str) -> str:
    """Returns the colour of a verdict: red for all that is neither met nor left open."""
    colours = {"met": "green", "ok": "green", "not evaluated": "yellow", "allowed": "yellow", "undecided": "yellow"}
    return colours.get(status, "bold red")


def judged(header: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> None:
    """Prints a table, before each row its status in its colour."""
    if rows:
        say_table(("", *header), [(status, *cells) for status, cells in rows], [colour(status) for status, _ in rows])


def save(result: Result, folder: Path, format_: str = "csv") -> None:
    """Writes the folder of a run, and prints what could not be written there, also with --quiet."""
    noted = len(result.warnings)
    result.save(folder, format_)
    notes(result.warnings[noted:])


def summary(result: Result) -> None:
    """Prints the key figures of a run, its expectations, holds and flags."""
    speed = f"{result.steps / result.wall:,.0f} steps/s" if result.wall > 0.0 else ""
    how = "interrupted after" if result.interrupted else "failed after" if result.failure else "ran"
    say(
        f"{result.scenario.name}: {how} {result.reached:.10g} s in {result.wall:.2f} s: {result.steps} steps, {speed}",
        bold=True,
    )
    if result.pace is not None:
        say(folded(f"real time: {result.pace.summary}"), fg="yellow" if result.pace.late_steps else None)
        for late in result.pace.listed[:_LISTED]:
            say(folded(f"  {late.text}"), fg="yellow")
        if len(result.pace.listed) > _LISTED:
            say("  more of them are in the report and in the manifest", fg="yellow")
    for fault in acting.fault_sentences(result.scenario, result.models, result.reached):
        say(f"fault: {fault}", fg="yellow")
    for text in acting.timeline_sentences(result.scenario, result.reached):
        say(f"timeline: {text}")
    if result.highlights:
        rows = [(h.signal, with_unit(h.final, h.unit), h.text) for h in result.highlights]
        say()
        say_table(("key figure", "at the end", "largest"), rows)
    if result.settled:
        say()
        kept = [(one.signal, one.expected.removeprefix("always "), *one.texts) for one in result.settled]
        say_table(("settles", "for good", "from", "rms after", "largest after"), kept)
    if outcomes := [*result.outcomes, *result.not_evaluated]:
        say()
        margins = ["" if o.margin is None else with_unit(o.margin, o.unit) for o in outcomes]
        cells = [(o.status, (o.name, o.text, o.expected, m)) for o, m in zip(outcomes, margins, strict=True)]
        judged(("expectation", "found", "expected", "margin"), cells)
        if left := len(result.not_evaluated):
            met = sum(outcome.passed for outcome in result.outcomes)
            failed = f", {n} not met" if (n := len(result.outcomes) - met) else ""
            say(f"expectations: {met} met{failed}, {left} not evaluated", fg="yellow")
    if result.holds:
        say()
    for hold in result.holds:
        say(f"{hold.name}: {hold.text}", fg="yellow" if hold.latched else None, bold=hold.latched or None)
    if raised := result.raised:
        say(f"\nflags that were true: {'; '.join(raised)}")
