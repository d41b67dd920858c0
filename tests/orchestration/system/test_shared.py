"""Values that a scenario states once, and blocks that state one quantity with different values."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from fmus.build import ensure
from fmus.interface import BLOCKS
from fmus.interface import load as load_interface
from orchestration import BlockError, InputError, load, run
from orchestration.cli.main import main
from orchestration.fmu.archive import open_fmu
from orchestration.scenario.references import Name
from orchestration.session.open import open_scenario
from orchestration.session.refusal import refusal
from orchestration.system.starts import taken
from tests.commands import orchestrate

from .. import vendor
from ..mocks import model, real
from ..swapped import swapped
from ..wrong_inputs import SCENARIO

ROOT = Path(__file__).parents[3]
PAPER, FLIGHT = (ROOT / "scenarios" / f"{name}.yaml" for name in ("paper_no_singularity", "flight_vb"))


def notes(scenario, **changes) -> list[str]:
    """The warnings about quantities, before anything runs."""
    loaded = load(scenario, {name.replace("__", "."): value for name, value in changes.items()})
    return [note for note in open_scenario(loaded).plan.notes if "the same quantity" in note]


@pytest.mark.thorough
@pytest.mark.parametrize("path", sorted((ROOT / "scenarios").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_blocks_of_our_scenarios_agree(path):
    assert notes(path) == []


def test_a_shared_value_reaches_every_block_that_has_the_parameter(loop):
    loop.write_text(SCENARIO.replace("gain: -1, ", "") + "shared: {gain: -2, inertia: 0.7}\n")
    starts = run("loop.yaml").manifest["scenario"]["blocks"]
    assert starts["regulator"]["start"]["gain"] == -2.0
    assert starts["motor"]["start"]["inertia"] == 0.5, "the block's own value goes before"


def test_set_works_on_shared_values_with_and_without_their_prefix():
    for name in ("dipole_max", "shared.dipole_max"):
        plan = open_scenario(load(FLIGHT, {name: "10 A.m2"})).plan
        for block in ("plant", "controller", "allocator"):
            given = {start.element.variable: start.value for start in plan.starts[block]}
            assert given["dipole_max"] == 10.0, block
    assert notes(FLIGHT, dipole_max=10) == []


def test_a_shared_value_that_one_block_refuses_is_told_with_the_block():
    log = ["[error] dipole_max: expected less than 1, found 25"]
    failure = BlockError("allocator", "fmi2ExitInitializationMode", "gave status error", log=log, status=3)
    told = refusal(load(FLIGHT), {}, failure)
    assert str(told).endswith(": shared.dipole_max: allocator refuses it: expected less than 1, found 25")


def test_what_an_extended_file_means_to_differ_is_told_where_values_of_this_one_stand_apart(tmp_path):
    lower = tmp_path / "lower.yaml"
    lower.write_text(f"extends: {FLIGHT}\nblocks: {{allocator: {{differs: [dipole_max], start: {{dipole_max: 9}}}}}}\n")
    assert notes(lower) == []
    assert notes(lower, dipole_max=3) == []  # this file says so itself
    upper = tmp_path / "upper.yaml"
    upper.write_text("extends: lower.yaml\nname: upper\n")
    assert notes(upper) == []
    (told,) = notes(upper, dipole_max=3)
    assert "allocator.dipole_max = 9 A.m2" in told
    upper.write_text("extends: lower.yaml\nname: upper\nshared: {dipole_max: 3 A.m2}\n")
    (told,) = notes(upper)
    assert "allocator.dipole_max = 9 A.m2" in told
    top = tmp_path / "top.yaml"
    top.write_text("extends: upper.yaml\n")
    assert notes(top) == [told]
    top.write_text("extends: upper.yaml\nblocks: {allocator: {start: {dipole_max: 3}}}\n")
    assert notes(top) == []
    beside = tmp_path / "beside.yaml"
    beside.write_text("shared: {dipole_max: 3 A.m2}\n")
    top.write_text("extends: [lower.yaml, beside.yaml]\n")
    assert notes(top) == [told]
    upper.write_text(upper.read_text() + "blocks: {allocator: {differs: [dipole_max]}}\n")
    assert notes(upper) == []
    top.write_text("extends: upper.yaml\n")
    assert notes(top) == []


def test_an_allocator_left_at_25_beside_a_plant_of_10_is_warned_of_in_summary_and_manifest(tmp_path):
    done = CliRunner().invoke(
        main, [str(PAPER), "--set", "plant.dipole_max=10 A.m2", "--duration", "1", "--out", str(tmp_path)]
    )
    text = (
        "plant.dipole_max = 10 A.m2 and allocator.dipole_max = 25 A.m2: the same quantity with different "
        "values; remedy: "
    )
    assert text in " ".join(done.stderr.split())
    assert any(note.startswith(text) for note in json.loads((tmp_path / "manifest.json").read_text())["notes"])


def test_an_epoch_changed_in_the_plant_alone_is_warned_of():
    (note,) = notes(FLIGHT, plant__epoch="2010-08-10T00:00:00Z")
    assert note.startswith("plant.epoch = 2010-08-10T00:00:00Z and controller.epoch = 2009-08-10T00:00:00Z")


@pytest.mark.parametrize(
    "text", ["2009-08-10", "2009-08-10T00:00", "2009-08-10T00:00:00.000+00:00", "2009-08-10 00:00:00"]
)
def test_one_instant_written_in_two_ways_is_one_epoch(text):
    assert notes(FLIGHT, plant__epoch=text) == []


def test_a_matrix_is_warned_of_by_its_first_element_that_differs():
    (note,) = notes(PAPER, plant__J_B=[[0.0426, 0, 0], [0, 0.07, 0], [0, 0, 0.08]])
    assert "plant.J_B[2][2] = 0.07 kg.m2 and controller.J_B[2][2] = 0.0608 kg.m2 (and 1 more elements)" in note


def test_units_and_rounding_are_no_difference():
    assert notes(FLIGHT, plant__wheel_torque_max="0.003 N.m", controller__dipole_max=25.0 * (1 + 1e-12)) == []


def test_a_difference_that_is_declared_is_not_warned_of_and_others_are():
    source = load(FLIGHT, {"plant.epoch": "2010-08-10T00:00:00Z", "plant.dipole_max": 10}).source
    declared = load(source.with_entry(("blocks", "plant", "differs"), ["epoch"]))
    (note,) = [n for n in open_scenario(declared).plan.notes if "the same quantity" in n]
    assert note.startswith("plant.dipole_max = 10 A.m2 and controller.dipole_max = allocator.dipole_max = 25 A.m2")


def test_a_known_error_of_inertia_is_declared_by_the_plants_own_parameter():
    assert notes(PAPER, plant__J_error_B=[[0.001, 0, 0], [0, 0, 0], [0, 0, 0]]) == []


def test_blocks_that_are_not_wired_together_may_differ():
    data = load(PAPER).source.data
    twins = {
        **data["blocks"],
        "other": {"fmu": "plant", "start": {"dipole_max": 5, "dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}},
    }
    assert notes({**data, "blocks": twins}) == []


def test_a_foreign_fmu_is_compared_by_our_interface(tmp_path):
    """An allocator without any annotation of ours, its limit left at 25 A m2."""
    path = tmp_path / "theirs.fmu"
    with zipfile.ZipFile(ensure("allocator", "native")) as archive, zipfile.ZipFile(path, "w") as copy:
        for name in archive.namelist():
            data = archive.read(name)
            if name == "modelDescription.xml":
                assert b"attitude-cosim" in data
                data = data.replace(b'Tool name="attitude-cosim"', b'Tool name="other"')
            copy.writestr(name, data)
    assert {v.quantity for v in open_fmu(path).model.of("parameter")} == {None}
    source = load(PAPER, {"plant.dipole_max": 10}).source.with_entry(("blocks", "allocator", "fmu"), str(path))
    (note,) = notes(source)
    assert "allocator.dipole_max = 25 A.m2" in note


def test_a_shared_value_reaches_a_swapped_fmu_by_its_mapping_and_one_that_it_lacks_is_told(tmp_path, monkeypatch):
    text = SCENARIO.replace("gain: -1, ", "") + "shared: {gain: -0.7}\n"
    swapped(tmp_path, monkeypatch, scenario=text)
    ours = run("loop.yaml")
    swap = ("loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--format", "mat")
    assert orchestrate(*swap, "--out", "theirs").exit_code == 0
    theirs = json.loads(Path("theirs/manifest.json").read_text())
    assert theirs["parameters"]["regulator"]["kp"] == pytest.approx(-0.7 * vendor.GAIN)
    assert theirs["scenario"]["blocks"]["regulator"]["start"] == {"gain": -0.7, "enabled": True}
    assert ours.manifest["parameters"]["regulator"]["gain"] == -0.7
    Path("mapping.yaml").write_text("ports: {speed: rate, voltage: command}\n")
    lost = orchestrate(*swap, "--out", "lost")
    assert lost.exit_code in (0, 1)
    assert "regulator: its FMU has no parameter gain, so the shared value does not reach it" in lost.stderr


@pytest.mark.parametrize("block", BLOCKS)
def test_an_fmu_states_the_quantities_of_its_interface(block):
    model = open_fmu(ensure(block, "native")).model
    expected = {v.name: v.quantity for v in load_interface(block).variables.values() if v.causality == "parameter"}
    assert {v.name: v.quantity for v in model.of("parameter")} == expected


def test_one_quantity_has_one_unit_and_one_shape_in_all_interfaces():
    seen: dict[str, tuple[object, ...]] = {}
    for block in BLOCKS:
        of_set = "wheels" in load_interface(block).variables  # there each wheel has the shape that it has alone
        for v in load_interface(block).of("parameter"):
            if v.quantity:
                shape = v.shape[1:] if of_set and v.quantity.startswith("wheel_") else v.shape
                assert seen.setdefault(v.quantity, (v.unit, shape, v.type)) == (v.unit, shape, v.type), (block, v.name)
    assert {"epoch", "J_B", "rod_axes", "dipole_max", "wheel_torque_max", "wheel_momentum_max"} <= seen.keys()


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (
            "shared: {inertai: 1}\n",
            "loop.yaml:20: shared.inertai: no block has a parameter 'inertai'; did you mean 'inertia'?",
        ),
        ("shared:\n  inertia: 1 kg\n  gain: true\n", "loop.yaml:22: shared.gain: expected"),
        ("shared: 3\n", "loop.yaml:20: shared: expected names with values, found 3"),
    ],
)
def test_a_wrong_shared_value_is_an_error_at_its_line(loop, extra, message):
    loop.write_text(SCENARIO.replace("      inertia: 0.5\n", "").replace("gain: -1, ", "") + extra)
    with pytest.raises(InputError) as error:
        run("loop.yaml")
    assert message in str(error.value)


def test_a_shared_value_that_two_blocks_refuse_is_one_error():
    with pytest.raises(InputError) as error:
        open_scenario(load(PAPER, {"rod_axes": 1}))
    assert str(error.value) == "rod_axes=1: expected 3 rows of 3 values, found 1"


def test_differs_names_a_parameter_that_other_blocks_state():
    source = load(PAPER).source.with_entry(("blocks", "plant", "differs"), ["epohc"])
    with pytest.raises(
        InputError, match="blocks.plant.differs.1.: plant has no parameter 'epohc' .*did you mean 'epoch'"
    ):
        open_scenario(load(source))


def test_no_block_is_called_shared(loop):
    loop.write_text(SCENARIO.replace("motor", "shared"))
    with pytest.raises(InputError, match="no block can be called 'shared'"):
        load("loop.yaml")


def test_the_system_as_an_archive_keeps_the_values_in_each_block(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = load(PAPER, {"dipole_max": 10, "duration": 2}).source.without([("expect",), ("figures",)])
    Path("paper.yaml").write_text(json.dumps({**source.data, "name": "archived"}))
    assert orchestrate("export", "paper.yaml", "--ssp", "paper.ssp").exit_code == 0
    again = run("paper.ssp")
    assert (again["plant.dipole"] == run("paper.yaml")["plant.dipole"]).all()
    assert {again.manifest["parameters"][block]["dipole_max"] for block in ("plant", "allocator")} == {10.0}


def test_a_shared_value_is_taken_by_its_quantity_and_not_by_another_one_of_the_same_name():
    named = replace(real("size", "parameter"), quantity="size_of_wheel")
    other = replace(real("width", "parameter"), quantity="size")
    assert taken(model("a", named), Name("size")) is None
    assert taken(model("a", named), Name("size_of_wheel")) == "size"
    assert taken(model("a", named, other), Name("size")) == "width"
    assert taken(model("a", real("size", "parameter")), Name("size[2]")) == "size[2]"
    assert taken(model("a", real("size", "input")), Name("size")) is None


@pytest.mark.parametrize("order", [("altitude", "orbit_radius"), ("orbit_radius", "altitude")])
def test_an_option_beats_the_file_whichever_of_two_names_of_a_value_the_file_has(order):
    in_file, in_option = order
    values = {"altitude": "600 km", "orbit_radius": "7500 km"}
    start = {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}
    blocks = {"plant": {"fmu": "plant", "start": start}}
    loop = {"name": "l", "step": 1, "duration": 1, "blocks": blocks, "shared": {in_file: values[in_file]}}
    starts = open_scenario(load(loop, {in_option: values[in_option]})).plan.starts["plant"]
    (radius,) = (s.value for s in starts if s.element.variable == "orbit_radius")
    assert radius == {"altitude": 6978137.0, "orbit_radius": 7.5e6}[in_option]


@pytest.mark.parametrize("own", ["orbit_radius", "altitude"])
def test_an_option_that_no_block_takes_since_it_has_its_own_value_is_refused(own):
    start = {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0, own: "7000 km"}
    loop = {"name": "l", "step": 1, "duration": 1, "blocks": {"plant": {"fmu": "plant", "start": start}}}
    message = "altitude=600 km: reaches no block, since plant has a value of its own; remedy: --set plant.altitude=..."
    with pytest.raises(InputError, match=message):
        open_scenario(load(loop, {"altitude": "600 km"}))
    open_scenario(load(loop, {"plant.altitude": "600 km"}))
    open_scenario(load({**loop, "shared": {"altitude": "600 km"}}))  # in a file it is a default
