"""Calls from the host: what is raised in one becomes a message to the host, and the instance stays usable.

Carried by every Python FMU, so it needs the standard library only. Tests: tests/fmus/python/test_errors.py.
"""

from __future__ import annotations

import ctypes
import functools
import traceback
from collections.abc import Callable
from typing import Any


class Refused(Exception):
    """The host asked for what the block cannot do; the message suffices, so no traceback is logged."""


class CallError(Exception):
    """The exception that leaves a call towards PythonFMU, whose C++ side logs its `repr`."""

    def __repr__(self) -> str:
        text = str(self).encode("utf-8", "backslashreplace").decode()
        return text.replace("%", "%%")  # FMI's logger takes a format


def keep(*objects: Any) -> None:
    """Takes a reference to each, in place of one that PythonFMU 0.7 drops without owning it."""
    for kept in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))


def guarded(call: Callable[..., Any]) -> Callable[..., Any]:
    """Turns whatever is raised in a call from the host into a CallError with its message; the instance stays usable."""

    @functools.wraps(call)
    def wrapper(self: Any, *arguments: Any) -> Any:
        try:
            return call(self, *arguments)
        except BaseException as error:  # an interrupt would end the instance as any exception does
            text = f"{self.interface.name}: {type(error).__name__}: {error}"
            if isinstance(error, Refused):
                text = f"{self.interface.name}: {error}"
            else:
                text += "\n" + "".join(traceback.format_exception(error)).rstrip()
            # PythonFMU 0.7 drops its references to these three when an exception passes, yet goes on using them.
            keep(type(self), self, self.log_queue)
            raise CallError(text) from None

    return wrapper
