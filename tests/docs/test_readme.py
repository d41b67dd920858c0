"""README.md: its figures are those of the pages and of the files of flights that they are made from."""

import math
import re
from collections import Counter

import numpy as np

from evidence.satellites.classes import ALL
from evidence.satellites.kept import load, settling_times
from evidence.satellites.searched import BOUNDS, load_bounds

from .commands import ROOT

README_LINES = (ROOT / "README.md").read_text("utf-8")
README = " ".join(README_LINES.split())
SKEW = "50 kg, wheel along (1, 2, 2)/3"


def test_the_tumbles_of_the_papers_satellite_are_those_of_their_page():
    flown = re.findall(r"(\d+ of \d+) settle, in ([\d.]+) orbit at the median and ([\d.]+) at worst", page("flight"))
    stated = [
        row[1:3]
        for row in rows(README_LINES)
        if row[0].startswith(("perfect sensors, disturbance", "all errors (inertia"))
    ]
    assert len(flown) == 2
    assert stated == [[settled, f"median {median} orbit, longest {worst} orbit"] for settled, median, worst in flown]


def test_the_satellites_counted_are_those_of_their_flights():
    all_, settled, unsettled = Counter(), Counter(), Counter()
    lines = load(ROOT / "docs" / "evidence" / "satellites.csv").lines
    for line, time in zip(lines, settling_times(lines), strict=True):
        if ALL[line["satellite"]].has_wheel:
            kind = line["condition"], float(line["inclination_deg"]) >= 30.0
            all_[kind] += 1
            settled[kind] += bool(time < math.inf)
            unsettled[line["satellite"], *kind] += bool(time == math.inf)
    nominal, errors, low = ("nominal", True), ("errors", True), ("errors", False)
    assert f"{settled[nominal]} of {all_[nominal]} nominal tumbles" in README
    assert f"{settled[errors]} of {all_[errors]} with all errors settle and stay settled" in README
    told = f"{all_[low] - settled[low]} of {all_[low]} do not, {unsettled[SKEW, *low]} of them with a wheel along"
    assert told in README


def test_the_satellites_that_no_controller_holds_are_those_of_their_file():
    named = "1U, no wheel", "errors"
    bounds = [it for it in load_bounds(ROOT / "docs" / "evidence" / BOUNDS) if (it.satellite, it.condition) == named]
    assert f"no controller can keep {sum(it.excluded for it in bounds)} of these 100 settled" in README


def test_what_is_known_against_flights_that_do_not_settle_is_that_of_the_page():
    known = [row for row in rows(page("satellites")) if len(row) == 9 and row[1] and row[2].isdigit()]
    with_wheel = np.array([row[3:] for row in known if row[0] != "1U, no wheel"], int).sum(axis=0)
    (without,) = (np.array(row[3:], int) for row in known if row[:2] == ["1U, no wheel", "nominal"])
    proof, to_end, repeating, one, possible, unknown = with_wheel
    assert unknown == 0
    assert f"a proof excludes {proof} of these {sum(with_wheel)}." in README
    told = f"For {to_end + repeating} a search found no motion within 5 deg (for {to_end} none to the end, for {repeating} none that"
    assert told in README
    assert (
        f"for {one} it found one that repeats in one of two orbits alone, and for {possible} such motions are known"
        in README
    )
    assert f"for {without[0] + without[1]} no motion within 5 deg was found, even with unlimited rods" in README


def test_the_flights_with_the_estimator_are_those_of_their_page():
    table = rows(page("estimation"))
    stated = {row[0]: row[1:] for row in rows(README_LINES)}
    for begins, name in (
        ("all errors, `estimator`", "magnetometer, sun sensors, gyro"),
        ("the same with", "with a star tracker"),
    ):
        flown = next(row for row in table if row[0] == name)
        (found,) = (row for first, row in stated.items() if first.startswith(begins))
        assert found[:2] == [f"{flown[2]} of {flown[1]}", f"median {flown[3]} orbit, longest {flown[5]} orbit"]
        median, _, worst = flown[8].replace("°", "").split(", ")
        assert re.findall(r"median ([\d.]+)(?: deg rms)?, largest ([\d.]+)", found[2]) == [(median, worst)]


def rows(text: str) -> list[list[str]]:
    """The cells of each row of the tables."""
    return [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]


def page(name: str) -> str:
    return next((ROOT / "docs").glob(f"*/{name}.md")).read_text("utf-8")
