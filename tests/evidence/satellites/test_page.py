"""docs/evidence/satellites.md: its tables say what the flights in docs/evidence/satellites.csv say."""

from pathlib import Path

import pytest

from evidence.satellites import page
from evidence.satellites.classes import ALL
from evidence.satellites.kept import COLUMNS, CONDITIONS, Flights, load, not_settled
from evidence.satellites.searched import BOUNDS, HOLDS, Closest, Missing, load_bounds, load_holds, waiting
from orchestration import InputError

DOCS = Path(__file__).parents[3] / "docs" / "evidence"
NAN = float("nan")


def line(satellite, run, settled, early, **more):
    values = {
        "condition": "errors",
        "run": str(run),
        "settled_5deg_s": settled,
        "early_s": early,
        "hold_rms_deg": "0.02",
    }
    return {**dict.fromkeys(COLUMNS, ""), "satellite": satellite, **values, **more}


def row(text, *begins):
    cells = " | ".join(begins)
    return next(r for r in text.splitlines() if r.startswith(f"| {cells} |"))[2:-2].split(" | ")


def test_the_page_is_that_of_the_kept_flights():
    holds, bounds = load_holds(DOCS / HOLDS), load_bounds(DOCS / BOUNDS)
    kept = load(DOCS / "satellites.csv"), holds, bounds
    assert (DOCS / "satellites.md").read_text("utf-8") == page.text(*kept)


def test_a_flight_that_leaves_the_hold_is_lost_again_and_one_that_never_settles_is_later_than_all():
    lines = [
        line("3U", 0, "800", "800"),
        line("3U", 1, "14000", "700", later_max_deg="31"),
        line("3U", 2, "", "", later_max_deg="170", hold_rms_deg="90"),
        line("3U", 3, "12000", "", later_max_deg="160"),
    ]
    found = row(page.text(Flights(tuple(lines))), "3U", "all errors")
    assert found[2:] == ["2 of 4", "–", "–", "–", "1, to 31°; 1 settle once more", "0.02°", "0.02°"]
    assert "| 3U | all errors | 2 |" in page.text(Flights(tuple(lines)))


def test_nominal_flights_without_a_wheel_are_counted_by_the_least_error_that_was_found():
    def flight(run, settled, early, largest):
        return line("1U, no wheel", run, settled, early, later_max_deg=largest, condition="nominal")

    lines = [
        line("3U", 0, "", "", later_max_deg="2"),
        flight(0, "", "", "12"),
        flight(1, "900", "900", "4"),
        flight(2, "14000", "700", "8"),
        flight(3, "", "", "30"),
    ]
    holds = [
        Closest("3U", "errors", 0, 4.0, 5.0, 6.0),
        *(Closest("1U, no wheel", "nominal", run, least, NAN, NAN) for run, least in enumerate((6.0, 4.5, 4.0, NAN))),
    ]
    text = page.text(Flights(tuple(lines)), holds)
    assert "| 4 to 5° | 2 | 1 | 1 | 1.4 |" in text
    assert "| 5 to 7° | 1 | 0 | 0 | 2 |" in text
    assert "For 1 a search did not end with a motion" in text
    assert "2 of the flights for which it was sought stayed closer after 9,000 s" in text


def test_a_row_without_flights_says_so():
    text = page.text(Flights((line("1U", 0, "40", "40"),)))
    assert row(text, "6U", "nominal")[2:] == ["0 of 0", "–", "–", "–", "0", "–", "–"]


def test_a_file_of_another_form_is_refused_with_the_command(tmp_path):
    (tmp_path / "satellites.csv").write_text("satellite,run\n")
    with pytest.raises(InputError, match="python -m evidence satellites"):
        load(tmp_path / "satellites.csv")


def test_every_satellite_has_both_rows():
    text = page.text(load(DOCS / "satellites.csv"))
    for name in ALL:
        for condition in CONDITIONS:
            assert row(text, name, page.NAMES[condition])


def test_it_is_sought_for_what_is_not_settled_and_for_some_to_compare():
    lines = [
        line("3U", 0, "800", "800"),
        line("3U", 7, "", ""),
        line("3U", 8, "14000", "700"),
        line("1U, no wheel", 0, "800", "800"),
        line("1U, no wheel", 1, "", "", condition="nominal"),
        line("1U, no wheel", 2, "800", "800", condition="nominal"),
        line("1U, no wheel", 3, "800", "800", condition="nominal"),
    ]
    sought = waiting(Flights(tuple(lines)), [Closest("1U, no wheel", "nominal", 3, 0.0, NAN, NAN)])
    assert sought["3U", "errors"] == [(7, True), (8, True)]
    assert sought["1U, no wheel", "nominal"] == [(1, False), (2, False)]
    assert ("1U, no wheel", "errors") not in sought


def test_of_flights_that_are_not_settled_it_is_told_what_is_known_against_them():
    lines = [line("3U", run, "", "", later_max_deg="9", hold_rms_deg="9") for run in range(7)]
    holds = [
        Closest("3U", "errors", 1, 5.5, 7.0, 8.0),
        Closest("3U", "errors", 2, 4.0, 3.0, 5.5),
        Closest("3U", "errors", 3, 4.0, 3.0, 4.5),
        Closest("3U", "errors", 4, 4.0, 6.0, NAN),
        Closest("3U", "errors", 6, 4.0, 6.5, 7.0),
    ]
    bounds = [Missing("3U", "errors", 0, 0.3), *(Missing("3U", "errors", run, 0.0) for run in range(1, 6))]
    text = page.text(Flights(tuple(lines)), holds, bounds)
    assert row(text, "3U", "all errors", "7")[3:] == ["1", "1", "1", "1", "1", "2"]
    assert "either of two orbits*, 1 need less than 6°" in text
    assert row(text, "3U", "all errors", "0")[-5:] == ["30%", "–", "–", "–", ""]
    assert row(text, "3U", "all errors", "2")[-5:] == ["–", "4°", "3°", "5.5°", ""]


def test_flights_that_no_controller_holds_are_told_apart_from_those_that_are_not_excluded():
    lines = [line("3U", 0, "800", "800"), line("3U", 1, "14000", "700"), line("3U", 2, "", ""), line("3U", 3, "", "")]
    bounds = [
        Missing("3U", "errors", 1, 0.0),
        Missing("3U", "errors", 2, 0.181),
        Missing("3U", "errors", 3, 0.009),
    ]
    flights = Flights(tuple(lines))
    assert not_settled(flights) == [("3U", "errors", run) for run in "123"]
    text = page.text(flights, bounds=bounds)
    assert row(text, "3U", "all errors", "3", "1")[4:] == ["0", "0", "0", "0", "2"]
    assert "the most is 0.2 times the disturbance" in text
    assert row(text, "3U", "all errors", "2")[-5] == "18%"
    assert row(text, "3U", "all errors", "3", "–")[-5] == "–"
    assert "have not been looked at" not in text
    assert "2 flights have not been looked at yet" in page.text(flights, bounds=bounds[:1])
