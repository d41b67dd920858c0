"""The card of another team's FMU says in its units and axes what our block gives; a bench plays it at a device."""

from __future__ import annotations

import csv
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from fmus.interface import load as load_interface
from fmus.kit import linked
from orchestration import rotation
from orchestration.acceptance.polarity import card_page, vendor_card
from orchestration.acceptance.polarity.card import Trial
from orchestration.acceptance.polarity.mend import _mended
from orchestration.acceptance.polarity.ports import Port
from orchestration.acceptance.polarity.wrongs import Wrong
from orchestration.cli.main import main
from orchestration.fmu.interfaces import reference
from orchestration.fmu.model import Element, Model, Variable
from orchestration.quantities import parse_unit
from orchestration.scenario.mapping import Mapping, PortMap
from orchestration.swap.findings import Fit
from orchestration.swap.fit import fit
from orchestration.swap.named_values import handed_on

from ...fmus.link import devices

Z90 = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def theirs() -> Fit:
    """A controller with a quaternion, deg/s and mN m, whose body axes are ours turned by 90 deg about z."""
    unit = {name: parse_unit(name) for name in ("deg/s", "mN.m")}
    ports = [
        Variable("q", "input", shape=(4,), references=(1, 2, 3, 4)),
        Variable("gyro", "input", shape=(3,), references=(5, 6, 7), unit=unit["deg/s"]),
        Variable("torque", "output", shape=(3,), references=(8, 9, 10), unit=unit["mN.m"]),
    ]
    mapping = Mapping.model_validate(
        {
            "ports": {
                "R_NB": {"theirs": "q", "quaternion": "scalar last"},
                "omega_B": {"theirs": "gyro", "matrix": Z90.tolist()},
                "tau_cmd_B": {"theirs": "torque", "matrix": Z90.tolist()},
            }
        }
    )
    model = Model("vendor", {port.name: port for port in ports})
    return fit(reference("controller", Path.cwd()), model, mapping)


def trial(port: str, axis: int, before: dict, after: dict, turned: float | None = None) -> Trial:
    inputs = ({"R_NB": np.eye(3).ravel(), "omega_B": np.zeros(3)} | part for part in (before, after))
    outputs = {"tau_cmd_B": np.zeros(3)}, {"tau_cmd_B": np.array([2e-3, 0.0, 0.0])}
    return Trial("controller", port, axis, turned, 1.0, 10, tuple(inputs), outputs)


def test_stimulus_and_answer_are_in_their_units_along_their_axes():
    rate = {"omega_B": np.array([math.radians(3.0), 0.0, 0.0])}
    (line,) = vendor_card.lines([trial("omega_B", 0, {}, rate)], theirs())
    (given,) = line.inputs
    assert (given.name, given.unit) == ("gyro[2]", "deg/s")  # x of ours is y of theirs
    assert given.after == pytest.approx(3.0)
    answers = {r.name: r for r in line.outputs}
    assert answers["torque[2]"].after == pytest.approx(2.0)
    assert answers["torque[2]"].tolerance == pytest.approx(0.1)
    assert [answers[f"torque[{i}]"].sign for i in (1, 2, 3)] == ["0", "+", "0"]
    assert answers["torque[1]"].tolerance == pytest.approx(0.02)  # what stays has a hundredth of the largest


def test_a_turn_is_a_quaternion_of_theirs_about_an_axis_of_theirs():
    angle = math.radians(10.0)
    R = np.array(rotation.about([1.0, 0.0, 0.0], angle))
    (line,) = vendor_card.lines([trial("R_NB", 0, {}, {"R_NB": R}, angle)], theirs())
    assert line.text == "body turned by +10 deg about its +y axis"
    by_name = {r.name: r.after for r in line.inputs}
    assert by_name["q[1]"] == pytest.approx(math.sin(angle / 2))
    assert by_name["q[4]"] == pytest.approx(math.cos(angle / 2))
    before, after = line.attitudes
    assert before == pytest.approx(Z90.T)
    assert after[:, 1] == pytest.approx([1.0, 0.0, 0.0])  # the axis that it is turned about stays


def test_axis_and_angle_are_those_of_the_rotation():
    R = np.array(rotation.about([0.6, 0.0, 0.8], math.radians(123.4))).reshape(3, 3)
    assert vendor_card.axis_and_angle(R) == "123.4 deg about (+0.600, +0.000, +0.800)"
    assert vendor_card.axis_and_angle(np.eye(3)) == "no turn"


