"""The mapping that `check --suggest` proposes."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.interface import parse
from fmus.kit import generated
from orchestration.acceptance.candidates import Candidate, candidates, told_unit
from orchestration.acceptance.check import check
from orchestration.acceptance.suggest import suggest
from orchestration.fmu.model import Variable
from orchestration.quantities import parse_unit
from orchestration.scenario.mapping import load
from tests.commands import orchestrate

from .. import fmus, vendor

EXAMPLE = Path(__file__).parents[3] / "examples" / "hardware_allocator"


def proposed(folder: Path, *changes: tuple[str, str]) -> Path:
    """The proposal for the example's FMU, as a file."""
    text = (EXAMPLE / "interface.toml").read_text("utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    fmu = fmus.write(folder / "team.fmu", generated(parse(text, "team.toml"))["modelDescription.xml"])
    fitted = check(fmu, "allocator")[1]
    path = folder / "proposed.yaml"
    path.write_text(suggest(fitted), "utf-8")
    assert not [f for f in check(fmu, "allocator", path)[1].errors if f.topic != "library"]
    return path


def test_the_example_s_ports_are_all_found_and_only_signs_and_axes_are_left_to_say(tmp_path):
    """It is the example's own mapping, but for what no name, unit or description tells."""
    mapping, own = load(proposed(tmp_path))[0], load(EXAMPLE / "mapping.yaml")[0]
    assert {n: p.theirs for n, p in mapping.ports.items()} == {n: p.theirs for n, p in own.ports.items()}
    assert mapping.ports["h_w"].divide == "147 g.cm2"  # the inertia of their rotor: 1.47e-5 kg.m2
    assert {"holding", "hold_fraction"} <= set(mapping.ignore)


def test_a_speed_stands_for_the_momentum_by_our_wheels_inertia_where_theirs_has_none(tmp_path):
    path = proposed(
        tmp_path,
        ("[variables.rotor_inertia]", "[variables.rotor_mass]"),
        ('unit = "g.cm2"', 'unit = "g"'),
        ('"rotor_inertia"', '"rotor_mass"'),
    )
    assert load(path)[0].ports["h_w"].divide == "1.47e-05 kg.m2"
    assert "by wheel_inertia of our plant" in path.read_text("utf-8")


def test_what_rests_on_a_factor_or_on_a_name_alone_is_marked_as_unsure(tmp_path):
    lines = proposed(tmp_path).read_text("utf-8").splitlines()
    unsure = {line.split(":")[0].strip() for line in lines if "# unsure" in line}
    assert "h_w" in unsure
    assert not unsure & {"tau_cmd_B", "omega_B", "dipole_cmd", "wheel_torque_cmd"}


@pytest.mark.parametrize(
    ("unit", "text"),
    [("nT", "nT"), ("Gauss", "G"), ("mGauss", "milligauss"), ("-", "[-]")],
)
def test_units_are_read_as_engineers_write_them(unit, text):
    assert parse_unit(unit).exponents == parse_unit(text).exponents
    assert parse_unit(unit).factor == pytest.approx(parse_unit(text).factor)


@pytest.mark.parametrize("unit", ["Nms", "N m s", "kg.m2/s"])
def test_compound_units_are_one_unit_however_they_are_written(unit):
    assert parse_unit(unit).fits(parse_unit("N.m.s"))
    assert parse_unit("Am2").fits(parse_unit("A.m^2"))
    assert parse_unit("RPM").factor == pytest.approx(parse_unit("dps").factor * 6.0)


def test_a_unit_that_the_fmu_does_not_declare_is_read_from_its_description(tmp_path):
    text = proposed(
        tmp_path,
        (
            'unit = "deg/s"\nframe = "spacecraft body"\ndescription = "Gyro reading"',
            'description = "Gyro reading [deg/s]"',
        ),
    ).read_text("utf-8")
    line = next(line for line in text.splitlines() if "gyro" in line)
    assert "unit: deg/s" in line
    assert "# unsure" in line


def test_the_command_prints_a_file_that_a_swap_takes(tmp_path, monkeypatch):
    fmus.write_pair(tmp_path)
    vendor.write(tmp_path, runnable=True)
    monkeypatch.chdir(tmp_path)
    result = orchestrate("check", "vendor.fmu", "--as", "regulator.fmu", "--suggest")
    assert result.exit_code == 0
    assert "  speed: rate  #" in result.stdout
    assert "  voltage: command  #" in result.stdout
    Path("proposed.yaml").write_text(result.stdout, "utf-8")
    assert orchestrate("check", "vendor.fmu", "--as", "regulator.fmu", "--map", "proposed.yaml").exit_code == 0


def team(folder: Path, *ports: str) -> Path:
    """An FMU with these inputs of one value each, `name unit`."""
    inputs = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="input" variability="continuous">'
        f'<Real unit="{unit}" start="0"/></ScalarVariable>\n'
        for i, (name, unit) in enumerate(port.split() for port in ports)
    )
    units = (
        '<Unit name="T"><BaseUnit kg="1" s="-2" A="-1"/></Unit><Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit>'
    )
    xml = fmus.description("regulator").replace("<UnitDefinitions>", f"<UnitDefinitions>{units}")
    before, _, after = xml.partition("<ModelVariables>")
    xml = f"{before}<ModelVariables>{inputs}{after[after.index('</ModelVariables>') :]}"
    return fmus.write(
        folder / "team.fmu", xml.replace(xml[xml.index("<Outputs>") : xml.index("</ModelStructure>")], "")
    )


