"""What Python code of others raises and returns, as text.

Tests: tests/orchestration/instances/test_law.py, tests/orchestration/expectations/test_metrics.py.
"""

from __future__ import annotations

from .interrupt import is_asked

_LONGEST = 200
"""Characters of a value that a message shows."""


def told(error: BaseException) -> str:
    """Kind and text of what was raised; its own class may give none. A signal's is raised again."""
    if is_asked(error):
        raise error
    try:
        text = str(error)
    except BaseException as other:
        if is_asked(other):
            raise
        text = "an error without text"
    return f"{type(error).__name__}: {text}"


def shown(value: object) -> str:
    """A value as text; its own class may give none."""
    try:
        text = repr(value)
    except BaseException as error:
        if is_asked(error):
            raise
        return type(value).__name__
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ... of {len(text)} characters"
