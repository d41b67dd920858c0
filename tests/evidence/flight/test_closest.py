"""docs/evidence/flight_hold.csv: how close tumbles can stay, beside what was flown."""

import pytest

from evidence.flight.closest import FILE, SOUGHT, Closest, compared, load, save
from evidence.flight.groups import all_groups
from evidence.flight.kept import Flights
from evidence.flight.kept import load as load_flights
from evidence.paper import ROOT
from orchestration import InputError


def test_flights_are_set_beside_the_least_largest_error_of_their_tumble():
    largest = ("4", "6", "12", "9", "")
    lines = [{"group": "drag", "run": f"{run}", "later_max_deg": most} for run, most in enumerate(largest)]
    found = [Closest("drag", run, error) for run, error in enumerate((2.0, 4.0, 6.0, float("nan"), 3.0))]
    (row,) = compared(Flights(tuple(lines)), found)
    assert row[1:] == ["3", "4°", "6°", "6°", "12°", "2", "1", "1.5", "2", "2"]
    assert compared(Flights(tuple(lines)), []) == []


def test_they_are_kept_by_group_and_run(tmp_path):
    kept = [Closest("drag", 1, 0.5), Closest("wheel stuck", 2, 1.5), Closest("drag", 0, 2.5)]
    save(tmp_path / FILE, kept)
    assert load(tmp_path / FILE) == [kept[1], kept[2], kept[0]]
    (tmp_path / FILE).write_text("group,run\n")
    with pytest.raises(InputError, match="python -m evidence flight --holds"):
        load(tmp_path / FILE)


def test_it_is_known_of_all_that_are_sought_and_none_was_flown_closer():
    """The search has stronger rods, knows all and has no start; it leaves out only what happens within an interval."""
    flights, found = load_flights(ROOT / "docs" / "evidence" / "flight.csv"), load(ROOT / "docs" / "evidence" / FILE)
    sought = {group.name: group.runs for group in all_groups(1000) if group.name in SOUGHT}
    assert [(one.group, one.run) for one in found] == [(name, run) for name in SOUGHT for run in range(sought[name])]
    for group in SOUGHT:
        most = flights.column(group, "later_max_deg")
        assert all(most[one.run] >= one.error_deg - 0.01 for one in found if one.group == group)
