"""Wrong wirings of ports: that they are what they are called, what shows them, and the mapping that mends one."""

from __future__ import annotations

import csv
import json
import re
import sys
import time
from pathlib import Path
from random import Random

import numpy as np
import pytest

from orchestration.acceptance.polarity.apart import apart
from orchestration.acceptance.polarity.card import card
from orchestration.acceptance.polarity.fly import Loop
from orchestration.acceptance.polarity.mend import as_yaml
from orchestration.acceptance.polarity.ports import Port, miswired
from orchestration.acceptance.polarity.swaps import look
from orchestration.acceptance.polarity.trials import ports_of, run
from orchestration.acceptance.polarity.wrongs import left_handed, wrongs
from orchestration.errors import BlockError
from orchestration.quantities import parse_unit
from orchestration.scenario.text import parse
from orchestration.session.open import open_scenario
from orchestration.session.read import load, read
from orchestration.swap.option import swapped as with_swap
from orchestration.swap.option import swaps_of
from orchestration.system.wiring import Wiring
from tests.commands import orchestrate
from tests.vendors import kinds, wrapper

from .. import fmus
from ..swapped import swapped
from ..wrong_inputs import SCENARIO
from . import teams

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def port(kind, n, unit="1"):
    return Port("a", "x", "input", tuple(range(n)), kind, parse_unit(unit), n)


@pytest.fixture(scope="module")
def paper():
    return Loop(read(SCENARIOS / "paper_no_singularity.yaml"))


@pytest.fixture(scope="module")
def estimated():
    loop = Loop(read(SCENARIOS / "flight_estimated.yaml").with_value("duration", "60 s", "--duration"))
    assert loop.fly() == (None, 60.0)  # what shows something, and how long it flew
    return loop


# ---------------------------------------------------------------- what is tried


def test_a_vector_has_47_wrong_signed_permutations_and_its_usual_factors():
    tried = wrongs(port("vector", 3, "T"))
    axes = [w.matrix for w in tried if w.kind == "axes"]
    assert len({m.tobytes() for m in axes}) == 47
    assert all(np.array_equal(m @ m.T, np.eye(3)) and not np.array_equal(m, np.eye(3)) for m in axes)
    assert sorted(float(w.matrix[0, 0]) for w in tried if w.kind == "unit") == pytest.approx(
        [1e-9, 1e-6, 1e-4, 1e4, 1e6, 1e9]
    )


def test_a_wiring_is_left_handed_where_it_mirrors_and_not_where_it_turns_or_negates():
    """A matrix of determinant below zero mirrors; -1 times the vector is its opposite sign and no mirror."""
    tried = [w for w in wrongs(port("vector", 3, "T")) if w.kind == "axes"]
    signed = [np.sign(np.linalg.det(w.matrix)) for w in tried]
    mirrors = [w for w in tried if left_handed(w)]
    assert len(mirrors) == signed.count(-1.0) - 1 == 23
    assert all(np.linalg.det(w.matrix) < 0.0 for w in mirrors)
    assert not any((w.matrix == -np.eye(3)).all() for w in mirrors)


def test_an_attitude_has_each_wrong_wiring_once_and_those_of_its_quaternion_are_rotations():
    tried = wrongs(port("rotation", 9))
    linear = [w for w in tried if w.matrix is not None]
    assert len({w.matrix.tobytes() for w in linear}) == len(linear) == 1 + 47 + 46
    R = parse("[[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]").data
    flat = np.array(R, float).reshape(1, 9)
    by_name = {w.name: w.apply(flat).reshape(3, 3) for w in tried}
    assert np.array_equal(by_name["transposed"], flat.reshape(3, 3).T)
    assert np.array_equal(by_name["rows +y +x +z"], flat.reshape(3, 3)[[1, 0, 2]])
    assert np.array_equal(by_name["columns -x +y +z"], flat.reshape(3, 3) * [-1, 1, 1])
    assert len(tried) == len(linear) + 4
    for name in by_name:
        if name.startswith("quaternion"):
            assert np.allclose(by_name[name] @ by_name[name].T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "n", "unit", "count"),
    [("scalar", 1, "N.m", 3), ("flag", 1, "1", 1), ("quaternion", 4, "1", 11), ("other", 1, "1", 0)],
)
def test_other_ports_have_their_own_wrong_wirings(kind, n, unit, count):
    tried = wrongs(port(kind, n, unit))
    assert len(tried) == len({w.matrix.tobytes() for w in tried}) == count


