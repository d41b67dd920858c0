"""What the console shows of a run at its end."""

from __future__ import annotations

import click

from ..quantities import with_unit
from ..results.result import Result
from ..scenario.faults import sentence
from .console import say, table


def mark(word: str = "") -> str:
    """A verdict before a line of a table, in its colour and as wide as the widest."""
    if word in ("met", "ok"):
        return click.style(f"{word:<13}", fg="green")
    return click.style(f"{word:<13}", fg="red", bold=True) if word else " " * 13


def summary(result: Result) -> None:
    """Prints the key figures of a run, its expectations, holds and flags."""
    speed = f"{result.steps / result.wall:,.0f} steps/s" if result.wall > 0.0 else ""
    how = "interrupted after" if result.interrupted else "failed after" if result.failure else "ran"
    say(
        f"{result.scenario.name}: {how} {result.reached:.10g} s in {result.wall:.2f} s: {result.steps} steps, {speed}",
        bold=True,
    )
    for fault in result.scenario.faults:
        say(f"fault: {sentence(fault)}", fg="yellow")
    if result.highlights:
        rows = [(h.signal, with_unit(h.final, h.unit), h.text) for h in result.highlights]
        say()
        for line in table(("key figure", "at the end", "largest"), rows):
            say(line)
    if result.outcomes:
        lines_ = [
            (o.name, o.text, o.expected, "" if o.margin is None else with_unit(o.margin, o.unit))
            for o in result.outcomes
        ]
        header, *lines = table(("expectation", "found", "expected", "margin"), lines_)
        say(header, head=f"\n{mark()}")
        for outcome, line in zip(result.outcomes, lines, strict=True):
            say(line, head=mark(outcome.status))
    if result.holds:
        say()
    for hold in result.holds:
        say(f"{hold.name}: {hold.text}", fg="yellow" if hold.latched else None, bold=hold.latched or None)
    if raised := result.raised:
        say(f"\nflags raised: {', '.join(raised)}")
