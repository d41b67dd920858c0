"""`orchestrate rank`: laws fly the same tumbles, and the table has what they did; laws to compare with."""

import csv
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from design import rank
from design.laws import bandwidth, bdot, lqr, paper, pd, unloading
from orchestration.session.read import read
from tests.commands import orchestrate

ROOT = Path(__file__).parents[2]
SCENARIO = "scenarios/flight_tumble.yaml"
J = np.diag([0.042, 0.03, 0.007])


def seen(**changes):
    """LVLH of an orbit over the pole, at rest in it."""
    r, v = np.array([7e6, 0.0, 0.0]), np.array([0.0, 0.0, 7500.0])
    down, side = np.array([-1.0, 0.0, 0.0]), -np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    R = np.column_stack((np.cross(side, down), side, down))
    rest = {
        "R_NB": R,
        "omega_B": R.T @ np.cross(r, v) / (r @ r),
        "r_N": r,
        "v_N": v,
    }
    rest["b_B"], rest["h_w"] = np.array([2e-5, 1e-5, -3e-5]), 0.0
    return SimpleNamespace(**{**rest, **changes})


ONE = {"wheel_axis": np.array([1.0, 0.0, 0.0]), "wheel_torque_max": 3e-4, "wheel_momentum_max": 2e-3}
P = SimpleNamespace(J_B=J, dipole_max=0.3, rod_limits=np.ones(3), rod_axes=np.eye(3), control_period=0.5, **ONE)


@pytest.mark.parametrize("law", [pd, lqr])
def test_at_the_reference_no_torque_is_asked_for_and_a_turn_is_opposed(law):
    assert np.abs(law.step(seen(), P, 0.0, 0.5)["tau_cmd_B"]).max() < 1e-18
    small = 1e-3
    turn = np.array([[1, 0, 0], [0, 1, -small], [0, small, 1]])
    tau = law.step(seen(R_NB=seen().R_NB @ turn), P, 0.0, 0.5)["tau_cmd_B"]
    assert tau[0] < 0.0
    assert np.abs(tau[1:]).max() < abs(tau[0])


def test_the_papers_law_has_the_stiffness_and_damping_that_it_says():
    """tau = -w^2 J zeta - 2 w J omega of small errors, beside gravity gradient and gyroscopic torque."""
    p = SimpleNamespace(**vars(P), **paper.PARAMETERS)
    w = 0.5 * np.sqrt(0.3 * 4.4e-5 / (np.trace(J) / 3.0))
    small = np.array([1e-5, -2e-5, 1.5e-5])
    turn = np.eye(3) + np.cross(np.eye(3), small)  # small^
    still, turned = (
        paper.step(seen(R_NB=seen().R_NB @ Q, omega_B=Q.T @ seen().omega_B), p, 0.0, 0.5)["tau_cmd_B"]
        for Q in (np.eye(3), turn)
    )
    n2 = (7500.0 / 7e6) ** 2  # what moves with the attitude of gravity gradient and gyroscopic torque is of this size
    assert turned - still == pytest.approx(-w * w * J @ small, abs=10.0 * n2 * 0.042 * 2e-5)
    faster = paper.step(seen(omega_B=seen().omega_B + small), p, 0.0, 0.5)["tau_cmd_B"]
    assert faster - still == pytest.approx(-2.0 * w * J @ small, rel=1e-6)
    tau = paper.step(seen(R_NB=np.zeros((3, 3)), omega_B=small), p, 0.0, 0.5)["tau_cmd_B"]
    assert tau == pytest.approx(-2.0 * w * J @ small, rel=1e-12)


