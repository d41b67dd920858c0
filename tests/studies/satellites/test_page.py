"""docs/satellites.md: its tables say what the flights in docs/satellites.csv say."""

from pathlib import Path

import pytest

from orchestration import InputError
from studies.satellites import page
from studies.satellites.classes import ALL
from studies.satellites.kept import COLUMNS, CONDITIONS, Flights, load, not_settled
from studies.satellites.searched import BOUNDS, HOLDS, Best, Missing, load_bounds, load_holds, waiting

DOCS = Path(__file__).parents[3] / "docs"


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


def test_flights_are_counted_by_the_best_hold_and_one_that_was_not_found_by_none():
    flights = Flights(
        (line("3U", 0, "800", "800"), line("3U", 1, "14000", "700"), line("3U", 2, "", ""), line("6U", 0, "", ""))
    )
    holds = [
        Best("3U", "errors", 0, False, False, 0.002, 0.01, 0.1, 1e-8),
        Best("3U", "errors", 1, False, False, 2.0, 6.0, 1.0, 1e-8),
        Best("3U", "errors", 2, False, False, 3.0, 9.0, 1.0, 1e-8),
    ]
    text = page.text(flights, [*holds, Best("6U", "errors", 0, False, False, 0.0, 0.0, 1.0, 0.1)])
    assert "| below 0.1° | 1 | 1 | 0 |" in text
    assert "| 1 to 5° | 2 | 0 | 1 |" in text
    assert "a wheel 3 are found so far" in text


def test_a_row_without_flights_says_so():
    text = page.text(Flights((line("1U", 0, "40", "40"),)))
    assert row(text, "6U", "nominal")[2:] == ["0 of 0", "–", "–", "–", "0", "–", "–"]


def test_a_file_of_another_form_is_refused_with_the_command(tmp_path):
    (tmp_path / "satellites.csv").write_text("satellite,run\n")
    with pytest.raises(InputError, match="python -m studies satellites"):
        load(tmp_path / "satellites.csv")


def test_every_satellite_has_both_rows():
    text = page.text(load(DOCS / "satellites.csv"))
    for name in ALL:
        for condition in CONDITIONS:
            assert row(text, name, page.NAMES[condition])


def test_of_flights_that_are_not_settled_the_least_largest_error_is_sought_then_the_last_orbit():
    def hold(run, last, even, rms, largest, gap=1e-8):
        return Best("3U", "errors", run, last, even, rms, largest, 1.0, gap)

    flights = Flights(tuple(line("3U", run, "", "", hold_rms_deg="9") for run in range(20)))
    first = [
        hold(0, False, False, 1.0, 4.0, 0.1),  # did not close
        hold(1, False, False, 1.0, 4.0),
        hold(2, False, False, 2.0, 8.0),
        hold(3, False, False, 2.0, 8.0),
        *(hold(run, False, False, 6.0, 9.0) for run in range(4, 20)),  # its mean excludes it
    ]
    assert waiting(flights, first)["3U", "errors"] == [(1, True, False), (2, False, True), (3, False, True)]
    then = [hold(1, True, False, 2.0, 6.0), hold(2, False, True, 4.0, 4.5), hold(3, False, True, 5.5, 6.0)]
    assert waiting(flights, [*first, *then])["3U", "errors"] == [(1, True, True), (2, True, False)]
    found = [*first, *then, hold(1, True, True, 2.5, 3.0), hold(2, True, False, 7.0, 9.0)]
    assert ("3U", "errors") not in waiting(flights, found)
    text = page.text(flights, found)
    assert "Of the 19, 16 have a best hold with an rms of 5° or more: " in text
    assert (
        "For 2 a motion was found that stays within 5° in the orbit from 9,000 s on, for 1 of them in both orbits"
        in text
    )
    assert row(text, "3U", "all errors", "1")[-6:] == ["–", "1°", "1.00", "4°", "3°", ""]
    assert row(text, "3U", "all errors", "3")[-5:] == ["2°", "1.00", "6°", "", ""]
    assert row(text, "3U", "all errors", "4")[-5:] == ["6°", "1.00", "9°", "", ""]
    assert "For 1 others the least largest error that was found is 5° or more" in text


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
    assert "| 3U | all errors | 3 | 1 | 18% |" in text
    assert row(text, "3U", "all errors", "2")[-6] == "18%"
    assert row(text, "3U", "all errors", "3")[-6] == "–"
    assert "have not been looked at" not in text
    assert "2 flights have not been looked at yet" in page.text(flights, bounds=bounds[:1])
