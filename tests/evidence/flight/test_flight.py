"""The study of flights in SI units: what it flies, how it judges, and that an interrupted study goes on."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evidence.crew import crew
from evidence.flight import cases, kept, schemes
from evidence.flight.figures import errors
from evidence.flight.groups import all_groups
from evidence.flight.tried import TRIED
from orchestration import run
from orchestration.campaign.flying.job import Pilot


def drawn(group, n):
    """Start values of the first n runs, by name."""
    return replace(group, runs=n).drawn()


def tried(name, n=5):
    return drawn(next(t for t in TRIED if t.name == name).group(n), n)


# ---------------------------------------------------------------- how it judges


def flown(**metrics):
    """Rows of a campaign with these metrics, rates that settle at once, and nothing else of note."""
    n = len(next(iter(metrics.values())))
    names = [m["name"] for m in cases.metrics(cases.LONG, cases.EARLY, schemes.base())]
    usual = dict.fromkeys([*names, "plant.node_longitude"], np.zeros(n)) | metrics
    return SimpleNamespace(
        manifest={"metrics": [{"name": name} for name in names]},
        numbers=lambda name: np.asarray(usual[name], float),
        index=np.arange(n),
        failed=np.isnan(np.asarray(usual["angle_5"], float)),
        reasons=lambda: {3: "the plant stopped"},
        __len__=lambda: n,
    )


def test_a_flight_is_settled_from_when_both_errors_are_and_one_that_loses_it_again_is_not():
    end, nan = cases.LONG, math.nan
    rows = flown(
        angle_5=[400.0, 300.0, math.inf, nan, 9000.0, end - 1999.0, 9000.0],
        angle_1=[410.0, 500.0, math.inf, nan, 9000.0, end - 1999.0, end - 1999.0],
        rate=[350.0, 450.0, 20.0, nan, 8000.0, 20.0, 20.0],
        early_angle_5=[400.0, 300.0, 600.0, nan, 6000.0, math.inf, math.inf],
        early_rate=[350.0, 450.0, 20.0, nan, 6000.0, 20.0, 20.0],
        later_max=np.radians([0.1, 0.2, 30.0, nan, 20.0, 90.0, 50.0]),
    )
    lines = kept.lines(cases.tumbles("nominal", 100, 7), rows, [None] * 7)
    assert [line["settled_5deg_s"] for line in lines] == ["400", "450", "", "", "", "", "9000"]
    assert [line["settled_1deg_s"] for line in lines] == ["410", "500", "", "", "", "", ""]
    assert [line["early_5deg_s"] for line in lines] == ["400", "450", "600", "", "6000", "", ""]
    found = kept.Flights(tuple(lines)).lost("nominal").tolist()
    assert found == [False, False, True, False, True, False, False]
    assert lines[2]["later_max_deg"] == "30"
    assert lines[3]["remark"] == "the run failed: the plant stopped"


def test_a_flight_is_judged_by_the_angle_to_lvlh_and_the_rate_less_the_orbits_of_the_true_motion():
    """Witness: SciPy on the plant's recorded motion."""
    group = cases.tumbles("errors", 7, 1, errors=True)
    data = schemes.change(group.scenario, drawn(group, 1)[0])
    recorded = (
        "plant.R_NB plant.omega_B plant.r_N plant.v_N controller.attitude_error judge.attitude_error judge.rate_error_B"
    )
    result = run({**data, "duration": 60.0, "record": {"interval": 1.0, "signals": recorded.split()}})
    error, rate = errors(result)
    R, r, v = (result[f"plant.{name}"] for name in ("R_NB", "r_N", "v_N"))
    normal = np.cross(r, v)
    y, z = -normal / np.linalg.norm(normal, axis=1)[:, None], -r / np.linalg.norm(r, axis=1)[:, None]
    lvlh = Rotation.from_matrix(np.stack((np.cross(y, z), y, z), axis=2))
    turning = Rotation.from_matrix(R).inv().apply(normal / (r * r).sum(axis=1)[:, None])
    np.testing.assert_allclose(error, (lvlh.inv() * Rotation.from_matrix(R)).magnitude(), rtol=1e-12)
    np.testing.assert_allclose(rate, np.linalg.norm(result["plant.omega_B"] - turning, axis=1), rtol=1e-11)
    assert np.abs(error - result["controller.attitude_error"]).max() > 1e-5, "sensors err, the judge does not"


