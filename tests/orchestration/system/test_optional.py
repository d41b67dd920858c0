"""Inputs that may stay unconnected, and elements with units of their own: swap, check, compare, export."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from matplotlib.figure import Figure

import orchestration
from fmus import interface as fmus_interface
from fmus.build import ensure
from fmus.interface import load as load_interface
from orchestration import load
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.interfaces import reference
from orchestration.results.figures import draw_panel
from orchestration.scenario.text import parse
from tests.commands import orchestrate

DELAYED = """
name: delayed
step: 0.1
duration: 2
blocks:
  plant: {fmu: plant, start: {omega_B0: [0.04, -0.08, 0.04]}}
  controller: {fmu: controller}
  allocator: {fmu: allocator_bounded}
connections:
  - plant.R_NB -> controller.R_NB
  - plant.omega_B -> controller.omega_B
  - plant.r_N -> controller.r_N
  - plant.v_N -> controller.v_N
  - controller.tau_cmd_B -> allocator.tau_cmd_B
  - plant.b_B -> allocator.b_B
  - plant.omega_B -> allocator.omega_B
  - plant.h_w -> allocator.h_w
  - plant.dipole -> allocator.dipole_ff
  - allocator.dipole_cmd -> plant.dipole_cmd
  - allocator.wheel_torque_cmd -> plant.wheel_torque_cmd
