"""Theirs back to back with ours: what is found, and the verdict."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from orchestration.acceptance.compare import compare
from orchestration.acceptance.tolerances import tolerances
from orchestration.session.read import read
from orchestration.swap import option as swap
from tests.commands import orchestrate

from .. import fmus, vendor
from ..swapped import STEP, swapped
from ..wrong_inputs import SCENARIO

pytestmark = pytest.mark.compile

ARGUMENTS = ("compare", "loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
FIGURE = """
figures:
  - {name: speed, panels: [{signals: [motor.speed], lines: [1]}, {signals: [regulator.voltage, regulator.samples]}]}
"""


def of_gain(share: float) -> None:
    """Theirs takes our gain for so much of it."""
    Path("mapping.yaml").write_text(vendor.MAPPING.replace(repr(vendor.GAIN), repr(share * vendor.GAIN)))


def compared():
    return json.loads(Path("out/comparison.json").read_text())


def outputs():
    return {d["output"]: d for d in compared()["open_loop"]}


def test_a_block_that_gives_the_same_is_equivalent(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch, scenario=SCENARIO + FIGURE, isolated=True)
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 0, result.output
    assert "equivalent: 2 of 2 outputs within tolerance; 1 of 1 expectations met" in result.stdout
    assert outputs()["voltage"]["largest"] < 1e-14
    assert {p.name for p in Path("out").iterdir()} == {"comparison.html", "comparison.json", "ours", "theirs"}
    assert Path("out/theirs/signals.csv").exists()


def test_the_largest_difference_is_found_with_its_time_and_share(tmp_path, monkeypatch):
    """Theirs has a gain 10 % too high, so it differs by a tenth where ours is largest: at once."""
    swapped(tmp_path, monkeypatch)
    of_gain(1.1)
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 1
    d = outputs()["voltage"]
    assert (d["largest"], d["share"], d["time"]) == (pytest.approx(0.2, rel=1e-12), pytest.approx(0.1, rel=1e-12), 0.0)
    assert (d["unit"], d["passed"]) == ("V", False)
    assert "0.2 V" in next(line for line in result.stdout.splitlines() if line.startswith("differs  voltage"))
    assert "not equivalent: 1 of 2 outputs within tolerance; 1 of 1 expectations met" in result.stdout


@pytest.mark.parametrize(
    ("tolerance", "within"),
    [("voltage=0.21 V", True), ("voltage=190 mV", False), ("voltage=11 %", True), ("9 %", False), ("0.11", True)],
)
def test_a_tolerance_is_absolute_or_a_share(tmp_path, monkeypatch, tolerance, within):
    path = swapped(tmp_path, monkeypatch)
    of_gain(1.1)
    source = read(path)
    theirs = swap.swapped(source, swap.swaps_of(["regulator=vendor.fmu"], ["mapping.yaml"]))
    assert compare(source, theirs, "regulator", [tolerance]).equivalent is within


def test_open_loop_feeds_theirs_what_ours_was_given_so_its_own_error_does_not_build_up(tmp_path, monkeypatch):
    """In the loop both decay, ours as 0.9^n and theirs as 0.89^n from 2 rad/s; in the open loop theirs sees ours."""
    swapped(tmp_path, monkeypatch)
    of_gain(1.1)
    orchestrate(*ARGUMENTS)
    d = outputs()["voltage"]
    n = 21
    rms = (sum((0.1 * 2 * 0.9**k) ** 2 for k in range(n)) / n) ** 0.5
    assert d["rms"] == pytest.approx(rms, rel=1e-12)
    (claim,) = compared()["claims"]
    assert claim["theirs"]["margin"] == pytest.approx(claim["ours"]["margin"])


def test_a_claim_that_theirs_fails_fails_the_comparison(tmp_path, monkeypatch):
    text = SCENARIO.replace("always: {below: 30 rpm}", "after: 1.9 s\n    always: {below: 2.5 rpm}")
    swapped(tmp_path, monkeypatch, scenario=text)
    of_gain(0.9)
    result = orchestrate(*ARGUMENTS, "--tolerance", "20 %")
    assert result.exit_code == 1
    assert (
        "equivalent within wide tolerances: 2 of 2 outputs within tolerance; 0 of 1 expectations met" in result.stdout
    )
    assert "failed  the motor stops" in result.stdout


@pytest.mark.parametrize(
    ("largest", "rms", "passed"), [("20 %", "6 %", True), ("20 %", "4 %", False), ("8 %", "6 %", False)]
)
def test_a_tolerance_of_largest_and_rms_fails_by_either(tmp_path, monkeypatch, largest, rms, passed):
    """A gain 10 % too high in open loop: the largest difference is 10 % of the largest value, and the rms half of
    it."""
    swapped(tmp_path, monkeypatch)
    of_gain(1.1)
    Path("tolerances.yaml").write_text(f"voltage: {{largest: {largest}, rms: {rms}}}\n")
    result = orchestrate(*ARGUMENTS, "--tolerance", "tolerances.yaml")
    assert result.exit_code == (0 if passed else 1), result.output
    d = outputs()["voltage"]
    ours = np.genfromtxt("out/ours/signals.csv", delimiter=",", names=True)["regulatorvoltage"]
    assert d["rms"] == pytest.approx(0.1 * np.sqrt(np.mean(ours**2)), rel=1e-9)
    assert d["rms"] / np.abs(ours).max() == pytest.approx(0.05, rel=0.01)
    assert d["passed"] is passed


def test_what_theirs_lacks_is_listed_and_not_judged(tmp_path, monkeypatch):
    extra = "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: 1 V}}\n"
    swapped(tmp_path, monkeypatch, ('name="samples[1]"', 'name="first"'), scenario=SCENARIO + extra + FIGURE)
    Path("mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 0, result.output
    assert re.search(r"samples +theirs lacks it", result.stdout)
    assert "1 of 1 expectations met, 1 not evaluated" in result.stdout


def test_a_block_of_another_step_is_compared_where_it_is_stepped(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch, (STEP, f'<DefaultExperiment stepSize="0.4"/>{STEP}'))
    result = orchestrate(*ARGUMENTS)
    assert "every 0.4 s, given to theirs" in result.stdout
    assert outputs()["voltage"]["largest"] < 1e-14


def test_a_failing_block_is_told_and_what_there_is_is_reported(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch)
    Path("mapping.yaml").write_text(vendor.MAPPING + "  fault: fault\n  fault_time: fault_time\n")
    result = orchestrate(*ARGUMENTS, "--set", "regulator.fault_time=1")
    assert result.exit_code == 0
    Path("mapping.yaml").write_text(vendor.MAPPING.replace("speed: rate", "speed: rate\n  fault: steps_"))
    fmus.write(
        Path("vendor.fmu"),
        vendor.description(('name="fault"', 'name="defect"'), ('name="fault_time"', 'name="since"')),
        fmus.library(),
    )
    Path("mapping.yaml").write_text(vendor.MAPPING + "start: {defect: 1, since: 1 s}\n")
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 3
    assert "theirs: regulator: fmi2DoStep at 1 s: gave status error" in result.stderr
    assert "an FMU failed" in Path("out/comparison.html").read_text()


def test_one_that_fails_in_initialization_is_told_by_its_log_with_the_page_of_both(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch, scenario=SCENARIO + FIGURE)
    fmus.write(Path("vendor.fmu"), vendor.description(), fmus.library("probe", "-DNO_START"))
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 3, result.output
    assert "theirs: regulator: fmi2EnterInitializationMode in initialization: gave status error" in result.stderr
    assert "cannot begin, by" in result.stderr
    assert "an FMU failed" in Path("out/comparison.html").read_text()
    result = orchestrate("polarity", *ARGUMENTS[1:-1], "other")
    assert result.exit_code == 3, result.output
    assert "cannot begin, by" in result.stderr


def test_where_ours_fails_its_run_is_kept_and_the_message_says_whose_it_is(tmp_path, monkeypatch):
    swapped(
        tmp_path,
        monkeypatch,
        scenario=SCENARIO.replace("inertia: 0.5", "inertia: 0.5\n      fault: 1\n      fault_time: 1"),
    )
    result = orchestrate(*ARGUMENTS)
    assert result.exit_code == 3
    assert "ours: motor: fmi2DoStep at 1 s: gave status error" in result.stderr
    assert len(Path("out/ours/signals.csv").read_text().splitlines()) > 10
    assert not Path("out/theirs").exists()


class _Page(HTMLParser):
    """Collects text, and what the page would load from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.words, self.outside, self.plots = "", [], 0

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            self.plots += name == "data-plot"
            if name in ("src", "href") and not str(value).startswith("data:"):
                self.outside.append(value)

    def handle_data(self, data):
        self.words += data