@pytest.mark.parametrize(
    "names", ["B_meas_{}", "b_meas{}", "bs_{}", "B_{}_meas", "field{}_T"], ids=lambda name: name.format("X")
)
def test_scalars_are_the_elements_of_one_vector_wherever_their_index_stands(tmp_path, names):
    """The s of B_meas_X, gyros_x and torques_y is no index, since there is no such name with another one."""
    fields, rates, torques = (
        [f"{name.format(axis)} {unit}" for axis in "XYZ"]
        for name, unit in ((names, "T"), ("gyros_{}", "rad/s"), ("torques_{}", "N.m"))
    )
    fitted = check(team(tmp_path, *rates, *fields, *torques), "allocator")[1]
    (tmp_path / "proposed.yaml").write_text(suggest(fitted), "utf-8")
    mapping = load(tmp_path / "proposed.yaml")[0]
    assert [str(name) for name in mapping.ports["b_B"].theirs] == [names.format(axis) for axis in "XYZ"]
    assert [str(name) for name in mapping.ports["omega_B"].theirs] == ["gyros_X", "gyros_Y", "gyros_Z"]
    assert [str(name) for name in mapping.ports["tau_cmd_B"].theirs] == ["torques_X", "torques_Y", "torques_Z"]


def test_no_required_input_is_ignored_and_none_gets_a_constant_while_theirs_may_have_it(tmp_path):
    three = [f"gyros_{axis} rad/s" for axis in "xyz"]
    text = suggest(check(team(tmp_path, *three, "field_1 T", "other_2 T", "third T"), "allocator")[1])
    assert "  # b_B: THEIRS  # not found: one of field_1, other_2, third? Else list it under ignore\n" in text
    assert not {"b_B", "tau_cmd_B", "h_w"} & set(
        text[text.index("ignore:") :].replace("[", " ").replace(",", " ").split()
    )
    assert "start:" not in text
    text = suggest(check(team(tmp_path, *three), "allocator")[1])
    assert "b_B, h_w" in text[text.index("ignore:") :], "theirs has nothing left that it could be"


@pytest.mark.parametrize(
    ("names", "units"),
    [(["p", "q", "r"], "rad/s"), (["roll_rate", "pitch_rate", "yaw_rate"], "rad/s")],
    ids=["letters of flight mechanics", "a common ending"],
)
def test_scalars_in_a_row_are_one_vector_though_no_index_tells_it(tmp_path, names, units):
    fields = [f"mag_{axis} T" for axis in "xyz"]
    text = suggest(check(team(tmp_path, *fields, *(f"{name} {units}" for name in names), "h N.m.s"), "allocator")[1])
    assert f"  omega_B: [{', '.join(names)}]  # unsure" in text


def test_scalars_of_roll_pitch_and_yaw_stand_for_the_axes_about_which_they_turn(tmp_path):
    rates = [f"rate_{name} rad/s" for name in ("pitch", "yaw", "roll")]
    text = suggest(check(team(tmp_path, *(f"mag_{axis} T" for axis in "xyz"), *rates), "allocator")[1])
    assert "  omega_B: [rate_roll, rate_pitch, rate_yaw]  # unsure" in text