def test_a_port_wired_wrongly_and_back_is_wired_as_it_was(paper):
    """Of every kind of port: a wrong wiring and its inverse, one after the other, give back the links."""

    def elements(wiring):
        return {
            (s, t): (link.factor, link.offset)
            for link in wiring.links
            for s, t in zip(link.source, link.target, strict=True)
        }

    for each in ports_of(paper):
        for wrong in wrongs(each)[1::9]:
            if wrong.matrix is None or wrong.kind == "unit":
                continue
            there = miswired(paper.plan.wiring, each, wrong.matrix)
            back = miswired(Wiring(there.links), each, np.linalg.inv(wrong.matrix))
            assert elements(back) == elements(paper.plan.wiring)
            assert elements(there) != elements(back)


# ---------------------------------------------------------------- a small loop


def test_a_flipped_sign_in_a_small_loop_is_shown_by_its_expectation_and_all_is_written(loop, monkeypatch):
    """dx/dt = -x becomes dx/dt = x: 2 rad/s times 1.1^n is above 30 rpm, 3.14 rad/s, at n = 5.

    A tachometer with the opposite sign is not seen by an expectation that has an upper bound only.
    """
    monkeypatch.setenv("COLUMNS", "100")
    result = orchestrate("polarity", loop, "--workers", 1, "--out", "out")
    assert result.exit_code == 0, result.output
    data = json.loads(Path("out/polarity.json").read_text())
    flipped = {f"{w['direction']} {w['port']}": w for w in data["wirings"] if w["wrong"] == "opposite sign"}
    unseen = flipped.pop("output motor.speed")
    assert unseen["found"] is None
    assert "regulator.voltage changes most" in unseen["not_observable"]["reason"]
    assert set(flipped) == {"input motor.voltage", "input regulator.speed", "output regulator.voltage"}
    for entry in flipped.values():
        found = entry["found"]
        assert (found["how"], found["by"], found["time"]) == ("expectation", "the motor stops", pytest.approx(0.5))
    with open("out/polarity.csv", newline="") as file:
        assert len(list(csv.reader(file))) == 1 + len(data["wirings"])
    assert "not observable" in Path("out/polarity.csv").read_text()
    assert all(len(line) <= 100 for line in result.stdout.splitlines()[:12])
    assert "| stimulus | after | output | expected change |" in Path("out/card.md").read_text()


def test_a_port_that_is_not_connected_is_told_with_the_nearest_one(loop):
    loop.write_text(SCENARIO + "isolation: none\n")
    result = orchestrate("polarity", loop, "--out", "out", "--port", "regulator.sped")
    told = "--port regulator.sped: no port of this name is connected; did you mean 'regulator.speed'?\n"
    assert (result.exit_code, result.stderr) == (2, told)


def test_a_loop_that_does_not_meet_its_expectations_as_wired_is_told_apart(loop):
    loop.write_text(SCENARIO.replace("below: 30 rpm", "below: 1 rpm") + "isolation: none\n")
    result = orchestrate("polarity", loop, "--out", "out")
    assert result.exit_code == 1
    assert (
        "the loop as it is wired does not pass at 0 s (the motor stops), so wrong wirings cannot be distinguished"
        in result.stderr
    )


def test_a_check_is_left_out_only_where_it_reads_the_very_port_that_a_swapped_block_lacks(tmp_path, monkeypatch):
    """The name of the output that is missing, `raw`, is how that of another one begins."""
    names = ('name="samples[1]"', 'name="raw"'), ('name="samples[2]"', 'name="raw_measured"')
    mapped = "    interface: regulator.fmu\n    map: mapping.yaml\n    start: {gain: -1, enabled: true}"
    checks = "".join(
        f"  {n}: {{left: regulator.{n}, right: regulator.{n}, within: 1}}\n" for n in ("raw", "raw_measured")
    )
    path = swapped(
        tmp_path,
        monkeypatch,
        ('name="samples[1]"', 'name="other"'),
        names[1],
        scenario=SCENARIO.replace(
            "fmu: regulator.fmu\n    start: {gain: -1, enabled: true}", f"fmu: vendor.fmu\n{mapped}"
        )
        + f"consistency:\n{checks}",
    )
    xml = fmus.description("regulator")
    for old, new in names:
        xml = xml.replace(old, new)
    fmus.write(tmp_path / "regulator.fmu", xml, fmus.library())
    loop = Loop(read(path))
    assert [relation.name for relation in loop.relations] == ["raw_measured"]
    assert "the consistency check 'raw' is left out: regulator lacks what it reads" in loop.notes