def test_the_page_holds_all_that_it_shows(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch, scenario=SCENARIO + FIGURE)
    orchestrate(*ARGUMENTS)
    page = _Page()
    page.feed(Path("out/comparison.html").read_text("utf-8"))
    assert page.outside == []
    assert page.plots == 6, "two outputs and their differences in the open loop, and the two panels of the figure"
    for text in ("regulator against vendor.fmu", "Open loop", "Closed loop", "the motor stops", "voltage"):
        assert text in page.words


@pytest.mark.parametrize(
    ("tolerance", "message"),
    [
        ("volts=1", "--tolerance volts=1: there is no output 'volts'; did you mean 'voltage'?"),
        ("voltage=1 rpm", "the unit 'rpm' does not fit that of voltage, V"),
        ("voltage=high", "expected a number with a unit"),
        ("1 V", "expected a share such as 1e-6 or '0.1 %'"),
        ("-1 %", "expected a share such as 1e-6 or '0.1 %', found '-1 %'"),
        ("bounds.yaml", "bounds.yaml:1: voltage: expected largest and rms, found most"),
    ],
)
def test_a_wrong_tolerance_is_refused(tmp_path, monkeypatch, tolerance, message):
    swapped(tmp_path, monkeypatch)
    Path("bounds.yaml").write_text("voltage: {most: 1 V}\n")
    result = orchestrate(*ARGUMENTS, "--tolerance", tolerance)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


def test_what_does_not_fit_is_found_before_anything_runs(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch)
    result = orchestrate("compare", "loop.yaml", "--swap", "regulator=vendor.fmu", "--out", "out")
    assert (result.exit_code, Path("out").exists()) == (2, False)
    assert "input speed, a real scalar in rad/s, is missing" in result.stderr


def test_tolerances_of_a_file_hold_for_largest_and_mean(tmp_path):
    from orchestration.fmu.interfaces import reference

    model = reference("allocator", tmp_path).model
    (tmp_path / "t.yaml").write_text("default: 1 %\ndipole_cmd: {rms: 100 mA.m2}\nholding: 5 %\n")
    found = tolerances([str(tmp_path / "t.yaml")], model)
    assert found["dipole_cmd"].largest.limit(2.0) == pytest.approx(0.02), "what a file says nothing of is the default"
    assert found["dipole_cmd"].rms.limit(99.0) == pytest.approx(0.1)
    assert found["b_wheel"].largest.limit(2.0) == pytest.approx(0.02)
    assert found["holding"].largest.limit(1.0) == pytest.approx(0.05)
