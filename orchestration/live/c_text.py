"""C as text: initializers, and arrays that get names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np


class Text:
    """Lines of definitions."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._known: dict[str, str] = {}

    def define(self, what: str, items: Sequence[str]) -> None:
        """An array of these initializers, of one that is empty where there are none."""
        self.lines.append(f"{what}[] = {{{', '.join(items) or '{0}'}}};")

    def array(self, ctype: str, values: Iterable[Any]) -> str:
        """Returns the name of a constant array with these values; NULL where there are none."""
        text = ", ".join(number(value) for value in values)
        if not text:
            return "NULL"
        line = f"{ctype} NAME[] = {{{text}}};"
        if line not in self._known:
            self._known[line] = f"array_{len(self._known)}"
            self.lines.append("static const " + line.replace("NAME", self._known[line]))
        return self._known[line]

    def room(self, ctype: str, count: int) -> str:
        """Returns the name of an array to write to."""
        name = f"room_{len(self.lines)}"
        self.lines.append(f"static {ctype} {name}[{count}];")
        return name


def number(value: Any) -> str:
    """Returns a number, or a name, as C has it."""
    if isinstance(value, (float, np.floating)):
        return repr(float(value)).replace("inf", "INFINITY")
    return str(value)


def quoted(text: str) -> str:
    """Returns a literal string."""
    shown = (chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode())
    return f'"{"".join(shown)}"'


def listed(items: Iterable[Any]) -> str:
    """Returns an initializer by order."""
    return f"{{{', '.join(map(number, items))}}}"


def fields(entries: Mapping[str, Any]) -> str:
    """Returns an initializer by name."""
    return f"{{{', '.join(f'.{name} = {number(value)}' for name, value in entries.items())}}}"
