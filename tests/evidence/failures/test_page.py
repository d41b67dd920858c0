"""docs/evidence/failures.md: its tables say what the flights in docs/evidence/failures.csv say."""

import math
from pathlib import Path

import pytest

from evidence.failures import page
from evidence.failures.kept import Flight, load
from evidence.failures.rows import ROWS
from evidence.paper import ORBIT
from orchestration import InputError

DOCS = Path(__file__).parents[3] / "docs" / "evidence"
GOOD = (0, 50.0, 0.1 * ORBIT, 300.0, 0.2 * ORBIT, 340.0, 0.01, 0.08, "", "")


def flight(name, **more):
    return Flight(**{**dict(zip(Flight.__dataclass_fields__, (name, *GOOD), strict=True)), **more})


def cells(text, start):
    return next(line for line in text.splitlines() if line.startswith(f"| {start} |")).strip("| ").split(" | ")


def name(text):
    return next(row.name for row in ROWS if row.text.startswith(text))


def test_the_page_is_that_of_the_kept_flights():
    assert (DOCS / "failures.md").read_text("utf-8") == page.text(load(DOCS / "failures.csv"))


def test_a_flight_that_is_not_found_and_one_that_is_lost_are_counted_as_such():
    rod = name("rod 2 dead")
    lost = flight(rod, run=1, found_s=math.inf, settled_s=math.inf, hold_rms_deg=90.0, hold_max_deg=170.0)
    text = page.text([flight(rod), lost])
    assert cells(text, "a rod dead, from the start, 1 µN m")[1:] == ["1 of 2, 50 s, 50 s", "1 of 2", "45°, 170°"]
    assert "| a rod reversed" not in text


def test_below_five_degrees_too_late_does_not_count_as_soon():
    stuck = name("stuck from the start")
    late = flight(stuck, run=1, within_5_s=1.6 * ORBIT, found_s=400.0, within_15_s=ORBIT)
    row = next(r for r in page.text([flight(stuck), late]).splitlines() if r.startswith("| stuck") and ", 225 s," in r)
    assert row.strip("| ").split(" | ")[1:4] == ["2 of 2, 225 s, 400 s", "2 of 2", "1 of 2"]


def test_sensors_that_are_detected_at_once_and_held_share_a_sentence_with_their_worst():
    frozen, biased = name("attitude frozen for good"), name("field with a bias of 12 µT")
    quick, late = flight(biased, run=1, found_s=70.0, hold_max_deg=0.17), flight(frozen, found_s=101.0)
    text = page.text([flight(biased), quick, late])
    assert "within 70 s and held, with 0.01° rms at the median and 0.17° at most: field with a bias of 12 µT" in text
    assert cells(text, "attitude frozen for good in the hold")[1] == "1 of 1, 101 s, 101 s"


def test_a_flight_in_which_another_rod_was_reported_is_counted():
    rod = name("rod 2 dead")
    assert "**Wrong reports** in 1 of 2 flights" in page.text(
        [flight(rod, others="rod_1 field_failed"), flight(rod, run=1)]
    )
    assert "No wrong report in 1 flights" in page.text([flight(rod)])


def test_a_file_of_another_form_is_refused_with_the_command(tmp_path):
    (tmp_path / "failures.csv").write_text("row,run\n")
    with pytest.raises(InputError, match="python -m evidence failures"):
        load(tmp_path / "failures.csv")