def test_b_dot_takes_the_rate_across_the_field_away_as_its_gain_says():
    """m x b = -k (omega - b (b.omega)/|b|^2), with k = 2 n (1 + sin i) J_min of an orbit over the pole."""
    omega = np.array([1e-4, -2e-4, 1e-4])
    u = seen(omega_B=omega)
    dipole = bdot.step(u, P, 0.0, 0.5)["dipole_ff"]
    b, n = u.b_B, 7500.0 / 7e6
    expected = -2.0 * n * 2.0 * 0.007 * (omega - b * (b @ omega) / (b @ b))
    assert np.cross(dipole, b) == pytest.approx(expected, rel=1e-9)
    fast = bdot.step(seen(omega_B=np.array([1.0, 2.0, 0.5])), P, 0.0, 0.5)["dipole_ff"]
    assert np.abs(fast).max() == pytest.approx(0.3)


def test_the_unloading_law_is_quaternion_feedback_with_a_wheel_that_empties_in_its_time():
    turned = seen(omega_B=np.array([1e-3, -2e-3, 3e-3]), h_w=-1.2e-3)
    found = unloading.step(turned, P, 0.0, 0.5)
    w = 0.5 * np.sqrt(0.3 * 4.4e-5 / (np.trace(J) / 3.0))
    assert found["wheel_torque_ff"] == pytest.approx(1.2e-3 * w / 10.0)
    assert found["tau_cmd_B"] == pytest.approx(pd.step(turned, P, 0.0, 0.5)["tau_cmd_B"])


def of_wheels(axes, torque, momentum=0.02, period=0.1, inertia=J):
    """A set of wheels, its unused places filled as `orchestrate new satellite` does."""
    rows = np.array([*axes, *axes][:4], float)
    limits = {"wheel_torque_max": np.full(4, torque), "wheel_momentum_max": np.full(4, momentum)}
    return SimpleNamespace(
        J_B=inertia, dipole_max=0.3, wheels=len(axes), wheel_axis=rows, command_period=period, **limits
    )