delays: [allocator.dipole_ff]
"""
"""The bounded allocator prefers the dipoles of the step before; its other optional input is not connected."""
PLAIN = DELAYED.replace("  - plant.dipole -> allocator.dipole_ff\n", "").replace("delays: [allocator.dipole_ff]\n", "")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the scenario, and the paper's allocator as another team's FMU: it knows no feed-forward."""
    (tmp_path / "delayed.yaml").write_text(DELAYED)
    shutil.copyfile(ensure("allocator"), tmp_path / "vendor.fmu")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def changed(source: Path, target: Path, *changes: tuple[str, str]) -> Path:
    """A copy of an FMU with text of its modelDescription.xml replaced."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            data = old.read(entry)
            if entry.filename == "modelDescription.xml":
                for a, b in changes:
                    assert a.encode() in data
                    data = data.replace(a.encode(), b.encode())
            new.writestr(entry, data)
    return target


# ---------------------------------------------------------------- FMUs


def test_the_fmu_says_which_of_its_inputs_are_optional_and_is_valid():
    path = ensure("allocator_bounded")
    description = fmpy.read_model_description(str(path), validate=True)
    optional = {v.name for v in load_interface("allocator_bounded").of("input") if v.optional}
    assert optional
    found = open_fmu(path).model
    assert {v.name for v in found.of("input") if v.optional} == optional
    assert not any(v.optional for v in found.of("output", "parameter"))
    texts = {v.name.partition("[")[0]: v.description for v in description.modelVariables}
    assert {n for n, text in texts.items() if "optional; 1e9 means not connected" in text} == optional


def test_an_fmu_s_elements_of_different_units_are_one_vector(here):
    path = changed(ensure("allocator"), here / "mixed.fmu", ('name="h_w"', 'name="b_B[4]"'))
    variable = open_fmu(path).model.variables["b_B"]
    assert [str(unit) for unit in variable.units] == ["T", "T", "T", "N.m.s"]
    assert (variable.shape, str(variable.at([3]).unit), variable.at([0, 2]).units) == ((4,), "N.m.s", ())
    assert variable.display_unit is None


def test_left_unconnected_the_block_sees_its_own_start(here):
    result = orchestration.run(
        {**load("delayed.yaml").source.data, "record": {"signals": ["allocator.wheel_torque_ff"]}}
    )
    assert set(result["allocator.wheel_torque_ff"].tolist()) == {1e9}


def test_what_other_blocks_need_are_the_required_inputs_of_the_loop():
    assert reference("controller", Path()).needed == {"tau_cmd_B"}
    for name in ("allocator", "allocator_bounded"):
        assert reference(name, Path()).needed == {"dipole_cmd", "wheel_torque_cmd"}
        assert set(reference(name, Path()).others) == {"plant", "controller"}
    assert reference("plant", Path()).needed == {"R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w"}


# ---------------------------------------------------------------- another team's FMU without the optional inputs


def test_it_fits_and_check_says_that_it_does_without(here):
    result = orchestrate("check", "vendor.fmu", "--as", "allocator_bounded", "--json")
    findings = json.loads(result.stdout)
    assert findings["fits"], result.stdout
    told = [f["text"] for f in findings["findings"] if f["topic"] == "optional"]
    assert [text.split(",")[0] for text in told] == ["input dipole_ff", "input wheel_torque_ff", "input rod_gains"]
    assert all("theirs runs without it, and a scenario's connection to it is dropped" in text for text in told)


def test_an_optional_input_of_theirs_that_nothing_feeds_is_no_fault(here):
    shutil.copyfile(ensure("allocator_bounded"), "bounded.fmu")
    findings = json.loads(orchestrate("check", "bounded.fmu", "--as", "allocator", "--json").stdout)
    assert findings["fits"]
    extra = [f["text"] for f in findings["findings"] if f["topic"] == "extra"]
    assert "input dipole_ff, a real [3], is only in their FMU, and optional" in extra
    plain = PLAIN.replace("allocator_bounded", "allocator")
    (here / "plain.yaml").write_text(plain)
    assert orchestrate("plain.yaml", "--swap", "allocator=bounded.fmu").exit_code == 0


def test_one_that_theirs_does_not_call_optional_has_to_be_fed(here):
    marked = (
        '<Annotations>\n        <Tool name="attitude-cosim">\n          <Optional />\n        </Tool>\n   '
        "   </Annotations>"
    )
    changed(ensure("allocator_bounded"), here / "strict.fmu", (marked, ""))
    findings = json.loads(orchestrate("check", "strict.fmu", "--as", "allocator_bounded", "--json").stdout)
    assert findings["fits"]
    assert "input dipole_ff: optional in ours, but theirs does not say that it may stay unconnected" in [
        f["text"] for f in findings["findings"]
    ]
    result = orchestrate("delayed.yaml", "--swap", "allocator=strict.fmu")
    assert result.exit_code == 2
    assert "the input wheel_torque_ff is neither connected nor given a value" in result.stderr
    (here / "mapping.yaml").write_text("ignore: [demand_fraction]\n")  # so that it stands behind an adapter
    result = orchestrate("delayed.yaml", "--swap", "allocator=strict.fmu", "--map", "mapping.yaml")
    assert "the input wheel_torque_ff is neither connected nor given a value" in result.stderr
    shutil.copyfile(ensure("allocator_bounded"), "bounded.fmu")
    assert orchestrate("delayed.yaml", "--swap", "allocator=bounded.fmu", "--map", "mapping.yaml").exit_code == 0


def test_its_connections_values_and_delays_are_dropped_and_told_and_the_run_is_that_without_them(here):
    text = DELAYED.replace(
        "fmu: allocator_bounded", "fmu: vendor.fmu, interface: allocator_bounded, start: {wheel_torque_ff: 0.001}"
    )
    swapped = orchestration.run(load(parse(text, "here.yaml")))
    told = [note for note in swapped.warnings if "dropped" in note]
    assert told == [
        "dropped, since an end of it is not there and the input is optional: plant.dipole -> allocator.dipole_ff; "
        "the value of allocator.wheel_torque_ff"
    ]
    plain = orchestration.run(load(parse(PLAIN.replace("allocator_bounded", "allocator"), "here.yaml")))
    np.testing.assert_array_equal(swapped["plant.omega_B"], plain["plant.omega_B"])


def test_a_fault_of_a_dropped_input_is_refused(here):
    (here / "delayed.yaml").write_text(DELAYED + "faults: [{at: 1 s, cut: allocator.dipole_ff}]\n")
    result = orchestrate("delayed.yaml", "--swap", "allocator=vendor.fmu")
    assert result.exit_code == 2
    assert "allocator.dipole_ff is optional and allocator lacks it, so the fault would change nothing" in result.stderr


def test_an_output_that_theirs_lacks_is_an_error_only_where_an_input_needs_it(here):
    changed(ensure("plant"), here / "without.fmu", ('name="dipole[', 'name="rods['))
    result = orchestrate("delayed.yaml", "--swap", "plant=without.fmu")
    assert result.exit_code == 0, result.stderr
    assert "the input is optional: plant.dipole -> allocator.dipole_ff" in result.stderr
    changed(ensure("plant"), here / "blind.fmu", ('name="b_B[', 'name="field['))
    result = orchestrate("delayed.yaml", "--swap", "plant=blind.fmu")
    assert result.exit_code == 2
    assert "output b_B, a real [3] in T, is missing" in result.stderr
    assert "other blocks need it" in result.stderr


@pytest.mark.thorough
def test_compare_gives_theirs_what_was_connected(here):
    result = orchestrate("compare", "delayed.yaml", "--swap", "allocator=vendor.fmu", "--out", "out")
    assert result.exit_code in (0, 1), result.output
    outputs = {d["output"]: d for d in json.loads(Path("out/comparison.json").read_text())["open_loop"]}
    assert outputs["dipole_cmd"]["largest"] is not None
    shutil.copyfile(ensure("allocator_bounded"), "same.fmu")
    result = orchestrate("compare", "delayed.yaml", "--swap", "allocator=same.fmu", "--out", "same")
    assert result.exit_code == 0, result.output
    assert all(d["largest"] in (0.0, None) for d in json.loads(Path("same/comparison.json").read_text())["open_loop"])


# ---------------------------------------------------------------- exports, kits, flavours


def test_a_loop_with_unconnected_optional_inputs_goes_to_other_tools_and_back(here):
    (here / "plain.yaml").write_text(PLAIN)
    ours = orchestration.run("plain.yaml")
    assert orchestrate("export", "plain.yaml", "--ssp", "loop.ssp", "--container", "loop.fmu").exit_code == 0
    back = orchestration.run("loop.ssp")
    np.testing.assert_array_equal(back["plant.omega_B"], ours["plant.omega_B"])
    played = fmpy.simulate_fmu(
        "loop.fmu", stop_time=2.0, step_size=0.1, output_interval=0.1, output=["plant.omega_B[2]"]
    )
    np.testing.assert_allclose(played["plant.omega_B[2]"], ours["plant.omega_B"][:, 1], rtol=0, atol=1e-15)


def test_figures_and_report_show_an_element_in_its_own_unit(here):
    changed(ensure("plant"), here / "mixed.fmu", ('name="h_w"', 'name="b_B[4]"'))
    blocks = {"it": {"fmu": "mixed.fmu", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": "1 mN.m"}}}
    panels = [{"signals": ["it.b_B"]}, {"signals": ["it.b_B[4]"], "unit": "mN.m.s", "lines": ["5 mN.m.s"]}]
    figures = [{"name": "both", "panels": panels}]
    result = orchestration.run(
        {"name": "one", "step": 1, "duration": 10, "blocks": blocks, "figures": figures}, out="out"
    )
    assert str(result.variable("it.b_B[4]").unit) == "N.m.s"
    assert result["it.b_B[4]"][-1] == pytest.approx(0.01, rel=1e-12)
    page = Path("out/report.html").read_text("utf-8")
    assert "it.b_B[4], mN.m.s" in page
    axes = Figure().subplots()
    draw_panel(axes, result.scenario.figures[0].panels[1], result.scenario.figures[0], result)
    assert axes.lines[0].get_ydata()[-1] == pytest.approx(10.0, rel=1e-12)
    assert axes.get_ylabel() == "it.b_B[4], mN.m.s"


def test_an_fmu_that_is_called_as_a_block_for_this_place_is_held_to_that(here):
    """As in an archive of a loop with it, where nothing but its file tells what it is."""
    fed = DELAYED.replace("delays:", "  - plant.wheel_torque -> allocator.wheel_torque_ff\ndelays:").replace(
        "[allocator.dipole_ff]", "[allocator.dipole_ff, allocator.wheel_torque_ff]"
    )
    (here / "fed.yaml").write_text(
        fed.replace("fmu: allocator_bounded", "fmu: allocator_bounded, start: {rod_weight: 2.0e-6}")
    )
    ours = orchestration.run("fed.yaml")
    assert orchestrate("export", "fed.yaml", "--ssp", "fed.ssp", "--for-orchestrate").exit_code == 0
    back = orchestration.run("fed.ssp")
    np.testing.assert_array_equal(back["plant.omega_B"], ours["plant.omega_B"])
    assert not [note for note in back.warnings if "dropped" in note or "further" in note]


def test_an_archive_gives_each_element_its_own_unit(here):
    changed(ensure("plant"), here / "mixed.fmu", ('name="h_w"', 'name="b_B[4]"'))
    (here / "one.yaml").write_text(
        "name: one\nstep: 1\nduration: 1\nblocks:\n  it: {fmu: mixed.fmu, start: {dipole_cmd: [0, 0, 0], "
        "wheel_torque_cmd: 0}}\n"
    )
    result = orchestrate("export", "one.yaml", "--ssp", "one.ssp")
    assert result.exit_code == 0, result.output
    with zipfile.ZipFile("one.ssp") as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    units = {
        connector.get("name"): connector[0].get("unit")
        for connector in root.iter("{http://ssp-standard.org/SSP1/SystemStructureDescription}Connector")
    }
    assert [units[f"b_B[{i}]"] for i in (1, 2, 3, 4)] == ["T", "T", "T", "N.m.s"]
    defined = {unit.get("name") for unit in root.iter("{http://ssp-standard.org/SSP1/SystemStructureCommon}Unit")}
    assert set(units.values()) - {None} <= defined


def test_a_vector_has_the_inputs_that_were_fed(here):
    result = orchestrate("new", "allocator_bounded", "kit", "--scenario", "delayed.yaml")
    assert result.exit_code == 0, result.output
    header = Path("kit/vector/vector.csv").read_text().partition("\n")[0]
    assert "dipole_ff[1]" in header
    assert "wheel_torque_ff" not in header
    shutil.copyfile(ensure("allocator_bounded"), "same.fmu")
    checked = orchestrate("check", "same.fmu", "--as", "allocator_bounded", "--vector", "kit/vector")
    assert checked.exit_code == 0, checked.output


def test_no_scenario_with_the_block_is_told_with_the_remedy(here, monkeypatch):
    monkeypatch.setattr("fmus.kit.SCENARIO", here / "nothing" / "nothing.yaml")
    (here / "nothing").mkdir()
    (here / "nothing" / "nothing.yaml").write_text(PLAIN)
    result = orchestrate("new", "plant_sensors", "kit")
    assert result.exit_code == 2
    assert "remedy: --scenario FILE with 'fmu: plant_sensors'" in result.stderr


def test_a_flavour_that_a_block_has_not_is_refused_at_its_line(here, monkeypatch):
    text = fmus_interface.load("allocator_bounded").source.replace("[block]", '[block]\nflavours = ["native"]', 1)
    only = fmus_interface.parse(text)

    def load_one(name: str) -> Any:
        return only if name == "allocator_bounded" else load_interface(name)

    monkeypatch.setattr(fmus_interface, "load", load_one)
    monkeypatch.setattr("fmus.build.load", load_one)
    monkeypatch.setattr("fmus.block.load", load_one)
    monkeypatch.setattr("orchestration.session.open.load_interface", load_one)
    result = orchestrate("delayed.yaml", "--flavour", "python")
    assert result.exit_code == 2
    assert (
        "delayed.yaml:8: blocks.allocator.fmu: the block 'allocator_bounded' has no flavour 'python'; remedy: "
        "'flavour: native' for this block" in result.stderr
    )
    result = orchestrate("build", "allocator_bounded", "--flavour", "python", "--out", "fmus")
    assert result.exit_code == 2
    assert "allocator_bounded has no flavour 'python'; expected native" in result.stderr


@pytest.mark.parametrize("compiled", [True, False])
def test_a_delayed_optional_input_is_not_connected_at_the_first_instant(here, compiled):
    scenario = load("delayed.yaml").source.data | {"record": {"signals": ["allocator.dipole_ff", "plant.dipole"]}}
    result = orchestration.run(scenario, compiled=compiled)
    assert set(result["allocator.dipole_ff"][0].tolist()) == {1e9}
    np.testing.assert_array_equal(result["allocator.dipole_ff"][1:], result["plant.dipole"][:-1])