# ---------------------------------------------------------------- the paper's loop


def test_what_the_allocator_does_not_use_is_the_only_wrong_rate_that_nothing_shows():
    """Of the body rate the allocator uses the components across the wheel's axis, x; so a flip of x changes nothing."""
    result = run(read(SCENARIOS / "paper_no_singularity.yaml"), chosen=["allocator.omega_B"], workers=1)
    left = [row for row in result.rows if row.found is None]
    assert [row.wrong for row in left] == ["-x +y +z"]
    assert "no output of allocator changes" in left[0].unobservable.reason
    assert len(result.rows) == 47 + 4
    assert max(row.found.time for row in result.rows if row.found) < 1.0


CHECKED = sorted(path.stem for path in SCENARIOS.glob("*.yaml") if read(path).data.get("consistency"))
LONG = ["flight_cubesat", "flight_hold"]


@pytest.mark.fly
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.thorough) if name in LONG else name for name in CHECKED]
)
def test_no_run_as_wired_breaks_a_check_with_errors_and_noise_neither(name):
    loop = Loop(read(SCENARIOS / f"{name}.yaml"))
    assert loop.fly()[0] is None
    assert len(loop.relations) >= 13
    assert min(loop.margins.values()) > 1.2


def test_an_attitude_read_by_its_quaternion_with_the_scalar_in_the_wrong_place_is_shown(paper):
    attitude = next(p for p in ports_of(paper, ["controller"]) if p.variable == "R_NB")
    for wrong in wrongs(attitude):
        if wrong.turn is not None:
            found, _ = paper.fly(attitude, wrong)
            assert found is not None
            assert found.time < 1.0


@pytest.mark.parametrize("variable", ["b_B_measured", "r_N_measured", "omega_B", "R_NB"])
def test_the_checks_of_a_loop_with_an_estimator_show_its_wrong_axes_within_a_minute(estimated, variable):
    """As wired no check fails in this time."""
    each = next(p for p in ports_of(estimated, ["estimator"]) if p.variable == variable)
    for wrong in [w for w in wrongs(each) if w.kind == "axes"][::12]:
        found, _ = estimated.fly(each, wrong)
        assert found is not None, wrong.name


def test_the_test_card_has_the_signs_of_the_physics(paper):
    """A torque about the wheel's axis is the wheel's with the opposite sign; a wheel that is sped up turns the body
    back.
    """
    made = card(paper)
    by = {(s.stimulus.split(" ")[0], s.output): s.expected for s in made.steps}
    assert by["tau_cmd_B[1]", "wheel_torque_cmd"].startswith("-")
    assert by["wheel_torque_cmd", "h_w"].startswith("+")
    assert by["wheel_torque_cmd", "omega_B"].startswith("(-")
    assert by["omega_B[2]", "tau_cmd_B"].split(", ")[1].startswith("-")
    assert set(made.base) == {"plant", "controller", "allocator", "judge"}
    assert {s.hold for s in made.steps} == {1.0}


@pytest.mark.compile
@pytest.mark.parametrize(("name", "inverse"), [("quaternion", False), ("inverse", True)])
def test_a_team_s_quaternion_with_its_scalar_last_is_proposed_and_mended_without_help(name, inverse, tmp_path):
    fmu = teams.build(name, tmp_path)
    ours = read(SCENARIOS / "paper_no_singularity.yaml")
    looked = look(ours, with_swap(ours, swaps_of([f"controller={fmu}"])), ["controller"])
    assert "R_NB: {theirs: att, quaternion: scalar first}  # unsure" in looked.proposed["controller"]
    assert looked.wrong is not None
    assert looked.left is None
    (mended,) = looked.mended
    assert mended.behaves == teams.TEAMS[name].behaves
    assert mended.after < 1e-9
    assert parse(as_yaml(mended.mapping)).data == {
        "ports": {"R_NB": {"theirs": "att", "quaternion": "scalar last", "inverse": inverse}}
    }


