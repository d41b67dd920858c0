"""`python -m tests.authorities`: measures every authority and writes docs/evidence/verification.csv.

The lines of authorities whose package is not installed stay as they are. Exit status 1 where one disagrees.
"""

from __future__ import annotations

import sys
import time
from importlib.metadata import version

from evidence import files
from evidence.verification.page import FILE, Line

from . import Authority, load


def line(authority: Authority, found: float) -> Line:
    """The line of an authority; its source has the version of the package that stands for it."""
    package = authority.needs.split(":")[0] if authority.needs else ""
    source = f"{authority.source} ({package} {version(package)})" if package else authority.source
    function = f"{authority.measure.__module__.split('.')[-1]}.{authority.name}"
    values = authority.expected, found, authority.tolerance
    return Line(authority.subject, authority.what, authority.unit, *values, source, function)


def main() -> int:
    kept = {each.what: each for each in files.load_if_any(Line, FILE, "git checkout the file")}
    lines, wrong = [], []
    for authority in load():
        if not authority.available:
            print(f"{'kept':>9}  {authority.name} (needs {authority.needs})")
            lines += [kept[authority.what]] if authority.what in kept else []
            continue
        began = time.perf_counter()
        found = authority.measure()
        wrong += [] if authority.agrees(found) else [authority.name]
        lines.append(line(authority, found))
        said = "agrees" if authority.agrees(found) else "DISAGREES"
        print(f"{said:>9}  {authority.name}: {found:.6g} {authority.unit} ({time.perf_counter() - began:.1f} s)")
    if wrong:
        print(f"{len(wrong)} disagree, nothing written: {', '.join(wrong)}", file=sys.stderr)
        return 1
    files.save(Line, FILE, lines, digits=10)
    return 0


if __name__ == "__main__":
    sys.exit(main())
