"""`python -m tests.authorities`: measures every authority and writes docs/evidence/verification.md and its figure.

Authorities whose package is not installed are kept as the page has them, marked with the version measured
then; `--require-all` refuses instead. Exit status 1 where one disagrees.
"""

from __future__ import annotations

import argparse
import sys
import time
from importlib.metadata import version
from pathlib import Path

from . import Authority, load

DOCS = Path(__file__).parents[2] / "docs" / "evidence"
PAGE = DOCS / "verification.md"
FIGURE = DOCS.parent / "figures" / "integrator_cost.png"

HEAD = """# Verification: how far the plant lies from outside authorities

Made by `make authorities` (`python -m tests.authorities`); do not edit. Every row that needs no heavy package is also a test
(`tests/authorities/test_authorities.py`); `pip install bsk orekit-jpype` brings the rest (Orekit runs on a Java runtime). What a row compares
stands in `tests/authorities/`, in the function of the name given.

"Found" must lie within the tolerance of "Expected"; where nothing is expected, it is the size of a difference.
"""

INTEGRATOR = """
## The integrator: what it gains and what it keeps

![Attitude error against evaluations of the moment, energy and orthogonality over ten orbits](../figures/integrator_cost.png)

A tumble at 0.11 rad/s with a spinning wheel; full inertia with products. Evaluations are counted as in the plant, where a command
may change at every step: 2, 6 and 8 a step at order 2, 4 and 6; 4 for RK4.

{table}
- **The variational integrator keeps structure at any step**: inertial momentum without external moments to rounding, whatever the wheel does; an energy error
  that is bounded and does not grow; rotations that stay rotations without reprojection. RK4's energy and orthogonality drift from the first orbit on.
"""


def _source(authority: Authority) -> str:
    """The authority, with the version of the package that stands for it."""
    if authority.needs is None:
        return authority.source
    package = authority.needs.split(":")[0]
    return f"{authority.source} ({package} {version(package)})"


def _row(authority: Authority, figure: float) -> str:
    unit = f" {authority.unit}" if authority.unit else ""
    expected = f"{authority.expected:.7g}{unit}" if authority.expected else ""
    found = f"{figure:.7g}{unit}" if authority.expected else f"{figure:.2g}{unit}"
    return f"| {authority.what} | {expected} | {found} | {authority.tolerance:g}{unit} | {_source(authority)} | `{authority.measure.__module__.split('.')[-1]}.{authority.name}` |"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.authorities", description=__doc__)
    parser.add_argument("--require-all", action="store_true", help="fail where an optional package is missing")
    parser.add_argument("--no-figure", action="store_true", help="leave the figure and its table as they are")
    arguments = parser.parse_args()
    authorities = load()
    if arguments.require_all and (
        missing := sorted({a.needs.split(":")[0] for a in authorities if a.needs and not a.available})
    ):
        print(f"missing: pip install {' '.join(missing)}", file=sys.stderr)
        return 2
    before = PAGE.read_text("utf-8") if PAGE.exists() else ""
    kept = {line.split(" | ")[0].removeprefix("| "): line for line in before.splitlines() if line.startswith("| ")}
    page, subject, wrong = [HEAD], None, []
    for authority in authorities:
        if authority.subject != subject:
            subject = authority.subject
            page += [
                f"\n## {subject}",
                "",
                "| What is compared | Expected | Found | Tolerance | Authority | Function |",
                "|---|---|---|---|---|---|",
            ]
        if not authority.available:
            package = authority.needs.split(":")[0] if authority.needs else ""
            page.append(
                kept.get(
                    authority.what, f"| {authority.what} |  | not run: pip install {package} | | {authority.source} | |"
                )
            )
            print(f"{'kept':>9}  {authority.name} (needs {package})")
            continue
        began = time.perf_counter()
        figure = authority.measure()
        agrees = authority.agrees(figure)
        if not agrees:
            wrong.append(authority.name)
        page.append(_row(authority, figure))
        print(
            f"{'agrees' if agrees else 'DISAGREES':>9}  {authority.name}: {figure:.6g} {authority.unit} ({time.perf_counter() - began:.1f} s)",
            flush=True,
        )
    if arguments.no_figure and INTEGRATOR.split("\n")[1] in before:
        page.append(before[before.index(INTEGRATOR.split("\n")[1]) - 1 :].rstrip("\n"))
    else:
        from .cost import draw

        page.append(INTEGRATOR.format(table=draw(FIGURE)).rstrip("\n"))
    if wrong:
        print(f"{len(wrong)} disagree, nothing written: {', '.join(wrong)}", file=sys.stderr)
        return 1
    PAGE.write_text("\n".join(page) + "\n", "utf-8")
    print(f"wrote {PAGE.relative_to(DOCS.parent)} and {FIGURE.relative_to(DOCS.parent)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
