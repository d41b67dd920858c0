"""The console: lines, colours, streams that are closed or full, and the progress of a run."""

from __future__ import annotations

import json
import logging
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from itertools import zip_longest
from pathlib import Path
from textwrap import wrap
from time import perf_counter
from typing import Any, TextIO

import click

from ..errors import printable, printable_json, reason

_PATIENCE = 0.3
"""Seconds that a run may last without a progress bar."""
_WORD = 8
"""Letters of a word up to which the narrowest table leaves it in one piece."""
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
            complain(f"what was to be printed cannot be written: {reason(problem)}")


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
        say(folded(f"note: {warning}"), error=True, fg="yellow")


def is_quiet() -> bool:
    """Whether the command that runs was given --quiet."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.params.get("quiet"))


class _Builds(logging.Handler):
    """Prints which FMU is being built, but for a command with --quiet or --json."""

    def emit(self, record: logging.LogRecord) -> None:
        context = click.get_current_context(silent=True)
        if not is_quiet() and not (context and context.params.get("json_")):
            say(record.getMessage(), error=True)


def tell_builds(context: click.Context) -> None:
    """Prints on standard error, until the command ends, which FMU is being built, since that takes seconds."""
    log, handler = logging.getLogger("attitude_cosim.build"), _Builds()
    log.setLevel(logging.INFO)
    log.addHandler(handler)
    context.call_on_close(lambda: log.removeHandler(handler))


def is_terminal(stream: TextIO | None) -> bool:
    return stream is not None and stream.isatty()


class Progress:
    """A bar with the simulated time, or a count of what is done, for runs that last long enough."""

    def __init__(self, duration: float, wanted: bool, counted: str = "") -> None:
        self.duration, self.wanted, self.counted = duration, wanted and is_terminal(sys.stdout), counted
        self.status: Callable[[], str] | None = None
        """A few words that stand behind the bar."""
        self._begun = perf_counter()
        self._bar: Any = None
        self._task: Any = None

    def __call__(self, time: float) -> None:
        if not self.wanted or perf_counter() - self._begun < _PATIENCE:
            return
        if self._bar is None:
            from rich import progress  # here, since it takes longer than a short run  # noqa: PLC0415

            places, unit = (0, self.counted) if self.counted else (1, "s")
            text = progress.TextColumn(f"{{task.completed:.{places}f}} / {self.duration:.10g} {unit}")
            share = progress.TextColumn("{task.percentage:.0f}%")
            status = progress.TextColumn("{task.fields[status]}")
            self._bar = progress.Progress(
                text, progress.BarColumn(), share, progress.TimeRemainingColumn(), status, transient=True
            )
            self._task = self._bar.add_task("run", total=self.duration, status="")
            self._bar.start()
        self._bar.update(self._task, completed=time, status=self.status() if self.status else "")

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()


def width() -> int | None:
    """The columns of the terminal, or those that COLUMNS states; None where lines may have any length."""
    if not is_terminal(sys.stdout) and not os.environ.get("COLUMNS"):
        return None
    return shutil.get_terminal_size().columns


def table(header: Sequence[str], rows: Sequence[Sequence[str]], indent: int = 0) -> list[str]:
    """Lines of a table, its columns in line; where a terminal is narrower, long cells run over several lines.

    `indent` is the width of what is printed before each line; what runs on is moved by it.
    """
    cells = [[printable(cell) for cell in row] for row in [header, *rows]]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    limit = width()
    room = sum(widths) if limit is None else limit - indent - 2 * (len(widths) - 1)
    words = [max(len(word) for cell in column for word in cell.split() or [""]) for column in zip(*cells, strict=True)]
    longest = next((n for n in range(max(words), _WORD, -1) if sum(min(word, n) for word in words) <= room), _WORD)
    floors = [min(word, longest) for word in words]
    room = max(room, sum(floors))
    while sum(widths) > room:
        spare = [w - floor for w, floor in zip(widths, floors, strict=True)]
        widest = max((w for w, left in zip(widths, spare, strict=True) if left > 0))
        widths[next(i for i, w in enumerate(widths) if w == widest and spare[i] > 0)] -= 1
    return [_row(row, widths, " " * indent) for row in cells]


def _row(cells: Sequence[str], widths: Sequence[int], indent: str) -> str:
    parts = [wrap(cell, w, break_on_hyphens=False) for cell, w in zip(cells, widths, strict=True)]
    lines = zip_longest(*parts, fillvalue="") if any(parts) else [["" for _ in parts]]
    filled = ("  ".join(part.ljust(w) for part, w in zip(line, widths, strict=True)).rstrip() for line in lines)
    return f"\n{indent}".join(filled)


def folded(text: str, indent: str = "") -> str:
    """A text in lines that fit the terminal, each after the indent."""
    limit = width()
    lines = text.splitlines()
    if limit is not None:
        room = max(limit - len(indent), 20)
        lines = [part for line in lines for part in wrap(line, room, break_on_hyphens=False) or [""]]
    return "\n".join(indent + line for line in lines)


def open_page(page: Path) -> None:
    """Opens a page in the browser; where there is none, or no screen, says where the page is."""
    import webbrowser  # here, since it takes time and most commands open nothing  # noqa: PLC0415

    linux = sys.platform.startswith("linux")
    blind = linux and not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
    if blind or not webbrowser.open(page.absolute().as_uri()):
        say(f"note: there is no browser here; the page is {page.absolute()}", error=True, fg="yellow")
