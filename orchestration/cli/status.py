"""Exit statuses, and the group of commands that turns every error into one line and a status."""

from __future__ import annotations

import errno
import os
import signal
import sys
from typing import Any

import click

from ..errors import BlockError, InputError, ResultsError, reason
from ..interrupt import stoppable
from .console import complain, open_streams, silence

EXPECTATION_FAILED = DOES_NOT_FIT = NOT_EQUIVALENT = 1
WRONG_INPUT, BLOCK_FAILED, UNWRITTEN, INTERNAL, SIGNALLED = 2, 3, 4, 70, 128
_PIPE = 13
"""The number of SIGPIPE."""


class Commands(click.Group):
    """A group whose commands end with a line and a status where they raise, without a traceback."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        open_streams()
        try:
            with stoppable():
                return super().main(*args, **kwargs)
        except SystemExit:
            if type(sys.stdout).__name__.endswith("PacifyFlushWrapper"):  # click's way with a pipe that is closed
                raise SystemExit(SIGNALLED + _PIPE) from None
            raise
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            silence()
            complain(f"{error.filename or 'standard output'} cannot be written: {reason(error)}")
            raise SystemExit(UNWRITTEN) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except InputError as error:
            for message in error.messages:
                complain(message)
            ctx.exit(WRONG_INPUT)
        except BlockError as error:
            complain(str(error))
            ctx.exit(BLOCK_FAILED)
        except ResultsError as error:
            complain(str(error))
            ctx.exit(UNWRITTEN)
        except (KeyboardInterrupt, click.Abort) as error:
            complain("interrupted")
            ctx.exit(SIGNALLED + getattr(error, "number", signal.SIGINT))
        except (click.exceptions.Exit, click.ClickException, BrokenPipeError):
            raise
        except Exception as error:
            if os.environ.get("ORCHESTRATE_TRACEBACK") or getattr(error, "errno", None) == errno.ENOSPC:
                raise
            complain(f"internal error: {type(error).__name__}: {error} (ORCHESTRATE_TRACEBACK=1 shows where)")
            ctx.exit(INTERNAL)