def entry(folder: Path, block: str, port: str, *theirs: tuple[str, str]) -> str:
    """The proposed line of a port for an FMU with these, name and description, in place of a controller's inputs, or of
    the outputs of a plant or an allocator."""
    kinds, kind = {"q": ("", 4), "w": ("rad/s", 3), "a": ("", 3), "p": ("km", 3), "t": ("N.m", 1)}, "input"
    if block in ("plant", "allocator"):
        kind = "output"
    text = '[block]\nname = "team"\ndescription = "x"\n[experiment]\nstop = 1.0\nstep = 0.1\n'
    for name, description in theirs:
        unit, size = kinds[name[0]]
        text += (
            f'[variables.{name}]\ncausality = "{kind}"\nunit = "{unit}"\n{f"shape = [{size}]" if size > 1 else ""}\n'
        )
        text += f'description = "{description}"\n'
        text += f"start = {[0.0] * size}\n" if kind == "input" else "depends_on = []\ninitially_depends_on = []\n"
    fmu = fmus.write(folder / "team.fmu", generated(parse(text, "team.toml"))["modelDescription.xml"])
    return next(line for line in suggest(check(fmu, block)[1]).splitlines() if line.startswith(f"  {port}: "))


@pytest.mark.parametrize(
    ("block", "port", "other", "chosen"),
    [
        ("controller", "R_NB", ("q_ref", "reference quaternion, body to inertial"), ("q_meas", "measured quaternion")),
        ("controller", "R_NB", ("q_target", "target attitude"), ("q_att", "attitude relative to the reference frame")),
        ("controller", "R_NB", ("q_bo", "quaternion, body to LVLH"), ("q_bi", "quaternion, body to inertial")),
        ("controller", "omega_B", ("w", "body rate relative to LVLH"), ("wi", "inertial body rate")),
        ("controller", "omega_B", ("w_prev", "body rate of the cycle before"), ("w_now", "gyros")),
        ("controller", "omega_B", ("w_drift", "body rate that the gyro has at rest"), ("w_x", "gyros")),
        ("plant", "r_N", ("p_ecef", "position, ECEF"), ("p_eci", "position, ECI")),
        ("plant", "omega_B", ("w_bo", "body rate relative to orbit"), ("w_bi", "body rate")),
        ("plant", "omega_B", ("w_meas", "measured body rate"), ("w_true", "true rate of the body")),
    ],
)
def test_what_is_told_to_be_a_reference_an_earlier_value_or_of_the_orbit_goes_last(
    tmp_path, block, port, other, chosen
):
    for ports in ((other, chosen), (chosen, other)):
        line = entry(tmp_path, block, port, *ports)
        assert chosen[0] in line.replace(",", " ").replace("theirs:", " ").split(), line
    alone = entry(tmp_path, block, port, other)
    assert other[0] in alone
    assert "# unsure" in alone
    assert "their words tell " in alone


@pytest.mark.parametrize(
    ("name", "description", "form"),
    [
        ("a_rpy", "roll, pitch, yaw", "euler xyz"),
        ("a_euler", "Euler angles 3-2-1: roll, pitch, yaw", "euler xyz"),
        ("a_euler", "Euler angles 3-2-1: yaw, pitch, roll", "euler ZYX"),
        ("a_euler", "Euler angles 3-1-2", "euler ZXY"),
    ],
)
def test_roll_pitch_and_yaw_in_this_order_are_the_angles_about_fixed_axes(tmp_path, name, description, form):
    """Rz(yaw) Ry(pitch) Rx(roll), whichever angle stands first."""
    assert f"rotation: {form}" in entry(tmp_path, "controller", "R_NB", (name, description))


def test_nine_scalars_are_a_matrix_however_their_rows_and_columns_are_written():
    class Scalars:
        def __init__(self, names):
            self.names = names

        def of(self, causality):
            return [Variable(name, causality) for name in self.names]

    for form in ("DCM_row{}_{}", "R_r{}c{}", "att{}{}"):
        for columns in ("123", "xyz") if "c" not in form else ("123",):
            names = [form.format(i, j) for i in "123" for j in columns]
            made = [one.names for one in candidates(Scalars(names), "input") if one.shape == (3, 3)]
            assert tuple(names) in made, form


