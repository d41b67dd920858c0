"""Who made an FMU of this project, of which version and when, as the description of either version of FMI has it.

The date is that of the version, from CITATION.cff: that of a build would give the same sources other bytes.
Tests: tests/fmus/contents/test_description.py.
"""

from __future__ import annotations

import re
from functools import cache

from .. import places


@cache
def origin() -> dict[str, str]:
    """Returns the attributes author, version, copyright and generationDateAndTime; those that are not known are left
    out."""
    citation, licence = places.shared("CITATION.cff"), places.shared("LICENSE")
    cited = citation.read_text("utf-8") if citation.exists() else ""
    licensed = licence.read_text("utf-8") if licence.exists() else ""
    wanted = {
        "author": (r'^ +- name: "(.+)"$', cited),
        "version": (r"^version: (\S+)$", cited),
        "copyright": (r"^(Copyright .+)$", licensed),
        "generationDateAndTime": (r"^date-released: (\S+)$", cited),
    }
    found = {key: re.search(pattern, text, re.MULTILINE) for key, (pattern, text) in wanted.items()}
    values = {key: match[1] for key, match in found.items() if match}
    if "generationDateAndTime" in values:
        values["generationDateAndTime"] += "T00:00:00Z"
    return values
