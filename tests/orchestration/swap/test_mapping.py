"""Another team's block behind our interface: what the master sees, on mocks and on FMUs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from orchestration import InputError, load, run
from orchestration.cli.main import main
from orchestration.fmu.interfaces import Interface
from orchestration.fmu.model import Element, Model
from orchestration.quantities import Unit, parse_unit
from orchestration.scenario.mapping import Mapping
from orchestration.swap import rotation
from orchestration.swap.adapter import Adapter
from orchestration.swap.as_ours import model
from orchestration.swap.findings import unfed
from orchestration.swap.fit import fit

from .. import fmus, mocks, vendor
from ..mocks import Mock, real
from ..wrong_inputs import SCENARIO


def reference(kind: Model, starts=None) -> Interface:
    return Interface(kind.name, kind, starts or {e: 0.0 for v in kind.of("input", "parameter") for e in v.elements})


def fitted(ours: Model, theirs: Model, **mapping):
    return fit(reference(ours), theirs, Mapping.model_validate(mapping))


def echo(name: str, kind: Model, pairs: dict[str, str]) -> Mock:
    """A block whose outputs are its inputs, by name."""

    def evaluate(block: Mock) -> None:
        for output, given in pairs.items():
            for position in range(kind.variables[output].size):
                block.values[Element(output, position)] = block.values[Element(given, position)]

    return Mock(name, kind, evaluate)


def through(found, theirs: Mock, **inputs):
    """What ours are given comes back: sets inputs by name before the first step, and in it."""
    assert not found.errors, [str(f) for f in found.errors]
    adapter = Adapter(theirs, found)
    adapter.enter(1.0)
    kind = model(found)
    fed = [e for name in inputs for e in kind.variables[name].elements]
    given = [e for v in kind.of("output") for e in v.elements]
    values = [x for value in inputs.values() for x in np.ravel(value).tolist()]
    adapter.set(zip(fed, values, strict=True))
    first = adapter.get(given)
    into = np.zeros(len(given))
    buffer = adapter.wire(fed, given, [len(given), 0, 0, 0], into)
    adapter.leave()
    buffer[:] = values
    adapter.set_inputs()
    adapter.do_step(0.0, 0.1)
    adapter.get_live()
    np.testing.assert_allclose(into, first, rtol=1e-14, atol=1e-300)
    return dict(zip((f"{e.variable}[{e.position}]" for e in given), into, strict=True))


# ---------------------------------------------------------------- quantities


def unit(name: str):
    return parse_unit(name)


def test_theirs_is_A_ours_plus_c_in_both_directions():
    rng = np.random.default_rng(1)
    A, c = rng.normal(size=(3, 3)), rng.normal(size=3)
    ours = mocks.model("ours", real("u", "input", shape=(3,)), real("y", "output", shape=(3,)))
    theirs = mocks.model("theirs", *(real(f"a{i}", "input") for i in range(3)), real("b", "output", shape=(3,)))

    def evaluate(block: Mock) -> None:
        for i in range(3):
            block.values[Element("b", i)] = block[f"a{i}"]

    entry = {"matrix": A.tolist(), "offset": c.tolist()}
    found = fitted(ours, theirs, ports={"u": {"theirs": ["a0", "a1", "a2"], **entry}, "y": {"theirs": "b", **entry}})
    block = Mock("x", theirs, evaluate)
    u = rng.normal(size=3)
    back = through(found, block, u=u)
    np.testing.assert_allclose([block[f"a{i}"] for i in range(3)], A @ u + c, rtol=1e-14)
    np.testing.assert_allclose([back[f"y[{i}]"] for i in range(3)], u, rtol=1e-12)


@pytest.mark.parametrize(
    ("ours", "theirs", "value", "expected"),
    [
        ("rad/s", "deg/s", math.pi, 180.0),
        ("N.m", "mN.m", 0.25, 250.0),
        ("T", "nT", 3e-5, 3e4),
        ("A.m2", "mA.m2", 1.5, 1500.0),
        ("K", "degC", 300.0, 26.85),
        ("rad/s", "rpm", 2 * math.pi, 60.0),
    ],
)
def test_units_are_converted_without_being_told(ours, theirs, value, expected):
    a = mocks.model("ours", real("u", "input", unit=unit(ours)), real("y", "output", unit=unit(ours)))
    b = mocks.model("theirs", real("u", "input", unit=unit(theirs)), real("y", "output", unit=unit(theirs)))
    block = echo("x", b, {"y": "u"})
    back = through(fitted(a, b), block, u=value)
    assert block["u"] == pytest.approx(expected, rel=1e-13)
    assert back["y[0]"] == pytest.approx(value, rel=1e-13)


def test_a_momentum_becomes_a_speed_by_an_inertia():
    ours = mocks.model("ours", real("h", "input", unit=unit("N.m.s")), real("y", "output", unit=unit("N.m.s")))
    theirs = mocks.model("theirs", real("tach", "input", unit=unit("rpm")), real("y", "output", unit=unit("N.m.s")))
    for entry in ({"divide": "147 g.cm2"}, {"scale": f"{1 / 1.47e-5!r} rad/kg/m2"}):
        found = fitted(ours, theirs, ports={"h": {"theirs": "tach", **entry}})
        block = echo("x", theirs, {"y": "tach"})
        through(found, block, h=0.03)
        assert block["tach"] == pytest.approx(0.03 / 1.47e-5 * 30 / math.pi, rel=1e-12)


def test_a_factor_of_the_wrong_unit_is_refused():
    ours = mocks.model("ours", real("h", "input", unit=unit("N.m.s")))
    theirs = mocks.model("theirs", real("tach", "input", unit=unit("rpm")))
    (fault,) = fitted(ours, theirs, ports={"h": {"theirs": "tach", "divide": "147 g"}}).errors
    assert "ours, N.m.s, over 147 g does not come out in rpm" in str(fault)


def test_a_factor_beyond_a_double_is_refused():
    ours = mocks.model("ours", real("h", "input"))
    theirs = mocks.model("theirs", real("v", "input"))
    (fault,) = fitted(ours, theirs, ports={"h": {"theirs": "v", "divide": 1e-310}}).errors
    assert "the factor 1e-310 is beyond what a double holds" in str(fault)


@pytest.mark.parametrize(
    ("matrix", "fits"),
    [([[1e-9, 0], [0, 1e-9]], True), ([[1, 1], [1, 1 + 1e-13]], False), ([[0, 0], [0, 0]], False)],
)
def test_a_matrix_is_turned_back_by_its_condition_whatever_its_size(matrix, fits):
    ours = mocks.model("ours", real("y", "output", shape=(2,)))
    theirs = mocks.model("theirs", real("y", "output", shape=(2,)))
    assert (not fitted(ours, theirs, ports={"y": {"theirs": "y", "matrix": matrix}}).errors) is fits


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (
            Unit("deg/s", unit("rad/s").exponents),
            "the unit deg/s to be 1 s-1.rad, but usually it is 0.01745329252 s-1.rad",
        ),
        (Unit("rad/s", unit("rad/s").exponents, -1.0), "the unit rad/s to be -1 s-1.rad, but usually it is 1 s-1.rad"),
        (Unit("rpm", unit("rad").exponents, math.pi / 30), "but usually it is 0.1047197551 s-1.rad"),
        (Unit("degC", unit("K").exponents, 1.0, 0.0), "the unit degC to be 1 K, but usually it is 1 K +273.15"),
        (Unit("deg/s", unit("rad/s").exponents, 0.0174533), ""),
        (Unit("knack", unit("rad/s").exponents, 3.0), ""),
    ],
)
def test_a_unit_that_is_declared_to_be_another_is_refused_unless_it_is_stated(declared, message):
    own = unit("K" if declared.name == "degC" else "rad/s")
    ours = mocks.model("ours", real("u", "input", unit=own))
    theirs = mocks.model("theirs", real("u", "input", unit=declared))
    told = "\n".join(map(str, fitted(ours, theirs).errors))
    assert (message in told) if message else not told
    if message:
        assert f"or state what is meant, such as 'unit: {declared}', in the mapping" in told
        assert not fitted(ours, theirs, ports={"u": {"theirs": "u", "unit": declared.name}}).errors


def test_elements_that_nothing_feeds_are_refused_unless_they_have_a_start():
    ours = mocks.model("ours", real("u", "input", shape=(2,)))
    theirs = mocks.model("theirs", real("gyro", "input", shape=(4,)))
    ports = {"u": ["gyro[1]", "gyro[3]"]}
    found = fitted(ours, theirs, ports=ports)
    (fault,) = found.errors
    assert "inputs gyro[2] gyro[4] are of theirs only, and nothing feeds them; remedy: " in str(fault)
    assert not unfed(fault), "no scenario can feed them"
    assert found.findings[0].text == "input u = gyro[1] gyro[3], a real [2]"
    found = fitted(ours, theirs, ports=ports, start={"gyro[2]": 0.1, "gyro[4]": 0.2})
    assert not found.errors
    block = Mock("x", theirs, lambda b: None)
    through(found, block, u=[5.0, 6.0])
    assert block.vector("gyro").tolist() == [5.0, 0.1, 6.0, 0.2]
    (fault,) = fitted(ours, theirs, ports=ports, start={"gyro": [1, 2, 3, 4]}).errors[:1]
    assert "gyro[1] gyro[3] stands for our u, whose value it takes" in str(fault)


def test_what_is_left_of_outputs_and_parameters_is_told():
    ours = mocks.model("ours", real("y", "output"), real("p", "parameter"))
    theirs = mocks.model("theirs", real("v", "output", shape=(2,)), real("q", "parameter", shape=(2,)))
    told = [f.text for f in fitted(ours, theirs, ports={"y": "v[2]", "p": "q[1]"}).findings]
    assert "elements of outputs that stand for nothing of ours: v[1]" in told
    assert "parameter of theirs only, at the values of their FMU: q[2]" in told


def test_a_stated_unit_stands_for_one_that_is_not_declared():
    ours = mocks.model("ours", real("u", "input", unit=unit("rad/s")), real("y", "output"))
    theirs = mocks.model("theirs", real("u", "input"), real("y", "output"))
    silent = fitted(ours, theirs)
    assert any("theirs has no unit, so it is taken to be in rad/s" in f.text for f in silent.findings)
    found = fitted(ours, theirs, ports={"u": {"theirs": "u", "unit": "deg/s"}})
    assert not [f for f in found.findings if f.level == "warning"]
    block = echo("x", theirs, {"y": "u"})
    through(found, block, u=math.pi)
    assert block["u"] == pytest.approx(180.0)


# ---------------------------------------------------------------- quaternions


@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("last", [False, True])
def test_a_quaternion_stands_for_a_rotation_matrix(last, inverse):
    ours = mocks.model("ours", real("R", "input", shape=(3, 3)), real("S", "output", shape=(3, 3)))
    theirs = mocks.model("theirs", real("q", "input", shape=(4,)), real("p", "output", shape=(4,)))
    entry = {"quaternion": f"scalar {'last' if last else 'first'}", "inverse": inverse}
    found = fitted(ours, theirs, ports={"R": {"theirs": "q", **entry}, "S": {"theirs": "p", **entry}})
    near_half_turns = Rotation.from_rotvec(np.pi * (1 - 1e-9) * np.eye(3))
    for R in [*Rotation.random(20, random_state=2).as_matrix(), *near_half_turns.as_matrix(), np.eye(3)]:
        block = echo("x", theirs, {"p": "q"})
        back = through(found, block, R=R)
        q = block.vector("q")
        expected = Rotation.from_matrix(R.T if inverse else R).as_quat(scalar_first=not last)
        np.testing.assert_allclose(q * np.sign(q @ expected), expected, atol=1e-12)
        np.testing.assert_allclose(np.reshape(list(back.values()), (3, 3)), R, atol=1e-12)


def test_a_course_of_quaternions_has_no_jumps():
    last = None
    for angle in np.linspace(0.0, 4 * np.pi, 400):
        R = Rotation.from_rotvec(angle * np.array([0.36, 0.48, 0.8])).as_matrix().ravel().tolist()
        q = rotation.quaternion(R, last)
        assert last is None or np.abs(np.subtract(q, last)).max() < 0.05
        last = q


def test_what_is_no_unit_quaternion_ends_the_run_with_its_name():
    ours = mocks.model("ours", real("u", "input"), real("S", "output", shape=(3, 3)))
    theirs = mocks.model("theirs", real("u", "input"), real("p", "output", shape=(4,)))
    found = fitted(ours, theirs, ports={"S": {"theirs": "p", "quaternion": "scalar first"}})
    block = Mock("x", theirs, lambda b: None)
    with pytest.raises(Exception, match=r"x: output p .*stands for our S: expected a quaternion of length 1"):
        through(found, block, u=0.0)


# ---------------------------------------------------------------- names, elements, types


def test_single_elements_are_set_and_the_others_keep_what_they_had():
    ours = mocks.model("ours", real("u", "input", shape=(2,)), real("y", "output", shape=(2,)))
    theirs = mocks.model("theirs", real("v", "input", shape=(2,)), real("y", "output", shape=(2,)))
    found = fitted(ours, theirs, ports={"u": {"theirs": "v", "matrix": [[0, 2], [1, 0]]}})
    block = echo("x", theirs, {"y": "v"})
    adapter = Adapter(block, found)
    adapter.set([(Element("u", 0), 5.0)])
    assert block.vector("v").tolist() == [0.0, 5.0]
    adapter.set([(Element("u", 1), 3.0)])
    assert block.vector("v").tolist() == [6.0, 5.0]
    buffer = adapter.wire([Element("u", 1)], [], [0, 0, 0, 0], np.zeros(0))  # the first one is not connected
    buffer[:] = 7.0
    adapter.set_inputs()
    assert block.vector("v").tolist() == [14.0, 5.0]
    adapter.set([(Element("u", 0), 9.0)])  # in the middle of a run
    adapter.set_inputs()
    assert block.vector("v").tolist() == [14.0, 9.0]


def test_booleans_and_enumerations_pass_as_they_are():
    kinds = {"flag": "boolean", "mode": "enumeration", "count": "integer"}
    items = {"mode": (("low", 1), ("high", 2))}
    ours = mocks.model(
        "ours",
        *(real(n, "input", type=t, items=items.get(n, ())) for n, t in kinds.items()),
        *(real(f"{n}_out", "output", type=t, items=items.get(n, ())) for n, t in kinds.items()),
    )
    theirs = mocks.model(
        "theirs",
        *(real(f"v_{n}", "input", type=t, items=items.get(n, ())) for n, t in kinds.items()),
        *(real(f"v_{n}_out", "output", type=t, items=items.get(n, ())) for n, t in kinds.items()),
    )
    found = fitted(ours, theirs, ports={n: f"v_{n}" for n in ours.variables})
    block = echo("x", theirs, {f"v_{n}_out": f"v_{n}" for n in kinds})
    adapter = Adapter(block, found)
    fed = sorted(
        ours.inputs, key=lambda e: ("integer", "enumeration", "boolean").index(ours.variables[e.variable].type)
    )
    given = [Element(f"{e.variable}_out", 0) for e in fed]
    into = np.zeros(3)
    buffer = adapter.wire(fed, given, [0, 1, 1, 1], into)
    buffer[:] = [7, 2, 1]
    adapter.set_inputs()
    adapter.do_step(0.0, 1.0)
    adapter.get_live()
    assert into.tolist() == [7, 2, 1]


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ({"ports": {"w": "v"}}, "the interface ours has no 'w'"),
        ({"ports": {"u": "w"}}, "their FMU has no variable 'w'"),
        ({"ports": {"u": "y"}}, "y is of causality output, expected input"),
        ({"ports": {"u": {"theirs": "v", "matrix": [[1, 0]]}}}, "the matrix is 1 by 2, expected 2 by 2"),
        ({"ports": {"u": ["v[1]"]}}, "ours is a real [2], theirs has 1 value"),
        ({"ports": {"u": "v", "y": {"theirs": "y", "matrix": [[1, 1], [1, 1]]}}}, "the matrix has no inverse"),
        ({"ports": {"u": "v", "p": "v"}}, "v[1] already stands for u"),
        ({"ports": {"u": ["v[1]", "v[1]"]}}, "input u = v[1] v[1]: v[1] is named more than once"),
        ({"ports": {"u": {"theirs": "v", "offset": [1, 2, 3]}}}, "the offset has 3 values, expected 2"),
        (
            {"ports": {"u": {"theirs": "v", "quaternion": "scalar first"}}},
            "a quaternion of 4 stands for a matrix of [3, 3]",
        ),
        ({"ports": {"u": "v"}, "ignore": ["u"]}, "u is both mapped and ignored"),
        ({"ports": {"u": "v"}, "ignore": ["z"]}, "the interface ours has no 'z'"),
        ({"ports": {"u": "v"}, "start": {"z": 1}}, "their FMU has no input or parameter 'z'"),
        ({"ports": {"u": "v"}, "start": {"v": [1, 2]}}, "v stands for our u, whose value it takes"),
        ({}, "input u, a real [2] in m, is missing; by name or unit it may be v"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_name(mapping, message):
    two = {"shape": (2,), "unit": unit("m")}
    ours = mocks.model("ours", real("u", "input", **two), real("y", "output", **two), real("p", "input", **two))
    theirs = mocks.model("theirs", real("v", "input", **two), real("y", "output", **two), real("p", "input", **two))
    assert message in "\n".join(map(str, fitted(ours, theirs, **mapping).errors))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ports: {speed: {theirs: rate, scale: 2, divide: 3}}", "expected at most one of scale and divide"),
        ("ports: {speed: {theirs: rate, scale: 0}}", "scale: expected a number other than 0"),
        ("ports: {speed: {theirs: rate, matrix: [[1, 0], [1]]}}", "expected rows of one length"),
        ("ports: {speed: {theirs: rate, matrix: [[.inf]]}}", "expected rows of finite numbers, found inf in one"),
        (f"ports: {{speed: {{theirs: rate, matrix: [[1{400 * '0'}]]}}}}", "of 401 digits"),
        ("ports: {speed: {theirs: rate, scale: .inf}}", "expected a finite number, found inf"),
        ("ports: {speed: {theirs: rate, divide: 1e999 kg}}", "expected a finite number, found 1e999 kg"),
        (f"ports: {{speed: {{theirs: rate, offset: [1{400 * '0'}]}}}}", "of 401 digits"),
        ("ports: {speed: {theirs: rate, inverse: true}}", "'inverse' is of a quaternion"),
        ("ports: {speed: {theirs: rate, quaternion: scalar first, scale: 2}}", "a quaternion goes without scale"),
        ("ports: {speed: {theirs: rate, unit: blorps}}", "unknown unit 'blorps'"),
        ("prots: {speed: rate}", "unknown key 'prots'; did you mean 'ports'?"),
        ("file: other.yaml", "a mapping's file holds the mapping itself"),
        ("[speed, rate]", "expected keys such as 'ports' and 'ignore', found a list"),
    ],
)
def test_a_wrong_mapping_is_refused_with_its_line(tmp_path, monkeypatch, text, message):
    swapped(tmp_path, monkeypatch)
    (tmp_path / "mapping.yaml").write_text(f"# theirs\n{text}\n")
    result = orchestrate("loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr
    assert "mapping.yaml:2:" in result.stderr


# ---------------------------------------------------------------- in a run


def orchestrate(*arguments):
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def swapped(folder: Path, monkeypatch, *changes, scenario: str = SCENARIO, **options) -> Path:
    """A folder with loop.yaml, its two FMUs, and vendor.fmu with mapping.yaml for the regulator."""
    fmus.write_pair(folder)
    vendor.write(folder, *changes, runnable=True, **options)
    path = folder / "loop.yaml"
    path.write_text(scenario, "utf-8")
    monkeypatch.chdir(folder)
    return path


def test_a_swapped_block_gives_what_ours_gives(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    ours = run(path)
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    assert result.exit_code == 0, result.output
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["motorspeed"], ours["motor.speed"], rtol=1e-13)
    np.testing.assert_allclose(table["regulatorvoltage"], ours["regulator.voltage"], rtol=1e-13)


def test_the_scenario_may_say_it_itself_and_the_manifest_can_be_run_again(tmp_path, monkeypatch):
    text = SCENARIO.replace(
        "fmu: regulator.fmu", "fmu: vendor.fmu\n    interface: regulator.fmu\n    map: mapping.yaml"
    )
    path = swapped(tmp_path, monkeypatch, scenario=text)
    result = run(path)
    again = run({**result.manifest["scenario"]})
    np.testing.assert_array_equal(again["motor.speed"], result["motor.speed"])
    inline = {"ports": {"speed": "rate", "voltage": "command", "gain": {"theirs": "kp", "scale": vendor.GAIN}}}
    data = load(path).source.data
    data["blocks"]["regulator"]["map"] = inline
    np.testing.assert_array_equal(run(data)["motor.speed"], result["motor.speed"])


def test_the_manifest_tells_the_values_in_force_in_theirs(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    told = json.loads(Path("out/manifest.json").read_text())["parameters"]["regulator"]
    assert told == {"fault": 0, "fault_time": 0.0, "kp": pytest.approx(-vendor.GAIN)}


def test_other_names_alone_change_no_bit(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, ('name="speed"', 'name="rate"'), own_names=False)
    (tmp_path / "mapping.yaml").write_text("ports: {speed: rate}")
    theirs = load(path).source.with_entry(("blocks", "regulator", "fmu"), "vendor.fmu")
    theirs = theirs.with_entry(("blocks", "regulator", "interface"), "regulator.fmu").with_entry(
        ("blocks", "regulator", "map"), "mapping.yaml"
    )
    a, b = run(path), run(load(theirs))
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])


def test_inputs_are_recorded_as_they_were_handed_in(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, scenario=SCENARIO + "\n").parent / "loop.yaml"
    path.write_text(
        SCENARIO.replace(
            "record: {interval: 0.1 s}", "record: {signals: [regulator.speed, motor.speed, regulator.gain]}"
        )
    )
    orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["regulatorspeed"], table["motorspeed"])
    np.testing.assert_allclose(table["regulatorgain"], -1.0, rtol=1e-14)


def test_a_value_for_a_parameter_that_theirs_lacks_is_refused_unless_ignored(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch)
    mapping = "ports: {speed: rate, voltage: command}\n"
    (tmp_path / "mapping.yaml").write_text(mapping)
    arguments = (path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    result = orchestrate(*arguments)
    assert result.exit_code == 2
    assert (
        "loop.yaml:12: blocks.regulator.start.gain: vendor.fmu has no parameter gain, so this value would be lost"
        in result.stderr
    )
    (tmp_path / "mapping.yaml").write_text(mapping + "ignore: [gain]\n")
    result = orchestrate(*arguments)
    assert (result.exit_code, "regulator: does without parameter gain, as the mapping says" in result.stderr) == (
        0,
        True,
    )


def test_what_refers_to_an_output_that_theirs_lacks_is_refused_unless_ignored(tmp_path, monkeypatch):
    extra = "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: 1 V}}\n  - {name: slow, signal: motor.speed, always: {below: 1 rpm}}\n"
    path = swapped(
        tmp_path,
        monkeypatch,
        ('name="samples[1]"', 'name="first"'),
        ('name="samples[2]"', 'name="second"'),
        scenario=SCENARIO + extra,
    )
    arguments = (path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    result = orchestrate(*arguments)
    assert result.exit_code == 2
    assert "loop.yaml:21: expect[2].signal: regulator lacks the output samples, to which this refers" in result.stderr
    (tmp_path / "mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    result = orchestrate(*arguments)
    assert result.exit_code == 1, "the third expectation is still judged"
    assert "left out, since regulator.samples is not there: the expectation 'sampled'" in result.stderr
    assert "failed       slow" in result.stdout
    assert "recorded under their own names: first, second" in result.stderr


@pytest.mark.parametrize(
    ("ignored", "fault"),
    [
        ("speed", "bias: regulator.speed, by: 1 rad/s"),
        ("samples", "cut: 'regulator.samples[1]'"),
        ("gain", "set: regulator.gain = 2"),
    ],
)
def test_a_fault_of_what_the_mapping_ignores_is_refused(tmp_path, monkeypatch, ignored, fault):
    text = SCENARIO + f"faults:\n  - {{at: 1 s, {fault}}}\n"
    renamed = (('name="samples[1]"', 'name="first"'), ('name="samples[2]"', 'name="second"'))
    path = swapped(tmp_path, monkeypatch, *renamed, scenario=text)
    kept = "".join(line for line in vendor.MAPPING.splitlines(True) if not line.startswith(f"  {ignored}:"))
    (tmp_path / "mapping.yaml").write_text(f"{kept}ignore: [{ignored}]\n")
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 2
    assert "is under 'ignore' in the mapping of regulator, so the fault would change nothing" in result.stderr


def test_a_later_fault_keeps_its_line_when_something_before_it_is_left_out(tmp_path, monkeypatch):
    extra = "  - {name: sampled, signal: 'regulator.samples[1]', always: {within: 1 V}}\n  - {name: wrong, signal: motor.sped, always: {below: 1 rpm}}\n"
    path = swapped(tmp_path, monkeypatch, ('name="samples[1]"', 'name="first"'), scenario=SCENARIO + extra)
    (tmp_path / "mapping.yaml").write_text(vendor.MAPPING + "ignore: [samples]\n")
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert "loop.yaml:22: expect[2].signal: motor has no" in result.stderr


STEP = "<ModelVariables>"


@pytest.mark.parametrize(
    ("own", "base", "note", "steps"),
    [
        ("0.1", "0.1 s", "", 20),
        ("0.2", "0.1 s", "it is stepped once in 2 base steps ('every: 2')", 10),
        ("0.025", "0.1 s", "4 of them in each step of 0.1 s", 80),
    ],
)
def test_a_block_that_cannot_vary_its_step_is_stepped_at_its_own(tmp_path, monkeypatch, own, base, note, steps):
    text = SCENARIO.replace("record: {interval: 0.1 s}", "record: {signals: [motor.speed, regulator.count]}")
    counter = '<ScalarVariable name="count" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>'
    path = swapped(
        tmp_path,
        monkeypatch,
        (STEP, f'<DefaultExperiment stepSize="{own}"/>{STEP}'),
        ("</ModelVariables>", f"{counter}</ModelVariables>"),
        ("</Outputs>", '<Unknown index="9" dependencies=""/></Outputs>'),
        scenario=text,
    )
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--out", "out")
    assert result.exit_code == 0, result.output
    assert note in result.stderr
    table = np.genfromtxt("out/signals.csv", delimiter=",", names=True)
    assert table["regulatorcount"][-1] == steps


def test_a_step_that_does_not_divide_is_refused(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, (STEP, f'<DefaultExperiment stepSize="0.15"/>{STEP}'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 2
    assert (
        "cannot vary its step of 0.15 s, which is no multiple of the step, 0.1 s; remedy: a base step that divides it, such as 'step: 0.075 s'"
        in result.stderr
    )


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ("1e-300", "cannot vary its step of 1e-300 s, more than 10000 of them in each step of 0.1 s; remedy: "),
        ("0", "its stepSize is 0, expected a finite number above 0"),
        ("-0.1", "its stepSize is -0.1, expected"),
        ("INF", "its stepSize is INF, expected"),
        ("1e-999999999", "its stepSize is 1e-999999999, expected"),
    ],
)
def test_a_step_without_end_is_refused(tmp_path, monkeypatch, own, message):
    path = swapped(tmp_path, monkeypatch, (STEP, f'<DefaultExperiment stepSize="{own}"/>{STEP}'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('rad="1" factor="0.10471975511965977"', 'rad="1" factor="0"', "the unit 'rpm' has the factor 0.0"),
        ('rad="1" factor="0.10471975511965977"', 'rad="1" factor="-1"', "the unit 'rpm' has the factor -1.0"),
        ('rad="1" factor="0.10471975511965977"', 'rad="1" offset="NaN"', "and the offset nan; expected"),
        ('factor="9.549296585513721"', 'factor="0"', "the display unit 'rpm' of rad/s has the factor 0.0"),
        ('factor="9.549296585513721"', 'factor="INF"', "the display unit 'rpm' of rad/s has the factor inf"),
    ],
)
def test_a_unit_that_cannot_be_converted_is_refused_by_name(tmp_path, monkeypatch, old, new, message):
    path = swapped(tmp_path, monkeypatch, (old, new))
    for arguments in ((path.name, "--swap", "regulator=vendor.fmu"), ("check", "vendor.fmu", "--as", "regulator.fmu")):
        result = orchestrate(*arguments)
        assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--swap", "regulator"), "--swap regulator: expected block=file.fmu"),
        (
            ("--swap", "regulater=vendor.fmu"),
            "--swap regulater=vendor.fmu: there is no block 'regulater'; did you mean 'regulator'?",
        ),
        (("--swap", "regulator=vendor.fmu", "--swap", "regulator=b.fmu"), "b.fmu: regulator is swapped twice"),
        (
            ("--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--map", "regulator=b.yaml"),
            "--map regulator=b.yaml: regulator is mapped twice",
        ),
        (("--swap", "regulator=vender.fmu"), "there is no FMU vender.fmu; did you mean 'vendor.fmu'?"),
        (("--map", "mapping.yaml"), "--map mapping.yaml: expected the --swap that it belongs to"),
        (("--swap", "regulator=vendor.fmu", "--map", "motor=mapping.yaml"), "motor is not swapped"),
        (
            ("--swap", "regulator=vendor.fmu"),
            "input speed, a real scalar in rad/s, is missing; by name or unit it may be rate",
        ),
    ],
)
def test_a_wrong_swap_is_refused(tmp_path, monkeypatch, options, message):
    swapped(tmp_path, monkeypatch)
    result = orchestrate("loop.yaml", *options)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


def test_a_mapping_without_an_interface_is_refused(tmp_path, monkeypatch):
    text = SCENARIO.replace("fmu: regulator.fmu", "fmu: vendor.fmu\n    map: mapping.yaml")
    path = swapped(tmp_path, monkeypatch, scenario=text)
    with pytest.raises(InputError, match="a mapping needs to know whose ports stand on its left"):
        run(path)


def test_where_theirs_declares_no_feedthrough_that_of_the_interface_is_taken(tmp_path, monkeypatch):
    path = swapped(tmp_path, monkeypatch, ('<Unknown index="5" dependencies="3"/>', '<Unknown index="5"/>'))
    result = orchestrate(path.name, "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert result.exit_code == 0
    assert (
        "does not say on which inputs voltage depend directly; what the interface regulator says is taken"
        in result.stderr
    )
    assert "would close a loop" not in result.stderr