def test_units_are_read_from_words_in_other_spellings():
    own = {"T": parse_unit("T"), "N.m": parse_unit("N.m"), "A.m2": parse_unit("A.m2")}
    told = [("T", "Champ magn\u00e9tique [mG]", "mG"), ("N.m", "Couple demand\u00e9 en \u00b5N\u00b7m", "uN.m")]
    told += [("A.m2", "Moment magn\u00e9tique command\u00e9, A\u00b7m\u00b2", "A.m2")]
    for ours, text, unit in told:
        found = told_unit(Candidate(("a",), Variable("a", "input", description=text), 1, (), "a"), own[ours])
        assert found is not None, text
        assert found.factor == pytest.approx(parse_unit(unit).factor)


@pytest.mark.parametrize(("words", "inverse"), [("from body to inertial", False), ("from inertial to body", True)])
def test_a_quaternion_that_is_told_to_lead_the_other_way_is_proposed_as_the_inverse(tmp_path, words, inverse):
    text = f"""
[block]
name = "team"
description = "A controller"
[experiment]
stop = 1.0
step = 0.1
[variables.att]
causality = "input"
shape = [4]
description = "Attitude quaternion, {words}, scalar last"
start = [0.0, 0.0, 0.0, 1.0]
[variables.torque]
causality = "output"
shape = [3]
unit = "N.m"
description = "Commanded torque"
depends_on = ["att"]
"""
    fmu = fmus.write(tmp_path / "team.fmu", generated(parse(text, "team.toml"))["modelDescription.xml"])
    (tmp_path / "proposed.yaml").write_text(suggest(check(fmu, "controller")[1]), "utf-8")
    port = load(tmp_path / "proposed.yaml")[0].ports["R_NB"]
    assert (port.quaternion, bool(port.inverse)) == ("scalar last", inverse)


def test_scalars_that_are_listed_in_another_order_stand_in_that_of_the_axes(tmp_path):
    mixed = [f"gyros_{axis} rad/s" for axis in "zxy"]
    text = suggest(check(team(tmp_path, *(f"mag_{axis} T" for axis in "xyz"), *mixed), "allocator")[1])
    assert "  omega_B: [gyros_x, gyros_y, gyros_z]" in text


def test_what_is_left_of_its_size_is_taken_though_its_words_tell_another_thing(tmp_path):
    found = entry(tmp_path, "controller", "omega_B", ("q", "attitude"), ("a_1", "magnetic field"))
    assert "theirs: a_1" in found
    assert "# unsure: the only one left of its size and unit" in found


def test_a_port_of_our_name_but_another_shape_is_not_taken_for_ours(tmp_path):
    text = suggest(check(team(tmp_path, "b_B T", *(f"gyros_{axis} rad/s" for axis in "xyz")), "allocator")[1])
    assert "# b_B: THEIRS  # not found" in text


def test_of_two_alike_the_one_whose_description_shares_our_words_goes_before(tmp_path):
    found = entry(tmp_path, "controller", "omega_B", ("w_1", "rate in the test stand"), ("w_2", "body rate, relative"))
    assert found.startswith("  omega_B: w_2")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("body rate in inertial axes", "{theirs: w, turn: R_NB"),
        ("body rate in body axes", "w "),
        ("body rate in orbital axes", "w "),
    ],
)
def test_a_vector_along_the_axes_of_a_rotation_s_other_side_is_turned_by_it(tmp_path, words, told):
    found = entry(tmp_path, "controller", "omega_B", ("w", words), ("q", "attitude"))
    assert found.startswith(f"  omega_B: {told}"), found


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("Torque on the rotor", "t "),
        ("Torque on the body by the wheel's motor", "t "),
        ("Torque on the body", "{theirs: t,"),
    ],
)
def test_a_torque_on_the_wheel_s_other_side_has_the_opposite_sign(tmp_path, words, told):
    found = entry(tmp_path, "allocator", "wheel_torque_cmd", ("t", words))
    assert found.startswith(f"  wheel_torque_cmd: {told}"), found
    assert ("scale: -1" in found) == ("theirs" in told)
