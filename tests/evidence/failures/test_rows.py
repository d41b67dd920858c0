"""The rows of docs/evidence/failures.md: scenarios in which the part fails that the row names, and what of a flight
is kept."""

import math

import pytest

from evidence.failures.kept import flight
from evidence.failures.make import PART, parts
from evidence.failures.rows import ROWS, TABLES
from evidence.paper import ORBIT

SOUND = dict.fromkeys(
    ("rod_failed", "wheel_failed", "attitude_frozen", "field_failed", "rod_1", "rod_2", "rod_3"), math.inf
)
FLOWN = {
    "angle": 500.0,
    "rate": 600.0,
    "within_15": 300.0,
    "within_5": 500.0,
    "given_up": math.inf,
    "hold_rms": 1e-3,
    "hold_max": 2e-3,
    **SOUND,
}


def row(text, table="rods"):
    return next(row for row in ROWS if row.text.startswith(text) and row.table == table)


@pytest.mark.parametrize(
    "wanted",
    [
        row("rod 2 reversed"),
        row("attitude frozen for 600 s, after", "sensors"),
        row("field with a bias of 3.6", "sensors"),
    ]
    + [r for r in ROWS if r.table == "wheel" and ("one orbit" in r.text or "1 mN m s" in r.text)]
    + [row("rod 1 dead", "unsearched")],
    ids=lambda row: row.text,
)
def test_a_row_is_a_campaign_of_three_orbits_from_the_failure_on(wanted):
    case = wanted.case(3)
    assert case.runs == 3
    assert case.scenario.duration == pytest.approx(wanted.at + 3.0 * ORBIT, abs=0.1)


def test_rows_have_names_of_their_own():
    assert len({row.name for row in ROWS}) == len(ROWS)


def test_a_failure_is_found_from_it_on_and_settled_counts_from_the_start():
    late = row("rod 2 dies")
    found = flight(late, 0, FLOWN | {"rod_failed": 6050.0, "rod_2": 6060.0})
    assert (found.found_s, found.settled_s, found.others) == (60.0, 600.0, "")


def test_another_rod_another_part_and_a_failure_told_before_it_comes_are_others():
    late = row("rod 2 dies")
    found = flight(late, 0, FLOWN | {"rod_failed": 5000.0, "rod_1": 5000.0, "rod_2": 6070.0, "field_failed": 7000.0})
    assert found.found_s == 70.0
    assert found.others == "rod_failed field_failed rod_1"


def test_what_is_settled_only_at_the_end_is_not():
    assert flight(row("rod 2 dead"), 0, FLOWN | {"angle": 3.0 * ORBIT - 1000.0}).settled_s == math.inf


def test_the_rows_of_a_table_have_as_many_flights_at_any_time_to_a_part():
    flown = dict.fromkeys((row.name for row in ROWS if row.table in TABLES[:2]), 0)
    for wanted, most in parts(5, TABLES[:2]):
        flown[wanted.name] = most
        assert max(flown.values()) - min(flown.values()) <= PART
    assert set(flown.values()) == {5}
