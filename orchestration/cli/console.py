"""Prints lines, tables and the progress of a run, in colours, also where a stream is closed or full.

Tests: tests/orchestration/cli/test_cli.py, test_info.py, tests/orchestration/results/test_endings.py.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from io import StringIO
from itertools import zip_longest
from pathlib import Path
from textwrap import wrap
from time import perf_counter
from typing import Any, TextIO

import click

from ..errors import printable, printable_json, reason

_PATIENCE = 0.3
"""Seconds that a run may last without a progress bar."""
_WIDEST = 1_000_000
"""Columns of a table whose lines may have any length."""
_lost: list[OSError] = []
"""The errors of what could not be printed."""


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
    """Returns whether something could not be printed, since the last time this was asked."""
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
    """Returns whether the command that runs was given --quiet."""
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
        self.status: str | Callable[[], str] = ""
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
        words = self.status() if callable(self.status) else self.status
        self._bar.update(self._task, total=self.duration, completed=time, status=words)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()


def width() -> int | None:
    """Returns the columns of the terminal, or those that COLUMNS states; None where lines may have any length."""
    if not is_terminal(sys.stdout) and not os.environ.get("COLUMNS"):
        return None
    return shutil.get_terminal_size().columns


def table(
    header: Sequence[str], rows: Iterable[Sequence[str]], styles: Iterable[str] = (), whole: bool = False
) -> list[str]:
    """Returns the lines of a table; where a terminal is narrower, long cells run over several lines.

    A header of empty texts is left out. `styles` are those of each row's first cell, or where `whole` of all its cells.
    """
    from rich.console import Console  # here, since its modules take 50 ms, which --quiet saves  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    made = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="", show_header=any(header))
    for name in header:
        made.add_column(Text(name), overflow="fold")
    for cells, style in zip_longest(rows, styles, fillvalue=""):
        made.add_row(*(Text(printable(cell), style if whole or not i else "") for i, cell in enumerate(cells)))
    console = Console(
        file=StringIO(), width=width() or _WIDEST, force_terminal=True, color_system="standard", legacy_windows=False
    )
    console.print(made)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]  # type: ignore[attr-defined]


def say_table(
    header: Sequence[str], rows: Iterable[Sequence[str]], styles: Iterable[str] = (), whole: bool = False
) -> None:
    """Prints a table, as `table` takes it."""
    for line in table(header, rows, styles, whole):
        say(head=line)


def folded(text: str, indent: str = "") -> str:
    """Returns a text in lines that fit the terminal, each after the indent."""
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