# ---------------------------------------------------------------- what is flown


def test_the_errors_are_those_that_the_page_names():
    for start in drawn(cases.tumbles("errors", 200, 50, errors=True), 50):
        off = np.diag(start["plant.J_error_B"]) / np.diag(cases.J)
        assert ((np.abs(off) >= 0.05) & (np.abs(off) <= 0.1)).all()
        assert np.linalg.norm(start["controller.field_error"]) == pytest.approx(200e-9)
        assert np.linalg.norm(start["plant.disturbance_torque_B"]) == pytest.approx(1e-5)
        assert np.linalg.norm(start["plant.omega_B0"]) <= math.radians(6.0)
        Q = np.array(start["plant.Q0"])
        np.testing.assert_allclose(Q @ Q.T, np.eye(3), atol=1e-12)
        assert isinstance(start["sensors.seed"], int)


def test_attitudes_rates_and_nodes_are_spread_as_the_page_says():
    starts = drawn(cases.tumbles("nominal", 100, 1000), 1000)
    angles = [Rotation.from_matrix(s["plant.Q0"]).magnitude() for s in starts]
    # Uniform on SO(3) the angle has the distribution (x - sin x)/pi; uniform rates and nodes are themselves.
    for values, cumulative in (
        (angles, lambda x: (x - np.sin(x)) / math.pi),
        ([np.linalg.norm(s["plant.omega_B0"]) for s in starts], lambda x: x / math.radians(6.0)),
        ([s["plant.node_longitude"] for s in starts], lambda x: x / (2.0 * math.pi)),
    ):
        gap = np.abs(cumulative(np.sort(values)) - (np.arange(1000) + 0.5) / 1000.0).max()
        assert gap < 1.63 / math.sqrt(1000.0)  # Kolmogorov's bound at 1%


@pytest.mark.parametrize("group", [g for g in all_groups(1000) if g.seed], ids=lambda g: g.name)
def test_every_scheme_and_condition_flies_the_same_tumbles(group):
    kind = next((k for k in ("nominal", "errors") if group.seed == cases.SEEDS[k]), "tried")
    usual = drawn(cases.tumbles("usual", cases.SEEDS[kind], 3), 3)
    for start, other in zip(usual, drawn(group, 3), strict=True):
        for name in ("plant.Q0", "plant.node_longitude", "sensors.seed"):
            assert start[name] == other[name]
        rate, its = np.array(start["plant.omega_B0"]), np.array(other["plant.omega_B0"])
        np.testing.assert_allclose(rate / np.linalg.norm(rate), its / np.linalg.norm(its), rtol=1e-12)


def test_every_group_has_a_name_of_its_own_and_a_trial_flies_each_of_them():
    names = [group.name for group in all_groups(1000)]
    assert len(set(names)) == len(names)
    assert [group.name for group in all_groups(2)] == names
    assert sum(group.runs for group in all_groups(1000)) > 4000
    assert all(1 <= group.runs <= 2 for group in all_groups(2))