@pytest.mark.compile
@pytest.mark.skipif(sys.platform == "win32", reason="the FMU is compiled for POSIX")
@pytest.mark.parametrize(
    ("team", "told"),
    [
        ("waits", r"allocator: fmi2DoStep at \d[.\d]* s: did not return within 2 s \(the block's 'timeout'\), so its"),
        ("leaves", "allocator: .*: ended the process of its trials"),
    ],
)
def test_an_fmu_that_does_not_return_or_ends_the_process_is_named_within_its_time(team, told, tmp_path):
    """It is flown in the process of the search, where no other one watches it."""
    data = {"name": "x", "extends": str(SCENARIOS / "paper_no_singularity.yaml"), "duration": 20}
    data |= {"expect": None, "figures": None, "blocks": {"allocator": {"isolation": "process", "timeout": 2}}}
    (tmp_path / "x.yaml").write_text(json.dumps(data))
    fmu, begun = teams.build(team, tmp_path), time.monotonic()
    done = orchestrate("polarity", tmp_path / "x.yaml", "--swap", f"allocator={fmu}", "--out", tmp_path / "out")
    assert (done.exit_code, bool(re.search(told, done.stderr))) == (3, True), done.stderr
    assert time.monotonic() - begun < 40.0


@pytest.mark.isolate
@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_the_process_of_a_search_takes_no_more_memory_than_its_block_may(tmp_path):
    data = {"name": "x", "extends": str(SCENARIOS / "paper_no_singularity.yaml")}
    limited = {"blocks": {"allocator": {"isolation": "process", "memory": "200 MB"}}}
    (tmp_path / "x.yaml").write_text(json.dumps(data | limited))
    assert len(apart(read(tmp_path / "x.yaml"), bytes, 20_000_000)) == 20_000_000
    with pytest.raises(BlockError, match="used up the 200 MB that the block's 'memory' allows"):
        apart(read(tmp_path / "x.yaml"), bytes, 300_000_000)


@pytest.mark.compile
@pytest.mark.thorough
def test_no_cause_is_named_where_it_leaves_more_than_a_hundredth(tmp_path):
    fmu = teams.build("other law", tmp_path)
    told = orchestrate(
        "polarity", SCENARIOS / "paper_no_singularity.yaml", "--swap", f"controller={fmu}", "--out", tmp_path / "out"
    )
    assert told.exit_code == 1
    words = " ".join(told.stdout.split())
    assert "behaves as wired wrongly" not in words
    differs = r"controller: on the same inputs its outputs differ by \d+(\.\d+)? % of ours"
    first = r"\w+ first by more than 1 % of its largest, at 0 s"
    counted = r"( \(an output counts with 200 % at most\))?"
    assert re.search(f"{differs}{counted}, {first}; no sign, axis, unit", words)
    assert "so none is named" in words


@pytest.mark.compile
def test_a_magnetometer_with_a_bias_is_not_taken_for_other_units(tmp_path):
    """Handed a field that is 10,000 times as large, the bias would not show: but theirs is not handed that."""
    ours = read(SCENARIOS / "paper_no_singularity.yaml")
    case = kinds.base("allocator", Random(1), units=True)
    case.vendor.port("b_B").c = np.array([3e-6, -2e-6, 1e-6])
    opened = open_scenario(load(ours))
    starts = [(start.element, start.value) for start in opened.plan.starts["allocator"]]
    fmu = wrapper.pack(tmp_path / "biased.fmu", case.vendor, opened.fmus["allocator"], starts)
    (mended,) = look(ours, with_swap(ours, swaps_of([f"allocator={fmu}"])), ["allocator"]).mended
    assert mended.before > 0.1
    assert not mended.behaves
    assert [str(cause) for cause in mended.causes] == ["b_B: read with a bias of (-3e-06, 2e-06, -1e-06) T"]
