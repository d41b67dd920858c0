"""Names of signals in a scenario, such as `plant.R_NB[2,3]`."""

from __future__ import annotations

import re

_REFERENCE = re.compile(r"([A-Za-z_]\w*)\.(\S+?)((?:\[\s*\d+\s*(?:,\s*\d+\s*)*\])*)")


def split(reference: str) -> tuple[str, str, tuple[int, ...]] | None:
    """Block, variable and index (from 1) of `plant.R_NB[2,3]`, also written `plant.R_NB[2][3]`; None if malformed."""
    match = _REFERENCE.fullmatch(reference.strip())
    if match is None:
        return None
    return match[1], match[2], tuple(map(int, re.findall(r"\d+", match[3])))
