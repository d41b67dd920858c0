"""Paths as users write them."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from .errors import InputError, Problem, reason


def here() -> Path:
    """Returns the working folder. Raises InputError where it has been deleted."""
    try:
        return Path.cwd()
    except FileNotFoundError:
        raise InputError(Problem("the working folder has been deleted", remedy="cd to one that is there")) from None


def located(text: str, folder: Path | None = None) -> Path:
    """The path of this text, with `~` and, where it is relative, from `folder` on.

    Raises InputError where it can be none.
    """
    if not text:
        raise InputError("expected a path, found an empty text")
    try:
        path = (folder or Path()) / Path(text).expanduser()
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            path.stat()
    except RuntimeError:
        raise InputError(f"{text}: the home of this user is unknown") from None
    except ValueError as error:
        raise InputError(f"{text!r} is no path: {error}") from None
    except OSError as error:
        raise InputError(f"{text if len(text) < 80 else text[:60] + '...'}: {reason(error)}") from None
    return path
