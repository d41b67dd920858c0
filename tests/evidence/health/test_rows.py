"""The rows of `python -m evidence health`: campaigns with the failure that each names, and the words of its table."""

import numpy as np
import pytest

from evidence.health.make import parts
from evidence.health.rows import AFTER, ROWS, named
from evidence.health.verdict import HOLD


def row(name):
    return next(row for row in ROWS if row.name == name)


def test_rows_have_names_of_their_own_and_name_parts_that_are_watched():
    assert len({row.name for row in ROWS}) == len(ROWS)
    assert {part for row in ROWS for part in row.parts} == set(named())


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


def test_rows_have_as_many_flights_at_any_time_and_those_by_rods_alone_come_last():
    order = list(parts(2, ["cubesat: wheel stuck", "cubesat: gyro frozen"]))
    assert [most for _, most in order] == [1, 1, 2, 2] * 2
    assert ["gyro" in row.name for row, _ in order] == [True] * 4 + [False] * 4
