"""docs/evidence/estimation.md: its tables say what the flights in docs/evidence/health.csv say."""

import math
from pathlib import Path

import pytest

from evidence.health import page
from evidence.health.allowed import least
from evidence.health.kept import Flight, flight, load
from evidence.health.rows import ROWS, named
from evidence.paper import ROOT

GYRO = "estimated: gyro frozen, in the hold"
WHEEL = "estimated: wheel stuck, in the hold"


def row(name):
    return next(row for row in ROWS if row.name == name)


def one(name=GYRO, run=0, **more):
    good = {"least_deg": 0.0, "held_deg": 3.0, "rate_deg_s": 0.0, "spin_deg_s": 0.1, "largest_deg": 3.0}
    return Flight(name, run, **{**good, "last_deg": 1.0, "named_s": 10.0, "others": "", "remark": "", **more})


def test_the_page_is_that_of_the_kept_flights():
    assert (ROOT / "docs" / "evidence" / "estimation.md").read_text("utf-8") == page.text(load())


@pytest.mark.parametrize(
    ("outcome", "more"),
    [
        ("held", {}),
        ("safe", {"largest_deg": 90.0, "rate_deg_s": 0.9}),
        ("lost", {"largest_deg": 90.0, "rate_deg_s": 1.1}),
        ("lost", {"largest_deg": 90.0, "held_deg": 16.0}),
        ("safe", {"largest_deg": 90.0, "held_deg": 90.0, "least_deg": 16.0, "spin_deg_s": 0.9}),
        ("lost", {"largest_deg": 90.0, "held_deg": 90.0, "least_deg": 16.0, "spin_deg_s": 1.1}),
        ("lost", {"largest_deg": 90.0, "held_deg": 90.0, "least_deg": 16.0, "named_s": math.inf}),
        ("lost", {"largest_deg": 90.0, "held_deg": 90.0, "least_deg": 14.0}),
        ("lost", {"remark": "the run failed: x"}),
    ],
)
def test_what_becomes_of_a_flight_follows_from_what_is_left(outcome, more):
    assert one(**more).outcome == outcome


def test_lost_flights_are_counted_by_their_satellite():
    text = page.text([one(), one(run=1, largest_deg=90.0, held_deg=90.0, others="rod_2")])
    cells = next(line for line in text.splitlines() if line.startswith("| gyro frozen |"))
    assert cells.strip("| ").split(" | ")[1:] == ["1 of 2: coarse 1", "0", "2 of 2, 10 s; another 1"]
    assert "in 1 of 2 flights, of 1 of 1 kinds" in text
    assert "were held stay within 3°; the others turn at 0.1 deg/s at most" in text


def test_a_failed_run_is_lost_and_other_parts_are_those_that_have_not_failed():
    nothing = dict.fromkeys(("held", "rate", "spin", "largest", "last", *named()), math.nan)
    assert flight(row(GYRO), 0, nothing, 0.0, "the run failed: x").outcome == "lost"
    both = row("estimated: rods 1 and 2 dead, in the hold")
    told = dict.fromkeys(("held", "rate", "spin", "largest", "last"), 1.0) | dict.fromkeys(named(), math.inf)
    told |= {"rod_1": both.at + 50.0, "rod_2": both.at + 20.0, "wheel": both.at + 70.0}
    found = flight(both, 0, told, 0.0)
    assert (found.named_s, found.others) == (20.0, "wheel")


def test_a_disturbance_that_the_wheel_is_wanted_for_bounds_a_hold_by_rods_alone():
    place = {"plant.node_longitude": 1.0, "plant.argument_of_latitude": 2.0}
    push = {f"plant.disturbance_torque_B[{i}]": x for i, x in ((1, 6e-6), (2, -5e-6), (3, 6e-6))}
    strong, weak = (least(row(WHEEL), place | {k: f * x for k, x in push.items()}) for f in (1.0, 0.1))
    assert strong == pytest.approx(10.0 * weak, rel=0.2)
    assert strong > 5.0
    assert least(row(GYRO), {}) == 0.0
    assert Path(page.__file__).with_name("page.md.j2").is_file()
