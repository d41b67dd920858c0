"""A whole review, of flights of a minute instead of orbits."""

import csv
import math
from base64 import b64decode
from types import SimpleNamespace

import numpy as np
import pytest

from design.review import compare, content, flights, manoeuvres, margins, page, power, run, studies, tumbles
from design.review import facts as of
from design.review.options import Options, requirements
from evidence.paper import ROOT
from orchestration.errors import BlockError
from orchestration.scenario.text import written
from orchestration.session.read import load, read
from orchestration.session.run import whole

pytestmark = pytest.mark.fly

SECTIONS = [
    *(
        "At a glance",
        "Satellite",
        "Disturbances",
        "Tumbles",
        "Pointing budget",
        "Agility",
        "Station tracking",
        "Single failures",
    ),
    *("Stability margins", "Power", "Requirements", "What was not looked at"),
]
ASKED = """
requirements:
  - {id: R1, metric: settling_time, below: 0.5 h, probability: 0.1, confidence: 0.5}
  - {id: R2, metric: relative_error, below: 180 deg, probability: 0.1, confidence: 0.5}
  - {id: R3, metric: jitter, below: 1 arcsec}
power: {rod: 0.2 W, wheel: 0.3 W}
"""


def test_a_review_has_all_sections_and_goes_on_where_it_was_stopped(satellite, tmp_path, monkeypatch):
    monkeypatch.setattr(of.Facts, "period", property(lambda self: 60.0))
    (tmp_path / "asked.yaml").write_text(ASKED, "utf-8")
    asked, watts = requirements(tmp_path / "asked.yaml")
    options = Options(runs=3, members=1, workers=0, requirements=asked, power=watts)
    said, told = [], []

    def once():
        return run.review(satellite, tmp_path / "out", options, lambda *at: told.append(at), said.append)

    found = once()
    assert [section.heading for section in found.sections] == SECTIONS
    assert found.verdicts[2] == "not verifiable"
    assert " 0 failed" in found.sections[3].notes[0], "a metric that has no value fails a tumble"
    assert told[-1][1] == told[-1][2]
    assert "flights" in said[0]
    found.save(tmp_path / "out")
    rows = list(csv.DictReader((tmp_path / "out" / "requirements.csv").open()))
    assert [row["id"] for row in rows] == ["R1", "R2", "R3"]
    assert "--replay" in rows[1]["worst case"]
    motion = content.load(tmp_path / "out").sections[3].motion
    flown = whole(load(read(tmp_path / "out" / "flights" / "as-it-stands.yaml")))
    time = np.frombuffer(b64decode(motion["time"]["data"]), "<f4")
    assert time == pytest.approx(flown.time)
    both = compare.compared(found, found, ("one", "other"))
    assert both.sections[3].motion["names"] == ["A: one", "B: other"]
    text = page.page(found)
    assert text.count('class="view"') == page.page(both).count('class="view"') == 1
    assert all(f". {heading}</h2>" in text for heading in SECTIONS)
    monkeypatch.setattr(flights, "whole", lambda scenario: pytest.fail("it was flown again"))
    again = once()
    assert [t.rows for s in again.sections for t in s.tables] == [t.rows for s in found.sections for t in s.tables]


def test_the_time_that_is_announced_is_that_of_the_first_tumbles(facts, monkeypatch):
    """Four tumbles of two orbits in 20 s: with 96 more and all holds and manoeuvres the rest takes 2.5 s an orbit."""
    now, said = [100.0], []
    monkeypatch.setattr(run, "perf_counter", lambda: now[0])
    timed = run.Timed(facts, Options(runs=100, members=20, workers=2), 1, said.append)
    orbits = float(said[0].partition(" flights, ")[2].partition(" orbits")[0])
    assert orbits > 2 * 100 + 1.5 * 20
    for done in (0, 2, 4, 6):
        timed("tumbles", done)
        now[0] += 10.0
    assert len(said) == 2
    assert said[1].startswith(f"about {2.5 * (orbits - 10) / 60:.0f} min more")
    assert ("--members fly fewer" in said[1]) is (2.5 * (orbits - 10) > 900)


