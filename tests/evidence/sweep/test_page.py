"""docs/evidence/sweep.md, its file, and the loop that it is flown by."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from evidence.flight.cases import SEEDS, tumbles
from evidence.optimum.kept import FILE as FLOWN
from evidence.optimum.kept import load as load_flown
from evidence.paper import ROOT
from evidence.satellites.classes import tumbles as tumbles_of_satellite
from evidence.sweep.cases import FIELD, GROUPS, whole
from evidence.sweep.constants import CONSTANTS, NOT_SWEPT
from evidence.sweep.loop import Flight, Flown, built, flown, put, settled, tumbles_of, value_of
from evidence.sweep.make import FILE, load
from evidence.sweep.measures import MEASURES, line
from evidence.sweep.page import text
from fmus.block import Block

LINES = load(ROOT / "docs" / "evidence" / FILE)
KEY = ("hold", "plan.c", "HORIZON", 15.0)


def test_the_page_is_made_from_the_file():
    assert text(LINES) == (ROOT / "docs" / "evidence" / "sweep.md").read_text("utf-8")


@pytest.mark.parametrize("constant", CONSTANTS, ids=lambda c: f"{c.file} {c.name}")
def test_each_constant_was_flown_in_its_groups_at_the_multiples_of_the_value_that_it_has_or_is_said_to_wait(constant):
    waiting = (ROOT / "docs" / "evidence" / "sweep.md").read_text("utf-8").partition("which have not been made yet")[2]
    for group in constant.groups.split(", "):
        of = [each for each in LINES if (each.group, each.file, each.name) == (group, constant.file, constant.name)]
        if not of:
            assert re.search(rf"^\| {group} \| .*`{constant.name}` \({constant.file}\)", waiting, re.M)
            continue
        values = list(dict.fromkeys(each.value for each in of))
        usual = float(value_of(constant.file, constant.name))
        assert values == pytest.approx([usual * factor for factor in constant.factors], rel=0.21)
        assert {each.measure for each in of} == set(GROUPS[group].measures)


def test_each_constant_of_the_controller_is_swept_or_said_not_to_be():
    named = {name for names in NOT_SWEPT.values() for name in names.split()}
    swept = {f"{c.file}:{c.name}" for c in CONSTANTS}
    for file in sorted((Block.named("controller_planned").folder / "native").rglob("*.[ch]")):
        for definition in re.findall(r"^static const[^;]*;", file.read_text("utf-8"), re.M):
            for name in re.findall(r"\b([A-Z][A-Z_]+)(?:\[\w+\])? = ", definition):
                key = f"{file.name}:{name}"
                assert (key in swept) != (key in named or name in named), key


def test_a_ratio_is_the_geometric_mean_over_the_flights_that_ask_for_it_with_students_interval():
    values, chosen, most = np.array([2.0, 8.0, math.nan]), np.array([1.0, 1.0, math.nan]), np.full(3, 100.0)
    of = line(KEY, "hold", values, chosen, most)
    assert (of.runs, of.reached, of.median, of.worst) == (2, 2, 5.0, 8.0)
    assert (of.ratio, of.error) == pytest.approx((4.0, 12.7062 * math.log(2.0)), rel=1e-5)


def test_a_flight_that_does_not_settle_counts_as_its_end():
    of = line(KEY, "settled", np.array([math.inf]), np.array([50.0]), np.array([200.0]))
    assert (of.reached, of.worst, of.ratio) == (0, math.inf, 4.0)


@pytest.mark.parametrize(
    ("told", "found", "sound"),
    [({}, math.inf, 0.0), ({1: 40.0}, 30.0, 0.0), ({1: 5.0}, -5.0, math.inf), ({1: 40.0, 2: 20.0}, 30.0, math.inf)],
    ids=["nothing", "the rod that failed", "before it failed", "another rod as well"],
)
def test_an_alarm_before_a_failure_or_of_another_part_is_false(told, found, sound):
    flight = Flight({}, fails=10.0, expected=(1,))
    heard = Flown(told=tuple(told.get(i, math.inf) for i in range(7)))
    assert MEASURES["found"].of(flight, heard) == found
    assert MEASURES["sound"].of(flight, heard) == sound


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    return built(tmp_path_factory.mktemp("sweep") / "loop")


@pytest.mark.thorough
def test_the_loop_settles_when_the_fmus_do(loop):
    flown_s = [each.flown_s for each in load_flown(ROOT / "docs" / "evidence" / FLOWN)][:4]
    times = [settled(loop, tumble) for tumble in tumbles_of(tumbles("nominal", SEEDS["nominal"], 4))]
    assert np.abs(np.subtract(times, flown_s)).max() < 2.0


@pytest.mark.thorough
@pytest.mark.parametrize(("share", "seconds"), [("0.4", 20.0), ("1", 50.0)])
def test_a_frozen_field_is_found_after_the_time_that_its_constant_says(loop, share, seconds):
    frozen = GROUPS["failed sensors"].flights(3)[2]
    put(loop, "sensors_watch.c", "FIELD_FROZEN", share)
    told = flown(loop, replace(frozen, until=160.0)).told
    put(loop, "sensors_watch.c", "FIELD_FROZEN", "0.4")
    assert told[FIELD] - frozen.fails == pytest.approx(seconds, abs=1.0)


@pytest.mark.thorough
def test_a_rod_that_gives_nothing_is_named_and_no_other(loop):
    dead = GROUPS["failed rods"].flights(1)[0]
    told = flown(loop, replace(dead, until=150.0)).told
    assert [i for i, time in enumerate(told) if math.isfinite(time)] == [*dead.expected] == [0]


@pytest.mark.thorough
def test_a_strained_hold_that_sees_an_orbit_is_closer_than_one_that_sees_a_quarter(loop):
    """Near the equator the wheel has to be loaded up to three quarters of an orbit ahead."""
    group = tumbles_of_satellite("3U, wheel along e2", 54, errors=True)
    flight = whole(group, list(group.drawn())[53])
    held = flown(loop, flight)
    put(loop, "strained.h", "STRAINED_ORBITS_AHEAD", "0.25")
    try:
        before = flown(loop, flight)
    finally:
        put(loop, "strained.h", "STRAINED_ORBITS_AHEAD", value_of("strained.h", "STRAINED_ORBITS_AHEAD"))
    assert held.largest < math.radians(5.0)
    assert before.largest > math.radians(8.0)
