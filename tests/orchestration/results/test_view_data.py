"""What a page's three-dimensional view is given."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest

from orchestration import InputError, run
from orchestration.results import report, view
from orchestration.results.arrays import Arrays

from .flown import RADIUS, flown
from .swing import data_of, swing

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def test_the_motion_is_kept_to_the_resolution_of_two_bytes():
    result, arrays = flown(), Arrays()
    shown = view.view(result, arrays)
    assert shown is not None
    item = arrays.items[shown["attitude"]]
    kept = np.frombuffer(base64.b64decode(item["data"]), "<i2").reshape(-1, 4) * item["scale"]
    np.testing.assert_allclose(kept, result["a.q"], atol=1.0 / 32767)
    assert shown["axes"] == [{"name": "wheel", "kind": "wheel", "direction": [0.0, 0.0, 1.0]}]
    assert [(v["name"], v["frame"], v["unit"]) for v in shown["vectors"]] == [
        ("field", "body", "T"),
        ("momentum", "inertial", "N.m.s"),
    ]
    assert shown["vectors"][1]["largest"] == pytest.approx(101.0)  # along a direction whose length does not count
    assert shown["body"] == {"length": 1.0, "width": 1.0, "axis": 0, "sides": 4}
    assert np.linalg.norm(result["a.r"], axis=1) == pytest.approx(RADIUS)


def test_a_view_has_the_wheels_and_sensors_that_are_there():
    found = {}
    for name in ("flight_three_wheels", "flight_pyramid", "flight_estimated", "flight_star_tracker"):
        shown = view.view(run(SCENARIOS / f"{name}.yaml", duration="1 s"), Arrays())
        wheels = [axis["name"] for axis in shown["axes"] if axis["kind"] == "wheel"]
        found[name] = len(wheels), [cone["name"] for cone in shown["cones"]]
    tracker = ["star tracker"]
    assert found == {
        "flight_three_wheels": (3, tracker),
        "flight_pyramid": (4, []),
        "flight_estimated": (1, []),
        "flight_star_tracker": (1, tracker),
    }


def test_a_body_may_be_as_long_and_wide_as_parameters_of_a_block_say():
    assert flown(view={"attitude": "a.q", "body": {"length": "a.k", "width": "a.k"}}).failure is None


def test_a_scenario_without_an_attitude_has_no_view():
    assert view.view(swing(), Arrays()) is None
    assert "view" not in data_of(report.page(swing()))


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"attitude": "a.r"}, "a.r is a real [3]; expected the shape [3, 3] or the shape [4]"),
        ({"attitude": "a.q", "position": "a.rr"}, "view.position: a has no variable 'rr'"),
        ({"attitude": "a.q", "epoch": "a.date"}, "there is no parameter a.date; expected a parameter of a block"),
        ({"attitude": "a.q", "epoch": "a.k"}, "view.epoch: a.k is a real scalar; expected text"),
        (
            {"attitude": "a.q", "axes": {"wheel": "a.k"}},
            "view.axes.wheel: a.k is a real scalar; expected directions, [3] or",
        ),
        ({"attitude": "a.q", "axes": {"wheel": [[0, 0, 0]]}}, "view.axes.wheel[1]: expected a vector that is not zero"),
        ({"attitude": "a.q", "axes": {"wheel": [[1, 0]]}}, "view.axes.wheel[1]: expected at least 3 elements, found 2"),
        ({"attitude": "a.q", "body": {"length": "a.k", "width": "a.n"}}, "there is no parameter a.n"),
        ({"attitude": "a.q", "body": {"length": 0}}, "view.body.length: expected more than 0, found 0"),
        (
            {"attitude": "a.q", "body": {"length": "long"}},
            "view.body.length: expected block.variable or a number, found 'long'",
        ),
        (
            {"attitude": "a.q", "body": {"axis": "w"}},
            "view.body.axis: expected block.variable or 'x', 'y' or 'z', found 'w'",
        ),
        ({"attitude": "a.q", "desired": 5}, "view.desired: expected text or 'lvlh', found 5"),
        ({"attitude": "a.q", "estimated": "a.r"}, "view.estimated: a.r is a real [3]; expected the shape [3, 3] or"),
    ],
)
def test_a_view_that_does_not_fit_is_refused_before_the_run(entry, said):
    with pytest.raises(InputError) as refused:
        flown(view=entry)
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("scenario", "duration", "ghosts"),
    [
        ("flight_tumble", "2 s", ("lvlh", "controller.R_d", None)),
        ("flight_estimated", "2 s", ("lvlh", None, "estimator.R_NB")),
        ("track_ground_station", "20 s", ("supervisor.R_ref", "controller.R_d", None)),
    ],
)
def test_the_goal_is_what_is_connected_to_the_controller_and_a_plan_or_an_estimate_is_told_apart(
    scenario, duration, ghosts
):
    entry = view.entry_of(run(SCENARIOS / f"{scenario}.yaml", duration=duration))
    assert entry is not None
    assert (entry.desired, entry.planned, entry.estimated) == ghosts


def test_the_earth_is_turned_by_the_sidereal_time_of_the_almanac():
    """Greenwich mean sidereal time at 0h UT1 on 10 April 1987, 13h 10m 46.3668s: Meeus, Astronomical Algorithms,
    example 12.a.
    """
    turned = view._earth_angle("1987-04-10T00:00:00Z")
    assert turned == pytest.approx(np.radians(15.0 * (13 + 10 / 60 + 46.3668 / 3600)), abs=1e-5)
