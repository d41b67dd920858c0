"""The rows of `python -m evidence health`: campaigns with the failure that each names, and the words of its table."""

import math
from dataclasses import replace

import numpy as np
import pytest

from evidence.health.make import line
from evidence.health.rows import AFTER, HOLD, ROWS, TUMBLE, named
from evidence.paper import ORBIT


def row(name):
    return next(row for row in ROWS if row.name == name)


def test_rows_have_names_of_their_own_and_name_parts_that_are_watched():
    assert len({row.name for row in ROWS}) == len(ROWS)
    assert {row.part for row in ROWS} - {""} == set(named())


@pytest.mark.parametrize(
    "name",
    [
        "estimated: rod 1 dead for 60 s of each 120 s, in the hold",
        "cubesat: nothing",
        "estimated_star_tracker: star tracker frozen for 1200 s, in the hold",
    ],
)
def test_a_row_is_a_campaign_from_any_place_on_the_orbit_with_its_failure(name):
    case = row(name).case(3)
    assert case.runs == 3
    assert case.scenario.duration == pytest.approx(HOLD + AFTER, abs=0.5)
    assert len(case.scenario.faults) == {"rod": 9, "not": 0, "sta": 1}[name.split(": ")[1][:3]]
    places = [p["plant.argument_of_latitude"] for p in map(case.job.draws.texts, map(case.job.draws.at, points(case)))]
    assert np.ptp([float(str(p).split()[0]) for p in places]) > 0.1


def points(case):
    return case.job.design.points(range(3)).tolist()


def test_a_flight_beyond_15_deg_is_lost_and_a_part_is_named_from_its_failure_on():
    metrics = {name: np.full(3, math.inf) for name in named()}
    metrics |= {"late": np.array([2.0, 14.0, math.nan])}
    metrics |= {"largest": np.array([2.0, 16.0, math.nan]), "gyro": HOLD + np.array([10.0, 30.0, math.inf])}
    metrics["rod_2"] = np.array([math.inf, HOLD + 5.0, math.inf])
    wanted = row("estimated: gyro frozen, in the hold")
    assert line(wanted, metrics)[1:6] == ["3", "2", "2 of 3", "20 s", "1"]
    assert line(replace(wanted, at=TUMBLE), metrics)[2] == "1"  # within half an hour the tumble may end
    assert 1.5 * ORBIT == AFTER
