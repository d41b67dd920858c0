"""README.md: it fits one screen, and its figures are those of the pages and of the files of flights."""

import math
import re

from evidence.satellites.classes import ALL
from evidence.satellites.kept import load, settling_times

from .commands import ROOT

LINES = (ROOT / "README.md").read_text("utf-8")
README = " ".join(LINES.split())
ORBIT = 5792.4 / 60.0
"""Minutes, of the paper's satellite."""


def test_what_stands_before_more_has_450_words_at_most():
    assert len(LINES.partition("\n## More\n")[0].split()) <= 450


def test_the_results_are_those_of_their_pages():
    flown = re.findall(r"(\d+ of \d+) settle, in ([\d.]+) orbit at the median and ([\d.]+) at worst", page("flight"))
    estimated = re.findall(
        r"- .*? (\d+ of \d+) settle, after ([\d.]+) orbit at the median and ([\d.]+) at worst; "
        r"the hold is [\d.]+° rms, ([\d.]+)° at worst",
        page("estimation"),
    )
    flown += [row[:3] for row in estimated]
    stated = [row[1:3] for row in rows(LINES) if " of " in row[1]]
    assert stated == [[settled, f"{minutes(median)}, {minutes(worst)}"] for settled, median, worst in flown]
    holds = [row[3] for row in rows(LINES) if " of " in row[1]]
    assert holds[2:] == [f"{row[3]} deg" for row in estimated]
    assert len(estimated) == 2


def test_the_satellites_near_the_equator_are_those_of_their_flights():
    lines = load(ROOT / "docs" / "evidence" / "satellites.csv").lines
    low = [
        time < math.inf
        for line, time in zip(lines, settling_times(lines), strict=True)
        if ALL[line["satellite"]].has_wheel and line["condition"] == "errors" and float(line["inclination_deg"]) < 30.0
    ]
    assert f"{low.count(False)} of {len(low)} tumbles with all errors are not held" in README


def minutes(orbits: str) -> str:
    return f"{float(orbits) * ORBIT:.1f} min"


def rows(text: str) -> list[list[str]]:
    """The cells of each row of the tables."""
    return [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]


def page(name: str) -> str:
    return next((ROOT / "docs").glob(f"*/{name}.md")).read_text("utf-8")
