"""Names of variables where not every character may stand: one rule for scenarios, all formats of results, and back."""

from __future__ import annotations

import re
from collections.abc import Iterable

RULE = (
    "A character that a name cannot hold is written _xHHHH_, HHHH being its number in Unicode, in hexadecimal. "
    'Columns, and names in a scenario, hold no white space, no control characters and none of , ; " # * = and ->. '
    "Names in a MAT file hold letters and digits of ASCII and _, and begin with a letter; there a first character "
    "is written xHHHH_. "
    "A _ or a first x that would read as the beginning of such a writing is written so itself."
)
"""The rule in words, for those who read results."""
_HEX = "[0-9A-F]{4,6}"


def _pattern(forbidden: str) -> re.Pattern[str]:
    """Returns what has to be written out, where these characters may not stand."""
    return re.compile(f"{forbidden}|_(?=x{_HEX}(?:_|{forbidden}))|^x(?={_HEX}(?:_|{forbidden}))", re.ASCII)


_IN_COLUMN = _pattern(r"(?:[\s\x00-\x1f\x7f-\xa0\u2028\u2029,;\"#*=]|-(?=>))")
_IN_FIELD = _pattern(r"(?:[^A-Za-z0-9_]|^[^A-Za-z])")
_WRITTEN = re.compile(f"(?:_|^)x({_HEX})_")


def escaped(name: str) -> str:
    """A variable's name as columns and scenarios have it."""
    return _IN_COLUMN.sub(lambda match: f"_x{ord(match[0]):04X}_", name)


def field(name: str, taken: Iterable[str] = ()) -> str:
    """A name as a MAT file has it; its first character is written out where the name is taken by something else."""
    return f"x{ord(name[0]):04X}_{name[1:]}" if name in taken else _IN_FIELD.sub(_as_field, name)


def _as_field(match: re.Match[str]) -> str:
    return f"{'_' if match.start() else ''}x{ord(match[0]):04X}_"


def unescaped(name: str) -> str:
    """The name that `escaped` or `field` has written so."""
    return _WRITTEN.sub(lambda match: chr(int(match[1], 16)), name)