def test_a_review_announces_another_end_where_later_flights_take_longer(facts, monkeypatch):
    """Tumbles of 5 s, two at once; holds take four times as long an orbit."""
    said, now = [], [1000.0]
    monkeypatch.setattr(run, "perf_counter", lambda: now[0])
    timed = run.Timed(facts, Options(runs=100, members=20, workers=2), 1, said.append)
    for done in range(0, 101, 2):
        timed("tumbles", done)
        now[0] += 10.0
    assert len(said) == 2
    for done in (2, 4, 6, 8):
        timed("holds", done)
        now[0] += 30.0
    assert len(said) == 3
    holds = len(timed._orbits["holds"])
    orbits = 1.5 * (holds - 6) + sum(timed._orbits["manoeuvres"])
    assert said[2].startswith(f"about {10.0 * orbits / 60:.0f} min more, by the time of the holds so far")


def test_least_times_are_those_of_tumbles_whose_momentum_the_wheels_do_not_hold(four_wheels, tmp_path):
    assert "less than 30 to 41 s for the first 2 of" in tumbles._bounded([41.2, 30.1])
    assert "its balance bounds no time" in tumbles._bounded([0.0, 0.0])
    small = tmp_path / "small.yaml"
    small.write_text(f"name: small\nextends: {four_wheels}\nshared: {{wheel_momentum_max: {4 * ['0.1 mN.m.s']}}}\n")
    assert _least_times(four_wheels, tmp_path / "four") == [0.0, 0.0]  # four of 2 mN m s
    found = _least_times(small, tmp_path / "small")
    J, rate, torque = 0.007, math.radians(4.12), math.sqrt(3.0) * 0.303 * 6e-5  # of the least moment, the most rods
    assert all((J * rate - 4e-4) / torque < time < 600.0 for time in found)


def _least_times(file, folder):
    found = of.facts(file, None)
    times, why = tumbles.least_times(found, tumbles.prepared(found, Options(runs=2, members=1, workers=0), folder))
    assert not why
    return times


def test_a_satellite_without_a_wheel_has_no_power_and_no_momentum_of_one(satellite, facts, four_wheels):
    none = of.facts(satellite.parents[1] / "none" / "tumble.yaml", None)
    assert [one.wheels for one in (none, facts, of.facts(four_wheels, None))] == [[], [0], [0, 1, 2, 3]]
    signals = dict.fromkeys(power.commands(none), np.zeros((2, 3)))
    flown = {"failure-none": flights.Flown(np.array([0.0, 2.0]), signals, "", satellite)}
    section = power.power(none, Options(power={"rod": 0.2, "wheel": 0.3}), flown)
    assert [row[0] for row in section.tables[0].rows] == ["rods"]


def test_what_is_drawn_on_a_logarithmic_axis_leaves_out_what_is_next_to_nothing():
    """A hold starts at an error of rounding, which would stretch the axis over ten decades."""
    shown = page._shown([1e-15, 0.0, 0.5, 2.0], True)
    assert np.isnan(shown[:2]).all()
    assert shown[2:].tolist() == [0.5, 2.0]
    assert page._shown([0.0, 2.0], False).tolist() == [0.0, 2.0]


def test_what_was_not_looked_at_names_no_sensor_that_is_not_there_and_momenta_without_telemetry(
    facts, four_wheels, unmeasured
):
    of_one, of_four, of_true = (
        " ".join(run._left(found).notes) for found in (facts, of.facts(four_wheels, None), of.facts(unmeasured, None))
    )
    assert "star tracker" not in of_one
    assert "true momenta" not in of_one + of_four
    assert "true momenta" in of_true


def test_wheels_have_margins_in_each_channel_and_a_planned_controller_what_is_left_of_disturbances(facts, four_wheels):
    four = of.facts(four_wheels, None)
    table = margins.section(four, read(four_wheels)).tables[0]
    assert [row[0] for row in table.rows] == [*(f"controller.tau_cmd_B[{i}]" for i in (1, 2, 3)), "all at once"]
    # The rate loop 4 k (k + s)/s2 of the bandwidth k, sampled: a double integrator with rate feedback keeps 60 deg.
    assert 55.0 < float(table.rows[-1][3].split()[0]) < 90.0
    assert "do not hold in a slew" in table.note
    (planned,) = margins.section(facts, read(facts.file)).tables
    assert "no margins of a moment" in planned.note
    assert [row[0] for row in planned.rows] == ["200 s", "400 s"]
    # A hold forgets: within 400 s a disturbance is a half at most, and pulses of both signs say so alike.
    assert float(planned.rows[0][1]) * float(planned.rows[1][1]) < 0.5
    assert all(float(row[3].removesuffix("%")) < 5.0 for row in planned.rows)