def test_axes_that_would_mirror_the_body_are_not_taken_for_its_axes():
    ports = {"omega_B": {"theirs": "gyro", "matrix": np.diag([1.0, 1.0, -1.0]).tolist()}}
    model = Model("vendor", {"gyro": Variable("gyro", "input", shape=(3,), unit=parse_unit("rad/s"))})
    made = fit(reference("controller", Path.cwd()), model, Mapping.model_validate({"ports": ports}))
    assert np.array_equal(vendor_card.body_axes(made), np.eye(3))
    assert vendor_card.body_axes(theirs()) == pytest.approx(Z90)


def test_the_picture_of_axes_looks_from_above_at_equal_angles():
    """Three axes of equal length, z up, x to the left, y to the right and both towards the reader."""
    drawn = str(card_page.triads(np.eye(3), np.eye(3)))
    ends = np.array(re.findall(r'x1="60" y1="60" x2="([0-9.]+)" y2="([0-9.]+)"', drawn), float)[:3] - 60.0
    assert np.linalg.norm(ends, axis=1) == pytest.approx([48.0 * math.sqrt(2.0 / 3.0)] * 3, abs=0.1)
    assert np.degrees(np.arctan2(-ends[:, 1], ends[:, 0])) % 360 == pytest.approx([210.0, 330.0, 90.0], abs=0.2)


def test_the_page_has_blanks_and_pictures_and_escapes_names():
    angle = math.radians(10.0)
    R = np.array(rotation.about([0.0, 1.0, 0.0], angle))
    card = vendor_card.lines([trial("R_NB", 1, {}, {"R_NB": R}, angle)], theirs())
    page = card_page.page(card, {"fmu": "<b>.fmu", "as": "controller"}, [("kp", 2.5, "1/s")])
    assert "&lt;b&gt;.fmu" in page
    assert "<svg" in page
    assert page.count('class="blank"') == 5 + 2 * len(card[0].outputs)


@pytest.mark.isolate
@pytest.mark.compile
def test_a_bench_plays_the_card_at_our_block_on_a_device(tmp_path: Path):
    linked.write(load_interface("controller"), tmp_path / "kit", "python")
    own = str(Path("out/fmus/native/controller.fmu").absolute())
    made = CliRunner().invoke(main, ["card", own, "--as", "controller", "-o", str(tmp_path / "kit")])
    assert made.exit_code == 0, made.output
    card = tmp_path / "kit" / "card.json"
    data = json.loads(card.read_text("utf-8"))
    device = str(devices.program("controller"))

    def play() -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "card.py", "card.json", "run", device]
        return subprocess.run(command, cwd=card.parent, capture_output=True, text=True, check=False)

    done = play()
    assert done.returncode == 0, done.stdout + done.stderr
    with (card.parent / "card_measured.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(step["expected"]) for step in data["steps"])
    first = data["steps"][0]["expected"][0]
    first["after"] = -first["after"]
    card.write_text(json.dumps(data), "utf-8")
    wrong = play()
    assert wrong.returncode == 1
    assert f"WRONG {first['output']}" in wrong.stdout


@pytest.mark.parametrize("to_rows", [True, False])
def test_the_mapping_that_mends_other_axes_hands_over_what_theirs_then_reads_rightly(to_rows):
    """A vector v of which theirs reads R^T v (or R v) is handed over as R v (or R^T v)."""
    at = Port("controller", "omega_B", "input", (0, 1, 2), "vector", parse_unit("rad/s"), 3)
    along = Wrong("along the other side", "frame", along=("R_NB", to_rows))
    mended = _mended(PortMap.model_validate({"theirs": "gyro"}), at, along, 1.0)
    ports = [
        Variable("R", "input", shape=(3, 3), references=tuple(range(1, 10))),
        Variable("gyro", "input", shape=(3,), references=(11, 12, 13), unit=parse_unit("rad/s")),
    ]
    mapping = Mapping.model_validate({"ports": {"R_NB": "R", "omega_B": mended}})
    made = fit(reference("controller", Path.cwd()), Model("vendor", {p.name: p for p in ports}), mapping)
    R, v = np.array(rotation.about([0.6, 0.0, 0.8], 1.1)).reshape(3, 3), np.array([0.1, -0.2, 0.3])
    given = [(Element(n, i), float(x)) for n, a in (("R_NB", R.ravel()), ("omega_B", v)) for i, x in enumerate(a)]
    handed = handed_on(made, given)
    assert [handed[Element("gyro", i)] for i in range(3)] == pytest.approx((R if to_rows else R.T) @ v)
