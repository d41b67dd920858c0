"""An FMU is accepted where all that could be tried is met; each way to break a host is told by its trial."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic

import numpy as np
import pytest
from click.testing import CliRunner, Result

from orchestration.acceptance.accept import patient
from orchestration.acceptance.accept_page import how
from orchestration.acceptance.polarity.apart import bounds
from orchestration.cli.main import main
from orchestration.fmu.model import Element, Variable
from orchestration.session.limits import TIMEOUT
from orchestration.session.read import read
from orchestration.swap.findings import Link

from .. import fmus, vendor
from ..swapped import swapped
from ..wrong_inputs import SCENARIO

pytestmark = [pytest.mark.compile, pytest.mark.isolate]


def accept(*more: str) -> tuple[Result, dict[str, dict[str, str]]]:
    """What the command says of vendor.fmu as the regulator, and its requirements by name."""
    words = ["accept", "vendor.fmu", "--as", "regulator.fmu", "--scenario", "loop.yaml", "-o", "out", *more]
    result = CliRunner().invoke(main, words)
    data = json.loads(Path("out/acceptance.json").read_text("utf-8"))
    return result, {one["name"]: one for one in data["requirements"]}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    swapped(tmp_path, monkeypatch)
    return tmp_path


def test_a_right_fmu_is_accepted_and_the_page_says_what_was_and_was_not_tested(folder: Path):
    result, found = accept("--map", "mapping.yaml")
    assert result.exit_code == 0, result.output
    assert {one["status"] for one in found.values()} == {"met", ""}
    assert found["a saved state is restored whole"]["status"] == ""
    assert found["it gives the reference data that it carries"]["status"] == ""
    data = json.loads(Path("out/acceptance.json").read_text("utf-8"))
    assert data["accepted"]
    page = Path("out/acceptance.html").read_text("utf-8")
    assert data["fmu"]["sha256"] in page
    for heading in ("Requirements", "Not tested", "Mapping", "Interface", "Open loop", "Closed loop"):
        assert f"<h2>{heading}</h2>" in page
    assert "times 9.5493" in page  # rad/s as rpm
    assert "none stated" in page
    assert not any("proposed" in text for text in data["not_tested"])


def test_an_opposite_sign_is_named_and_not_accepted(folder: Path):
    wrong = vendor.MAPPING.replace("voltage: command", "voltage: {theirs: command, scale: -1}")
    Path("wrong.yaml").write_text(wrong, "utf-8")
    result, found = accept("--map", "wrong.yaml")
    assert result.exit_code == 1, result.output
    one = found["no wrong wiring is found"]
    assert one["status"] == "failed"
    assert "by 200 % of ours" in one["text"]


@pytest.mark.parametrize(("own_names", "mapping"), [(True, "proposed"), (False, "")])
def test_a_mapping_is_proposed_where_none_is_given_and_it_does_not_fit_without(folder: Path, own_names, mapping):
    vendor.write(folder, runnable=True, own_names=own_names)
    accept()
    data = json.loads(Path("out/acceptance.json").read_text("utf-8"))
    assert data["mapping"] == mapping
    assert bool(data["proposed"]) is own_names
    assert any("proposed" in text for text in data["not_tested"]) is own_names


def test_an_fmu_that_does_not_fit_is_not_flown(folder: Path):
    vendor.write(folder, ('<Real unit="mV"', '<Real unit="m"'))
    result, found = accept("--map", "mapping.yaml")
    assert result.exit_code == 1, result.output
    assert found["it fits the interface"]["status"] == "failed"
    assert found["the loop flies with it"]["status"] == ""
    assert json.loads(Path("out/acceptance.json").read_text("utf-8"))["proposed"] == ""


def test_what_is_wrong_in_the_scenario_is_not_said_of_the_fmu(folder: Path):
    vendor.write(folder)
    text = Path("loop.yaml").read_text("utf-8")
    late = "expect:\n  - {name: late, signal: motor.speed, after: 999 s, always: {below: 9}}\n"
    assert "expect:\n" in text
    Path("loop.yaml").write_text(text.replace("expect:\n", late))
    words = ["accept", "vendor.fmu", "--as", "regulator.fmu", "--map", "mapping.yaml", "--scenario", "loop.yaml"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert "loop.yaml:" in done.stderr
    assert "999 s" in done.stderr


@pytest.mark.parametrize(
    ("direct", "trial", "text"),
    [
        ("((x)[2]>1e4?*(volatile double*)8:(x)[3]*(x)[2])", "an input that is 1e6 times as large", "ended its process"),
        ("((x)[3]*(x)[2]+1e-12*(rand()&255))", "the same inputs twice give the same bits", "differs by up to"),
    ],
)
def test_what_breaks_a_host_is_told_by_its_trial(folder: Path, direct: str, trial: str, text: str):
    fmus.write(folder / "vendor.fmu", vendor.description(), fmus.library("probe", f"-DDIRECT(x)={direct}"))
    result, found = accept("--map", "mapping.yaml")
    assert result.exit_code == 1, result.output
    (one,) = [one for name, one in found.items() if name.startswith(trial)]
    assert one["status"] == "failed"
    assert text in one["text"]


HANGS = "-DDIRECT(x)=({ while (*(volatile double *)&(x)[2] %s) {} (x)[3]*(x)[2]; })"


@pytest.mark.parametrize(
    ("option", "name", "text"),
    [
        (
            HANGS % "> 1e4",
            "an input that is 1e6 times as large does no harm",
            "did not return from fmi2Get at 0.9 s within 1 s",
        ),
        (HANGS % "< 1e4", "the loop flies with it", "return within 1 s (the block's 'timeout')"),
        pytest.param(
            "-DNO_END",
            "an input that is zero does no harm",
            "did not return from fmi2Terminate or fmi2FreeInstance within 1 s",
            marks=pytest.mark.thorough,
        ),
    ],
    ids=["a large input", "every input", "its end"],
)
def test_a_call_that_hangs_ends_after_the_time_that_a_call_may_take_and_is_named(
    folder: Path, capfd: pytest.CaptureFixture[str], option: str, name: str, text: str
):
    scenario = Path("loop.yaml")
    words = scenario.read_text("utf-8").replace("isolation: none\n", "")
    scenario.write_text(words.replace("fmu: regulator.fmu", "fmu: regulator.fmu\n    timeout: 1 s"), "utf-8")
    fmus.write(folder / "vendor.fmu", vendor.description(), fmus.library("probe", option))
    begun = monotonic()
    result, found = accept("--map", "mapping.yaml")
    assert monotonic() - begun < 55.0
    assert result.exit_code in (1, 3), result.output
    assert found[name]["status"] == "failed"
    assert text in found[name]["text"]
    assert "Traceback" not in capfd.readouterr().err


def test_a_call_of_an_fmu_that_is_accepted_or_refused_may_take_ten_seconds_unless_the_scenario_says_otherwise(
    folder: Path,
):
    for words, seconds in (("", 10.0), ("    timeout: 3 s\n", 3.0), ("    isolation: none\n", TIMEOUT)):
        text = SCENARIO.replace("fmu: regulator.fmu\n", f"fmu: regulator.fmu\n{words}")
        Path("loop.yaml").write_text(text, "utf-8")
        assert bounds(patient(read(Path("loop.yaml")), "regulator"), "regulator")[0] == seconds


def test_links_are_put_in_some_words():
    ours = Variable("b_B", "input", shape=(3,))
    theirs = tuple(Element("m", i) for i in range(3))

    def words(A: list[list[float]], **more) -> str:
        return how(Link(ours, theirs, np.array(A, float), np.zeros(3), **more))

    assert words(np.eye(3).tolist()) == "as it is"
    assert words((1e9 * np.eye(3)).tolist()) == "times 1e+09"
    assert words([[0, -2, 0], [2, 0, 0], [0, 0, 2]]) == "-y +x +z, times 2"
    assert words([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]) == "matrix"
    assert how(Link(ours, theirs, scalar_last=True, inverse=True)) == "quaternion, scalar last, inverse"
