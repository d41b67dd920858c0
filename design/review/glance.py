"""The first table of a review: what a reader asks first, as the sections below have it.

Tests: tests/design/review/test_glance.py.
"""

from __future__ import annotations

from collections import Counter

from .content import Section, Table


def glance(sections: list[Section], verdicts: list[str], goal: float, share: str) -> Section:
    """Returns the answers that the tables of the sections have; `goal` of the hold in deg, `share` such as 95%."""
    tables = {table.name: table for section in sections for table in section.tables}

    def cell(table: str, row: str, column: str) -> str:
        """Returns a cell by the first cell of its row; a dash where there is none."""
        found = tables.get(table)
        rows = [one for one in found.rows if one[0] == row] if found else []
        return rows[0][found.columns.index(column)] if found and rows else "–"

    below = f"error below {goal:g} deg"
    settle = [cell("Time to settle", below, column) for column in ("settled", "median, s", "90%, s", "worst, s")]

    def errors(table: str) -> str:
        columns = ("ensemble, deg", f"{share} of tumbles, deg", "worst tumble, deg")
        hold, most, worst = (cell(table, "absolute", name) for name in columns)
        return f"at most {hold} deg in {share} of the holds; after tumbles {most} deg in {share}, {worst} deg in all"

    rows = [
        ["tumbles settled below the goal", f"{settle[0]} below {goal:g} deg; median {settle[1]} s, 90% {settle[2]} s, "
                                           f"worst {settle[3]} s"],
        ["pointing error", errors("Errors of pointing")],
    ]  # fmt: skip
    if cell("Errors of knowledge", "absolute", "ensemble, deg") != "–":
        rows.append(["error of the estimate", errors("Errors of knowledge")])
    if "Slews" in tables:
        turns = [row for row in tables["Slews"].rows if row[0] == "90 deg"]
        at = tables["Slews"].columns.index("below 1 deg after, s")
        rows.append(
            [
                "slews of 90 deg on a known attitude, below 1 deg after",
                ", ".join(f"{row[1]}: {row[at]} s" for row in turns),
            ]
        )
    if "Tracking of a station" in tables:
        rows.append(["station, largest error", cell("Tracking of a station", "error, largest", "value")])
    if "Single failures" in tables:
        failed = [row for row in tables["Single failures"].rows if row[0] != "none"]
        lost = [f"{row[0]} ({row[-1]})" for row in failed if row[-1]]
        rows.append(["single failures", f"{len(failed)} flown; {', '.join(lost) or 'all within the goal'}"])
    stated = Counter(verdicts)
    told = ", ".join(f"{count} {status}" for status, count in stated.items())
    rows.append(["requirements", told or "none given"])
    return Section("At a glance", [Table("Main results", ["", "found"], rows)])