def test_a_loop_without_margins_has_the_reason_and_what_is_left_of_disturbances(four_wheels, monkeypatch):
    monkeypatch.setattr(margins, "measure", lambda rig: SimpleNamespace(refused="", change=0.2, warnings=[]))
    monkeypatch.setattr(margins, "WHEN", 0.05)
    (table,) = margins.section(of.facts(four_wheels, None), read(four_wheels)).tables
    assert (
        "At controller.tau_cmd_B the loop has no margins: its response changes by 20% meanwhile. Left: " in table.note
    )
    assert all(float(row[1]) < 0.5 for row in table.rows)


def test_a_law_that_demands_a_torque_is_opened_there(facts, four_wheels):
    paper = of.facts(ROOT / "scenarios" / "paper_no_singularity.yaml", None)
    ports = [margins._port(found) for found in (paper, of.facts(four_wheels, None), facts)]
    assert ports == ["controller.tau_cmd_B", "controller.tau_cmd_B", "plant.dipole_cmd"]


def _quiet(found):
    """Rows and notes of failures after which nothing moves and no flag is raised."""
    time = np.linspace(0.0, 3.0 * found.period, 10)
    judge, h_w = manoeuvres.signals(found)
    signals = {judge: np.zeros(10), h_w: np.zeros((10, 4)), "estimator.health": np.ones((10, 5))}
    signals |= {f"controller.{flag}": np.zeros(10) for flag in ("rod_failed", "wheel_failed", "h_w_frozen")}
    signals |= {f"allocator.{flag}": np.zeros((10, 4)) for flag in ("wheel_failed", "h_w_failed")}
    one = flights.Flown(time, signals, "", found.file)
    names = [f"failure-{name.replace(' ', '_')}" for name in ("none", *studies.failures(found))]
    section, _ = manoeuvres.failures(found, dict.fromkeys(names, one))
    return {row[0]: row for row in section.tables[0].rows}, " ".join(section.notes)


def test_failures_say_what_raises_no_flag_and_what_an_estimator_lacks(satellite, facts, four_wheels, unmeasured):
    rows, notes = _quiet(of.facts(satellite.parents[1] / "none" / "tumble.yaml", None))
    assert {row[5] for row in rows.values()} == {"–"}, "there is no wheel"
    assert rows["sun sensors lost"][1] == "no flag: gives nothing"
    assert rows["gyro frozen"][1] == "not found"
    assert "no failure to the estimator" in notes
    assert "momenta of the wheels" not in notes
    assert "gyro frozen: without its gyro, and in an eclipse" in notes
    rows, notes = _quiet(of.facts(four_wheels, None))
    assert "without its gyro, and in an eclipse" not in notes, "there is a star tracker"
    assert rows["star tracker lost"][1] == "no flag: gives nothing"
    assert rows["wheel 1 stuck"][5] == "0"
    assert [rows[f"telemetry of wheel {i} frozen"][1] for i in (1, 4)] == 2 * ["not found"]
    assert "momenta of the wheels" not in notes
    rows, notes = _quiet(of.facts(unmeasured, None))
    assert not any(name.startswith("telemetry") for name in rows)
    assert "it is not told the momenta of the wheels" in notes
    rows, notes = _quiet(facts)
    assert rows["telemetry of the wheel frozen"][1] == "not found"
    assert "momenta of the wheels" not in notes


def test_a_law_in_python_is_reviewed_as_a_block_is_and_one_that_fails_at_once_by_its_file(
    satellite, tmp_path, monkeypatch
):
    monkeypatch.setattr(of.Facts, "period", property(lambda self: 60.0))
    (tmp_path / "law.py").write_text(
        "def step(inputs, parameters, t, h):\n    return {'tau_cmd_B': -0.02 * parameters.J_B @ inputs.omega_B}\n"
    )
    own = tmp_path / "own.yaml"
    own.write_text(written({"name": "own", "extends": str(satellite), "blocks": {"controller": {"python": "law.py"}}}))
    found = run.review(own, tmp_path / "out", Options(runs=2, members=1, workers=0), lambda *at: None)
    assert [section.heading for section in found.sections] == SECTIONS
    said = str(found.sections)
    assert "controller law law.py" in said
    assert "controller_planned solves" not in said, "it is a law of which no more is known than of any"
    assert "controller.tau_cmd_B" in said, "the loop is opened at the torque that the law demands"
    (tmp_path / "law.py").write_text("def step(inputs, parameters, t, h):\n    return {'torque': inputs.omega_B}\n")
    with pytest.raises(BlockError, match=r"law\.py.*no output 'torque'"):
        run.review(own, tmp_path / "out2", Options(runs=2, members=1, workers=0), lambda *at: None)
