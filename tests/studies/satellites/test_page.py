"""docs/satellites.md: its tables say what the flights in docs/satellites.csv say."""

from pathlib import Path

import pytest

from orchestration import InputError
from studies.satellites import page
from studies.satellites.classes import ALL
from studies.satellites.kept import COLUMNS, CONDITIONS, Best, Flights, load, load_holds, waiting

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


def row(text, satellite, condition):
    return next(r for r in text.splitlines() if r.startswith(f"| {satellite} | {condition} |")).strip("| ").split(" | ")


def test_the_page_is_that_of_the_kept_flights():
    kept = load(DOCS / "satellites.csv"), load_holds(DOCS / "satellites_hold.csv")
    assert (DOCS / "satellites.md").read_text("utf-8") == page.text(*kept)


def test_a_flight_that_leaves_the_hold_is_lost_again_and_one_that_never_settles_is_later_than_all():
    lines = [
        line("3U", 0, "800", "800"),
        line("3U", 1, "14000", "700", later_max_deg="31"),
        line("3U", 2, "", "", later_max_deg="170", hold_rms_deg="90"),
        line("3U", 3, "12000", "", later_max_deg="160"),
    ]
    found = row(page.text(Flights(tuple(lines))), "3U", "all errors")
    assert found[2:] == ["3 of 4", "14,000", "–", "–", "1, to 31°", "0.02°", "0.02°"]
    assert "| 3U | all errors | 2 |" in page.text(Flights(tuple(lines)))


def test_flights_are_counted_by_the_best_hold_and_one_that_was_not_found_by_none():
    flights = Flights(
        (line("3U", 0, "800", "800"), line("3U", 1, "14000", "700"), line("3U", 2, "", ""), line("6U", 0, "", ""))
    )
    holds = [
        Best("3U", "errors", 0, False, 0.002, 0.01, 0.1, 1e-8),
        Best("3U", "errors", 1, False, 2.0, 6.0, 1.0, 1e-8),
        Best("3U", "errors", 2, False, 3.0, 9.0, 1.0, 1e-8),
    ]
    text = page.text(flights, [*holds, Best("6U", "errors", 0, False, 0.0, 0.0, 1.0, 0.1)])
    assert "| below 0.1° | 1 | 1 | 0 |" in text
    assert "| 1 to 5° | 2 | 1 | 1 |" in text
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


def test_the_last_orbit_is_sought_for_flights_that_are_not_settled_and_have_a_close_hold_before():
    flights = Flights(tuple(line("3U", run, "", "", hold_rms_deg="9") for run in range(20)))
    first = [Best("3U", "errors", run, False, 1.0, 4.0 if run < 3 else 8.0, 1.0, 1e-8) for run in range(1, 20)]
    open_gap = Best("3U", "errors", 0, False, 1.0, 4.0, 1.0, 0.1)
    assert waiting(flights, first)["3U", "errors"] == [(0, False), (1, True), (2, True)]
    last = [Best("3U", "errors", 1, True, 1.0, 3.0, 1.0, 1e-8), Best("3U", "errors", 2, True, 1.0, 9.0, 1.0, 1e-8)]
    assert ("3U", "errors") not in waiting(flights, [*first, open_gap, *last])
    text = page.text(flights, [*first, open_gap, *last])
    assert "2 of the 19 best holds stay within 5°" in text
    assert "searched, too, since the field is another one there: 1 stay within 5° in both" in text
