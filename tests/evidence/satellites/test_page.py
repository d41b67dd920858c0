"""docs/evidence/satellites.md: its tables say what the flights in docs/evidence/satellites.csv say."""

from pathlib import Path

import pytest

from evidence.satellites import page
from evidence.satellites.kept import COLUMNS, Flights, load, not_settled
from evidence.satellites.searched import BOUNDS, HOLDS, Closest, Missing, load_bounds, load_holds
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
    text = page.text(Flights(tuple(lines)))
    assert row(text, "3U", "0 of 0, –")[2:] == ["2 of 4, –, –", "1, to 31°", "0.02°, 0.02°"]
    assert row(text, "3U", "all errors", "2")[3:] == ["1", "0", "0", "2"]
    assert "2 flights have not been looked at yet" in text


def test_a_row_without_flights_says_so():
    text = page.text(Flights((line("1U", 0, "40", "40"),)))
    assert row(text, "6U", "0 of 0, –")[2:] == ["0 of 0, –, –", "0", "–, –"]


def test_a_file_of_another_form_is_refused_with_the_command(tmp_path):
    (tmp_path / "satellites.csv").write_text("satellite,run\n")
    with pytest.raises(InputError, match="python -m evidence satellites"):
        load(tmp_path / "satellites.csv")


def test_flights_that_no_controller_holds_are_told_apart_from_those_that_a_search_speaks_against():
    lines = [line("3U", run, "", "", later_max_deg="9") for run in range(8)]
    lines.append(line("3U", 8, "800", "800"))
    holds = [
        Closest("3U", "errors", 1, 5.5, 7.0, 8.0),
        Closest("3U", "errors", 2, 4.0, 3.0, 5.5),
        Closest("3U", "errors", 3, 4.0, 6.0, NAN),
        Closest("3U", "errors", 4, 4.0, 6.5, 7.0),
    ]
    bounds = [Missing("3U", "errors", 0, 0.3), *(Missing("3U", "errors", run, 0.009) for run in range(1, 8))]
    flights = Flights(tuple(lines))
    assert not_settled(flights) == [("3U", "errors", f"{run}") for run in range(8)]
    text = page.text(flights, holds, bounds)
    assert row(text, "3U", "all errors", "8")[3:] == ["0", "1", "2", "5"]
    assert "the most is 0.3 times the disturbance" in text
    assert "have not been looked at" not in text
