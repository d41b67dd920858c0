"""The console: lines, colours, streams that are closed or full, and the progress of a run."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from time import perf_counter
from typing import Any, TextIO

import click

from ..errors import printable, printable_json

_PATIENCE = 0.3
"""Seconds that a run may last without a progress bar."""
_lost: list[OSError] = []
"""Why what was to be printed could not be."""


def say(text: str = "", error: bool = False, head: str = "", **style: Any) -> None:
    """Prints a line; colours only on a terminal, and not where NO_COLOR is set. It ends nothing where it cannot.

    Control characters of the text are escaped, since it may hold what an FMU or an archive says. `head` is put before
    it as it is, in its own colours.
    """
    text = printable(text)
    try:
        click.echo(
            head + (click.style(text, **style) if style else text),
            err=error,
            color=False if os.environ.get("NO_COLOR") else None,
        )
    except OSError as problem:
        silence(error)
        if not error and not isinstance(problem, BrokenPipeError):  # who closes a pipe has seen enough
            _lost.append(problem)
            complain(f"what was to be printed cannot be written: {problem.strerror}")


def say_json(data: Any) -> None:
    """Prints data as JSON."""
    click.echo(printable_json(json.dumps(data, indent=2, ensure_ascii=False)))


def silence(error: bool = False) -> None:
    """Lets all that is still printed vanish, also what lies in buffers when the program ends."""
    stream = sys.stderr if error else sys.stdout
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def lost() -> bool:
    """Whether something could not be printed, since the last time this was asked."""
    found = bool(_lost)
    _lost.clear()
    return found


def open_streams() -> None:
    """Opens those of the three standard streams that are closed, so that no file of a run takes their place."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the first number that is free


def complain(message: str) -> None:
    say(message, error=True, fg="red")


def notes(warnings: Iterable[str]) -> None:
    """Prints the warnings of a run."""
    for warning in warnings:
        say(f"note: {warning}", error=True, fg="yellow")


class _Builds(logging.Handler):
    """Prints which FMU is being built, but for a command with --quiet."""

    def emit(self, record: logging.LogRecord) -> None:
        context = click.get_current_context(silent=True)
        if context is None or not context.params.get("quiet"):
            say(record.getMessage(), error=True)


def tell_builds(context: click.Context) -> None:
    """Prints on a terminal, until the command ends, which FMU is being built, since that takes seconds."""
    if not is_terminal(sys.stderr):
        return
    log, handler = logging.getLogger("attitude_cosim.build"), _Builds()
    log.setLevel(logging.INFO)
    log.addHandler(handler)
    context.call_on_close(lambda: log.removeHandler(handler))


def is_terminal(stream: TextIO | None) -> bool:
    return stream is not None and stream.isatty()


class Progress:
    """A bar with the simulated time, for runs that last long enough."""

    def __init__(self, duration: float, wanted: bool) -> None:
        self.duration, self.wanted = duration, wanted and is_terminal(sys.stdout)
        self._begun = perf_counter()
        self._bar: Any = None
        self._task: Any = None

    def __call__(self, time: float) -> None:
        if not self.wanted or perf_counter() - self._begun < _PATIENCE:
            return
        if self._bar is None:
            from rich import progress  # here, since it takes longer than a short run  # noqa: PLC0415

            text = progress.TextColumn(f"{{task.completed:.1f}} / {self.duration:.10g} s")
            share = progress.TextColumn("{task.percentage:.0f}%")
            self._bar = progress.Progress(
                text, progress.BarColumn(), share, progress.TimeRemainingColumn(), transient=True
            )
            self._task = self._bar.add_task("run", total=self.duration)
            self._bar.start()
        self._bar.update(self._task, completed=time)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table, its columns in line."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    return ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in [header, *rows]]
