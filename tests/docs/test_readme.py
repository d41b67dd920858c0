"""README.md: its figures are those of the pages and of the files of flights that they are made from."""

import re
from collections import Counter

from studies.satellites.classes import ALL
from studies.satellites.kept import load

from .commands import ROOT

README = " ".join((ROOT / "README.md").read_text("utf-8").split())
SKEW = "50 kg, wheel along (1, 2, 2)/3"


def test_the_tumbles_of_the_papers_satellite_are_those_of_their_page():
    flown = re.findall(r"(\d+ of \d+) settle, in ([\d.]+) orbit at the median and ([\d.]+) at worst", page("flight"))
    told = re.findall(r"(\d+ of \d+) .{,60}?: median ([\d.]+) orbit, maximum ([\d.]+) orbit", README)
    assert len(flown) == 2
    assert told == flown


def test_the_satellites_counted_are_those_of_their_flights():
    all_, settled, unsettled = Counter(), Counter(), Counter()
    for line in load(ROOT / "docs" / "satellites.csv").lines:
        if ALL[line["satellite"]].has_wheel:
            kind = line["condition"], float(line["inclination_deg"]) >= 30.0
            all_[kind] += 1
            settled[kind] += bool(line["settled_5deg_s"])
            unsettled[line["satellite"], *kind] += not line["settled_5deg_s"]
    nominal, errors, low = ("nominal", True), ("errors", True), ("errors", False)
    assert f"{settled[nominal]} of {all_[nominal]} nominal tumbles" in README
    assert f"{settled[errors]} of {all_[errors]} with all errors are settled" in README
    told = (
        f"{all_[low] - settled[low]} of {all_[low]} are not settled, {unsettled[SKEW, *low]} of them with a wheel along"
    )
    assert told in README


def test_the_flights_with_the_estimator_are_those_of_their_page():
    table = [line.strip("| ").split(" | ") for line in page("estimation").splitlines() if line.startswith("| ")]
    sun = next(row for row in table if row[0] == "magnetometer, sun sensors, gyro")
    star = next(row for row in table if row[0] == "with a star tracker")
    assert f"{sun[2]} of {sun[1]} such tumbles" in README
    assert f"(median {sun[3]} orbit, maximum {sun[5]})" in README
    assert f"{star[2]} of {star[1]} are held below 0.02 deg rms" in README


def page(name: str) -> str:
    return (ROOT / "docs" / f"{name}.md").read_text("utf-8")