def test_the_bandwidth_is_that_at_which_an_error_of_a_radian_takes_the_whole_torque():
    """Three wheels along the axes give 2e-5 N m about any axis; four in a pyramid 2 cos(e)cos(45 deg) and 4 sin(e)
    along z, that of a plane of two wheels at the least; two leave an axis to the rods, at half the frequency."""
    mean = np.trace(J) / 3.0
    assert bandwidth.frequency(of_wheels(np.eye(3), 2e-5)) == pytest.approx(np.sqrt(2e-5 / mean))
    flat, up = np.cos(np.radians(35.0)) / np.sqrt(2.0), np.sin(np.radians(35.0))
    pyramid = [[x * flat, y * flat, up] for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    drawn = np.random.default_rng(1).normal(size=(20000, 3))
    support = np.abs(drawn @ np.transpose(pyramid)).sum(1) / np.linalg.norm(drawn, axis=1)
    found = bandwidth.frequency(of_wheels(pyramid, 2e-5))
    assert found**2 * mean == pytest.approx(2e-5 * support.min(), rel=5e-3)
    rods = np.sqrt(0.3 * 4.4e-5 / mean)
    for axes in (np.eye(3)[:2], [[1, 0, 0], [0, 1, 0], [0.6, 0.8, 0]]):
        assert bandwidth.frequency(of_wheels(axes, 2e-5)) == pytest.approx(0.5 * rods)


def test_the_bandwidth_leaves_the_control_ten_samples_and_rods_alone_a_fifth():
    assert bandwidth.frequency(of_wheels(np.eye(3), 1.0, period=0.5)) == pytest.approx(0.2)
    alone = SimpleNamespace(**{**vars(P), "wheel_torque_max": 1e-9, "wheel_momentum_max": 1e-9})
    assert bandwidth.frequency(alone) == pytest.approx(0.4 * bandwidth.frequency(P))


def test_full_wheels_ask_no_more_than_a_rod_gives():
    p = of_wheels(np.eye(3), 2e-5, momentum=1.0)
    assert 3.0 / bandwidth.emptied_in(p) == pytest.approx(0.3 * 4.4e-5)
    assert bandwidth.emptied_in(of_wheels(np.eye(3), 2e-5, momentum=1e-7)) == pytest.approx(
        10.0 / bandwidth.frequency(p)
    )


def test_tumbles_are_rotations_and_rates_of_one_size_and_the_same_for_a_seed():
    drawn = rank.tumbles(4, 0.07, 3)
    for one in drawn:
        Q = np.array(one["plant.Q0"])
        assert pytest.approx(np.eye(3), abs=1e-12) == Q.T @ Q
        assert np.linalg.det(Q) == pytest.approx(1.0)
        assert np.linalg.norm(one["plant.omega_B0"]) == pytest.approx(0.07)
    assert rank.tumbles(4, 0.07, 3) == drawn
    assert rank.tumbles(4, 0.07, 4) != drawn


def test_an_error_that_was_large_in_the_last_sixth_has_not_settled():
    time = np.arange(0.0, 600.0)
    for last, settled in ((300, 301.0), (498, 499.0), (500, None)):
        error = np.where(time == last, 1.0, 0.1)
        found = rank.for_good(time, error, 0.5)
        assert (found.time, math.isnan(found.rms)) == (settled, settled is None)
    assert rank.for_good(time, error + 1.0, 0.5).time is None


def test_the_command_flies_all_and_writes_the_table(tmp_path):
    law = tmp_path / "still.py"
    law.write_text("def step(i, p, t, h):\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    table = tmp_path / "ranked.csv"
    arguments = ("--scenario", SCENARIO, "--runs", 2, "--duration", "4 s", "--below", 181, "--out", table)
    result = orchestrate("rank", law, *arguments)
    assert result.exit_code == 0, result.stderr
    rows = {row["law"]: row for row in csv.DictReader(table.open())}
    assert set(rows) == {"still", rank.OWN, "bdot", "pd", "unloading", "lqr", "paper"}
    assert all((row["settled"], row["runs"], float(row["median, s"])) == ("2", "2", 0.0) for row in rows.values())
    largest = {float(row["largest after, deg"]) for row in rows.values()}
    assert len(largest) > 1
    assert math.pi < max(largest) <= 180.0


def test_new_laws_fly_first_and_an_error_of_each_flight_is_told_once(tmp_path, monkeypatch):
    flown = []
    monkeypatch.setattr(rank, "ranked", lambda laws, *_: flown.extend(laws) or [])
    law = tmp_path / "mine.py"
    law.write_text("def step(i, p, t, h):\n    assert t < 2\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    arguments = ("--scenario", SCENARIO, "--runs", 3, "--duration", "4 s")
    orchestrate("rank", law, *arguments)
    assert flown[:2] == ["mine", rank.OWN]
    monkeypatch.undo()
    assert orchestrate("rank", law, "--alone", *arguments).stderr.count("AssertionError") == 1


def test_a_law_that_fails_is_counted_and_told(tmp_path):
    law = tmp_path / "wrong.py"
    law.write_text("def step(i, p, t, h):\n    assert t < 2\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    arguments = ("--alone", "--scenario", SCENARIO, "--runs", 1, "--duration", "4 s", "--below", 181)
    result = orchestrate("rank", law, *arguments)
    assert f"{Path(law)}:2: AssertionError" in result.stderr
    assert "0 of 1" in result.stdout
    assert (result.exit_code, "every flight of wrong failed" in result.stderr) == (3, True)
    still = tmp_path / "still.py"
    still.write_text("def step(i, p, t, h):\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    assert orchestrate("rank", law, still, *arguments).exit_code == 3
    assert orchestrate("rank", still, *arguments).exit_code == 0


@pytest.mark.skipif(sys.platform != "linux", reason="flights are waited for on Linux alone")
def test_a_law_that_ends_the_process_is_no_success(tmp_path):
    law = tmp_path / "law.py"
    law.write_text("import os\ndef step(i, p, t, h):\n    if t > 2: os._exit(0)\n    return {'tau_cmd_B': [0.0] * 3}\n")
    line = [sys.executable, "-m", "orchestration", "rank", str(law), "--alone", "--duration", "5 s", "--scenario"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [*line, str(ROOT / "scenarios" / "flight_tumble.yaml")],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 3
    assert "law: controller: step at 2 s: ended its process, with exit status 0" in done.stderr
    assert "every flight of law failed" in done.stderr


def test_where_no_law_settles_the_exit_status_is_that_of_a_requirement_that_is_not_met(tmp_path):
    law = tmp_path / "still.py"
    law.write_text("def step(i, p, t, h):\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    arguments = ("--alone", "--scenario", SCENARIO, "--runs", 1, "--duration", "4 s", "--below", 1e-3)
    result = orchestrate("rank", law, *arguments)
    assert (result.exit_code, "no law settles for good below 0.001 deg" in result.stderr) == (1, True)


def test_behind_a_law_of_a_set_of_wheels_stands_the_allocator_as_in_the_planned_pyramid():
    pyramid, planned = (read(Path(f"scenarios/flight_pyramid{end}.yaml")) for end in ("", "_planned"))
    made = rank.allocated(pyramid, "controller", None)
    blocks = made.data["blocks"]
    assert set(made.data["connections"]) == set(planned.data["connections"])
    assert {n: b["fmu"] for n, b in blocks.items()} == {n: b["fmu"] for n, b in planned.data["blocks"].items()}


def test_laws_that_give_a_torque_fly_a_set_of_wheels_beside_one_that_commands_them(tmp_path):
    law = tmp_path / "rest.py"
    law.write_text("def step(i, p, t, h):\n    return {'dipole_cmd': [0.0] * 3, 'wheel_torque_cmd': [0.0] * 4}\n")
    table = tmp_path / "ranked.csv"
    arguments = ("--runs", 1, "--duration", "300 s", "--below", 30, "--rate", 0.5, "--out", table)
    result = orchestrate("rank", law, "--scenario", "scenarios/flight_pyramid.yaml", *arguments)
    assert result.exit_code == 0, result.stderr
    rows = {row["law"]: row for row in csv.DictReader(table.open())}
    assert set(rows) == {"rest", rank.OWN, "planned", *rank.COMPARED}
    assert rows["rest"]["settled"] == "0"
    assert all(rows[name]["settled"] == "1" for name in (rank.OWN, "planned"))
    assert float(rows["planned"]["median, s"]) < float(rows[rank.OWN]["median, s"])


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("a/law.py", "b/law.py"), "b/law.py: the name 'law' is that of "),
        (("a/pd.py",), "a/pd.py: the name 'pd' is that of a law to compare with, unless --alone is given"),
    ],
)
def test_no_law_is_flown_in_the_name_of_another(tmp_path, names, told):
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("def step(i, p, t, h):\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    result = orchestrate("rank", *(tmp_path / name for name in names), "--scenario", SCENARIO)
    assert (result.exit_code, told in result.stderr) == (2, True), result.stderr


@pytest.mark.parametrize(
    "option", [("--seed", -1), ("--rate", -1), ("--rate", "nan"), ("--below", 0), ("--below", "nan")]
)
def test_an_option_out_of_range_is_refused(tmp_path, option):
    (tmp_path / "law.py").write_text("")
    result = orchestrate("rank", tmp_path / "law.py", "--scenario", SCENARIO, *option)
    assert (result.exit_code, f"Invalid value for '{option[0]}'" in result.stderr) == (2, True), result.stderr


def test_a_law_settles_below_what_the_scenario_expects_unless_another_error_is_given(tmp_path):
    law = tmp_path / "still.py"
    law.write_text("def step(i, p, t, h):\n    return {'tau_cmd_B': [0.0, 0.0, 0.0]}\n")
    scenario = tmp_path / "expects.yaml"
    limit = "{name: goal, signal: judge.attitude_error, always: {below: 2 deg}}"
    scenario.write_text(f"name: expects\nextends: {Path(SCENARIO).absolute()}\nexpect: [{limit}]\n")
    arguments = ("--alone", "--scenario", scenario, "--runs", 1, "--duration", "4 s")
    assert "settled: attitude error below 2 deg for good" in orchestrate("rank", law, *arguments).stdout
    assert "settled: attitude error below 20 deg" in orchestrate("rank", law, *arguments, "--below", 20).stdout
