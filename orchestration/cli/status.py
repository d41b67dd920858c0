"""Holds exit statuses, and the group of commands that turns every error into one line and a status.

Tests: tests/orchestration/cli/test_cli.py, tests/orchestration/results/test_endings.py.
"""

from __future__ import annotations

import atexit
import errno
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

import click

from ..errors import BlockError, InputError, ResultsError, reason
from ..instances.surroundings import left
from ..interrupt import stoppable
from ..paths import here
from .console import complain, lost, open_streams, silence

EXPECTATION_FAILED = DOES_NOT_FIT = NOT_EQUIVALENT = 1
WRONG_INPUT, BLOCK_FAILED, UNWRITTEN, INTERNAL, SIGNALLED = 2, 3, 4, 70, 128
_PIPE = 13
"""The number of SIGPIPE."""


class Commands(click.Group):
    """A group whose commands end with a line and a status, without a traceback, where they raise."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        try:
            return self._main(*args, **kwargs)
        except SystemExit as ended:
            if any(thread.is_alive() for thread in left) and sys.stdout is sys.__stdout__:
                _end(ended.code)
            raise

    def _main(self, *args: Any, **kwargs: Any) -> Any:
        open_streams()
        lost()  # by an earlier command of this process
        try:
            with stoppable(), _told():
                return super().main(*args, **kwargs)
        except click.exceptions.Exit as ended:
            raise SystemExit(ended.exit_code) from None
        except SystemExit as ended:
            if type(sys.stdout).__name__.endswith("PacifyFlushWrapper"):  # click's way with a pipe that is closed
                raise SystemExit(SIGNALLED + _PIPE) from None
            if lost() and ended.code in (0, 1):  # of the others something else is told, too
                raise SystemExit(UNWRITTEN) from None
            raise
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            silence()
            complain(f"{error.filename or 'standard output'} cannot be written: {reason(error)}")
            raise SystemExit(UNWRITTEN) from None

    def invoke(self, ctx: click.Context) -> Any:
        with _told():
            return super().invoke(ctx)


def _end(status: Any) -> NoReturn:
    """Ends the program without waiting for threads that blocks have left."""
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(status if isinstance(status, int) else 0)


@contextmanager
def _told() -> Iterator[None]:
    """Prints why a command cannot go on, and ends it with the status of that."""
    try:
        here()
        yield
    except InputError as error:
        for message in error.messages:
            complain(message)
        raise click.exceptions.Exit(WRONG_INPUT) from None
    except BlockError as error:
        complain(str(error))
        raise click.exceptions.Exit(BLOCK_FAILED) from None
    except ResultsError as error:
        complain(str(error))
        raise click.exceptions.Exit(UNWRITTEN) from None
    except (KeyboardInterrupt, click.Abort) as error:
        complain("interrupted")
        raise click.exceptions.Exit(SIGNALLED + getattr(error, "number", signal.SIGINT)) from None
    except (click.exceptions.Exit, click.ClickException, BrokenPipeError):
        raise
    except Exception as error:
        if os.environ.get("ORCHESTRATE_TRACEBACK") or getattr(error, "errno", None) == errno.ENOSPC:
            raise
        complain(f"internal error: {type(error).__name__}: {error} (ORCHESTRATE_TRACEBACK=1 shows where)")
        raise click.exceptions.Exit(INTERNAL) from None