def test_an_eccentric_start_is_a_perigee_of_eccentricity_0_02_above_the_same_node():
    for start, usual in zip(tried("eccentric"), tried("as nominal"), strict=True):
        r, v, mu = np.array(start["plant.r_N0"]), np.array(start["plant.v_N0"]), 3.986004418e14
        e = np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r)
        assert np.linalg.norm(e) == pytest.approx(0.02, rel=1e-6)
        assert e @ r == pytest.approx(0.02 * np.linalg.norm(r), rel=1e-6)
        assert 1.0 / (2.0 / np.linalg.norm(r) - v @ v / mu) == pytest.approx(6971e3, rel=1e-6)
        assert start["plant.node_longitude"] == usual["plant.node_longitude"]
    ascending = [np.cross([0, 0, 1], np.cross(s["plant.r_N0"], s["plant.v_N0"])) for s in tried("eccentric")]
    turned = np.diff([math.atan2(a[1], a[0]) for a in ascending])
    expected = np.diff([s["plant.node_longitude"] for s in tried("as nominal")])
    np.testing.assert_allclose(np.cos(turned - expected), 1.0, atol=1e-12)


def test_a_body_with_products_is_a_body_and_lies_within_its_bounds():
    J = np.diag(cases.J)
    for start in tried("products known", 50):
        body = np.array(start["plant.J_B"])
        assert start["controller.J_B"] == start["plant.J_B"]
        np.testing.assert_allclose(body, body.T, atol=1e-15)
        moments = np.linalg.eigvalsh(body)
        assert moments[2] < moments[0] + moments[1]
        assert ((moments >= 0.75 * J) & (moments <= 1.25 * J)).all()
    assert max(abs(np.array(s["plant.J_B"])[0, 1]) for s in tried("products known")) > 0.01
    for start in tried("products unknown", 50):
        moments = np.linalg.eigvalsh(np.diag(J) + np.array(start["plant.J_error_B"]))
        assert ((moments >= 0.9 * J) & (moments <= 1.1 * J)).all()


def test_each_rod_is_turned_by_two_degrees():
    rods = np.array([[1, 1, -1], [1, -1, 1], [0, 0, math.sqrt(3)]]) / math.sqrt(3)
    for start in tried("rods misaligned"):
        turned = np.array(start["plant.rod_axes"])
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1.0, rtol=1e-12)
        between = np.degrees(np.arccos((turned * rods / np.linalg.norm(rods, axis=1)[:, None]).sum(axis=1)))
        np.testing.assert_allclose(between, 2.0, rtol=1e-6)


def test_another_controller_keeps_the_wires_that_it_has():
    data = schemes.tuned(schemes.base())
    wires = set(data["connections"])
    assert "sensors.R_NB_measured -> controller.R_NB" in wires
    assert "controller.tau_cmd_B -> allocator.tau_cmd_B" in wires
    assert not any("u_applied" in wire or "_ff" in wire or "controller.h_w" in wire for wire in wires)
    assert "field_error" not in data["blocks"]["controller"]["start"]


@pytest.mark.parametrize("group", all_groups(2), ids=lambda g: g.name)
def test_each_group_flies(group):
    short = replace(group, duration=20.0, early=10.0).case
    pilot = Pilot(short.job)
    _, status, reason, *_ = pilot.fly(0, short.job.design.points([0])[0])
    pilot.close()
    assert (status, reason) == ("ok", None)


# ---------------------------------------------------------------- campaigns


def test_a_study_goes_on_where_it_was_and_flies_anew_what_other_values_decide(tmp_path):
    few = replace(cases.tumbles("nominal", 100, 2), duration=20.0, early=10.0)
    with crew(0) as hands:
        first = hands.fly(few.case, tmp_path)
        more = hands.fly(replace(few, runs=3).case, tmp_path)
        other = hands.fly(replace(few, seed=101).case, tmp_path)
    assert more.folder == first.folder != other.folder
    assert len(list((more.folder / "runs").glob("*.parquet"))) == 2  # what was there, and one run more
    assert more.index.tolist() == [0, 1, 2]
    assert (more.numbers("angle_5")[:2] == first.numbers("angle_5")).all()


def test_calls_of_a_crew_come_back_in_their_order():
    with crew(0) as hands:
        assert hands.each("squares", lambda x: x * x, [3, 1, 2]) == [9, 1, 4]
