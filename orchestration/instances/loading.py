"""What the system's loader says of a library that it does not load, in plain words."""

from __future__ import annotations

import re

_REFUSALS = (
    (
        r"([^\s:]+): cannot open shared object file: No such file or directory",
        r"it needs the library \1, which is not on this machine; remedy: install it, or pack it into the FMU "
        r"beside its library",
    ),
    (r"([^\s:]+): undefined symbol: (fmi[23]\w+)", r"\1 lacks the function \2"),
    (r"([^\s:]+): undefined symbol: (\S+)", r"\1 needs the symbol \2, which no library that is loaded has"),
    (r"([^\s:]+): (?:file too short|invalid ELF header)", r"\1 is damaged, or no library of this platform"),
    (r"([^\s:]+): wrong ELF class: \S+", r"\1 is for another processor"),
    (
        r"(?:[^\s:]+): version `(\S+)' not found \(required by ([^)]+)\)",
        r"\2 needs \1, which the libraries of this system are too old for",
    ),
    (r"Could not find module '([^']+)'.*", r"\1 or a library that it needs is not on this machine"),
)
"""What the system's loader says of a library that it does not load, and the same in plain words."""


def in_words(refusal: str) -> str:
    """Returns why a library cannot be loaded, in plain words where the loader's are known; FMPy puts a sentence of its
    own before.
    """
    for pattern, words in _REFUSALS:
        if match := re.search(pattern, refusal, re.DOTALL):
            return match.expand(words)
    return refusal
