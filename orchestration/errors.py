"""What can go wrong: the input, or a block while it runs. Both carry their message ready for the user."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


class InputError(ValueError):
    """The scenario, an FMU or an option is wrong, and nothing was run. Exit status 2."""

    def __init__(self, *messages: str) -> None:
        super().__init__("\n".join(messages))
        self.messages = messages


class BlockError(RuntimeError):
    """A block failed: in initialization (`time` is None) or during the run. Exit status 3.

    `result` holds what was computed up to then, once the run has ended.
    """

    def __init__(
        self,
        block: str,
        call: str,
        problem: str,
        time: float | None = None,
        log: Sequence[str] = (),
    ) -> None:
        self.block, self.call, self.problem, self.time, self.log = block, call, problem, time, tuple(log)
        self.result: Any = None
        super().__init__(block, call, problem)

    def __str__(self) -> str:
        when = "in initialization" if self.time is None else f"at {self.time:.10g} s"
        text = f"{self.block}: {self.call} {when}: {self.problem}"
        return "\n".join([text, *(f"  {self.block} said: {line}" for line in self.log)])


class ResultsError(RuntimeError):
    """The results could not be written. Exit status 4. `result` is what could not be, where it is known."""

    result: Any = None


def nearest(name: str, names: Iterable[str]) -> str:
    """ "; did you mean 'x'?" where one of the names is near, or "; there are a, b" where they are few."""
    from difflib import get_close_matches

    names = list(names)
    folded = {known.casefold(): known for known in names}
    if match := get_close_matches(name.casefold(), folded, n=1):
        return f"; did you mean {folded[match[0]]!r}?"
    if 0 < len(names) <= 8:
        return f"; there {'is only' if len(names) == 1 else 'are'} {', '.join(names)}"
    return ""


def said(value: Any) -> str:
    """A value as the user wrote it, for "found ..."."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "names with values"
    return "a list" if isinstance(value, (list, tuple)) else repr(value)
