"""The study of flights in SI units: how it judges, what it flies, and what its page says."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

import fmus.interface
from orchestration import run
from studies import native
from studies.__main__ import main
from studies.flight import cases
from studies.flight.run import BLOCKS, Rows, errors, fly, key, settled
from studies.flight.tried import TRIED, all_cases

# ---------------------------------------------------------------- the judge


def test_settled_is_from_when_both_errors_stay_small_to_the_end():
    t, five = np.arange(6.0), math.radians(5.0)
    small, quiet = np.full(6, 0.9 * five), np.full(6, 9e-4)
    assert settled(t, small, quiet, 5.0) == 0.0
    assert settled(t, np.where(t == 2, five, small), quiet, 5.0) == 3.0
    assert settled(t, small, np.where(t == 3, 1e-3, quiet), 5.0) == 4.0
    assert settled(t, np.where(t == 5, five, small), quiet, 5.0) is None
    assert settled(t, small, quiet, 1.0) is None
    assert settled(t, np.where(t == 4, np.nan, small), quiet, 5.0) == 5.0


def test_a_flight_is_judged_by_the_angle_to_lvlh_and_the_rate_less_the_orbits_of_the_true_motion():
    """Witness: SciPy on the plant's recorded motion."""
    data = cases.flight("errors", 7, errors=True).data
    data["record"]["signals"] += ["plant.R_NB", "plant.omega_B", "plant.r_N", "plant.v_N", "controller.attitude_error"]
    result = native.run({**data, "duration": 60.0}, native.pin(BLOCKS))
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
    for seed in cases.seeds("errors", 50):
        start = cases.tumble(seed, errors=True)
        off = np.diag(start["plant.J_error_B"]) / np.diag(cases.J)
        assert ((np.abs(off) >= 0.05) & (np.abs(off) <= 0.1)).all()
        assert np.linalg.norm(start["controller.field_error"]) == pytest.approx(200e-9)
        assert np.linalg.norm(start["plant.disturbance_torque_B"]) == pytest.approx(1e-5)
        assert np.linalg.norm(start["plant.omega_B0"]) <= math.radians(6.0)
        np.testing.assert_allclose(start["plant.Q0"] @ start["plant.Q0"].T, np.eye(3), atol=1e-12)


def test_attitudes_rates_and_nodes_are_spread_as_the_page_says():
    starts = [cases.tumble(seed) for seed in cases.seeds("nominal", 1000)]
    angles = [Rotation.from_matrix(s["plant.Q0"]).magnitude() for s in starts]
    # Uniform on SO(3) the angle has the distribution (x - sin x)/pi; uniform rates and nodes are themselves.
    for values, cumulative in (
        (angles, lambda x: (x - np.sin(x)) / math.pi),
        ([np.linalg.norm(s["plant.omega_B0"]) for s in starts], lambda x: x / math.radians(6.0)),
        ([s["plant.node_longitude"] for s in starts], lambda x: x / (2.0 * math.pi)),
    ):
        gap = np.abs(cumulative(np.sort(values)) - (np.arange(1000) + 0.5) / 1000.0).max()
        assert gap < 1.63 / math.sqrt(1000.0)  # Kolmogorov's bound at 1%


def test_nothing_is_flown_that_was_tuned_on(every_case):
    for case in every_case:
        assert case.seed < 360 or case.seed >= 100_000
    assert len({case.name for case in all_cases(40)}) == len(all_cases(40))


def test_an_eccentric_start_is_a_perigee_of_eccentricity_0_02():
    tried = next(t for t in TRIED if t.name == "eccentric")
    start = tried.case(300_000).data["blocks"]["plant"]["start"]
    r, v, mu = np.array(start["r_N0"]), np.array(start["v_N0"]), 3.986004418e14
    e = np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r)
    assert np.linalg.norm(e) == pytest.approx(0.02, rel=1e-6)
    assert e @ r == pytest.approx(0.02 * np.linalg.norm(r), rel=1e-6)
    assert 1.0 / (2.0 / np.linalg.norm(r) - v @ v / mu) == pytest.approx(6971e3, rel=1e-6)


def test_another_controller_keeps_the_wires_that_it_has():
    data = cases.tuned(cases.base())
    wires = set(data["connections"])
    assert "sensors.R_NB_measured -> controller.R_NB" in wires
    assert "controller.tau_cmd_B -> allocator.tau_cmd_B" in wires
    assert not any("u_applied" in wire or "_ff" in wire or "controller.h_w" in wire for wire in wires)
    assert "field_error" not in data["blocks"]["controller"]["start"]


@pytest.mark.parametrize("tried", TRIED, ids=lambda t: t.name)
def test_each_thing_that_was_tried_flies(tried):
    assert "failed" not in fly(cases.Case("x", 1, tried.case(300_001).data, (20.0,)), native.pin(BLOCKS))


# ---------------------------------------------------------------- rows


def test_a_study_goes_on_after_a_line_that_was_cut_off(tmp_path):
    rows = Rows(tmp_path / "rows.jsonl")
    rows.add("a", "nominal/1", {"settled5": 3.0})
    with rows.file.open("a") as out:
        out.write('{"key": "b", "row": {"sett')
    again = Rows(rows.file)
    assert again.rows == {"a": {"settled5": 3.0}}
    again.add("c", "nominal/2", {"settled5": None})
    assert Rows(rows.file).rows == {"a": {"settled5": 3.0}, "c": {"settled5": None}}


def test_a_key_is_of_the_scenario_and_of_the_fmus_that_fly_it():
    one, other = cases.flight("nominal", 1), cases.flight("nominal", 2)
    fmus = {name: Path(f"{name}-1.fmu") for name in BLOCKS}
    newer = fmus | {"controller_planned": Path("controller_planned-2.fmu")}
    law = cases.flight("nominal tuned", 1, "tuned")
    keys = [key(one, fmus), key(other, fmus), key(one, newer)]
    assert len(set(keys)) == 3
    assert key(law, fmus) == key(law, newer)


def test_what_a_block_does_is_told_by_its_code_and_variables_not_by_their_descriptions(monkeypatch):
    before = {block: native.identity(block) for block in BLOCKS}
    assert len(set(before.values())) == len(BLOCKS)
    load = fmus.interface.load

    def changed(field, value):
        def other(block):
            interface = load(block)
            variables = {name: replace(v, **{field: value}) for name, v in interface.variables.items()}
            return SimpleNamespace(variables=variables)

        return other

    monkeypatch.setattr("studies.native.load_interface", changed("description", "in other words"))
    assert native.identity("allocator") == before["allocator"]
    monkeypatch.setattr("studies.native.load_interface", changed("min", -2.0))
    assert native.identity("allocator") != before["allocator"]


def test_a_case_can_be_flown_again_from_its_file(tmp_path, monkeypatch):
    monkeypatch.setattr("studies.flight.make.FOLDER", tmp_path)
    done = CliRunner().invoke(main, ["flight-case", "controller + allocator", "158"])
    assert done.exit_code == 0, done.output
    [file] = tmp_path.glob("*.yaml")
    result = run(file, {"duration": 10.0})
    assert result.time[-1] == pytest.approx(10.0)


def test_a_case_that_is_not_there_is_told_with_those_that_are():
    done = CliRunner().invoke(main, ["flight-case", "nominall", "100003"])
    assert done.exit_code == 2
    assert "nominall/100003: there is no such case; did you mean 'nominal/100003'?" in done.stderr
