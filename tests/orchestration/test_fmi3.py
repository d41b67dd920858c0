"""FMUs of FMI 3.0 in the place of those of FMI 2.0, and beside them."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestration import BlockError, InputError, load, run
from orchestration.acceptance.check import check
from orchestration.acceptance.compare import compare
from orchestration.export import ssp
from orchestration.export.system import flat
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.model import Element
from orchestration.session.open import locate

from . import as_fmi3, fmus, vendor
from .wrong_inputs import SCENARIO

SCENARIOS = Path(__file__).parents[2] / "scenarios"
TYPES = "Float64 Float32 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean".split()
MORE = """
<String name="label" valueReference="300" causality="parameter"><Start value="none"/></String>
<UInt64 name="steps" valueReference="301" causality="output"/>
<Binary name="frame" valueReference="302" causality="input"><Start value="00"/></Binary>"""


def _types() -> str:
    """The description of types3.c."""
    shape = '<Dimension valueReference="1"/><Dimension start="2"/>'
    alias = '<Alias name="alias"/>'
    starts = {"Int16": "1 2 3 4 5 6", "Boolean": "false"}
    variables = "".join(
        f'<{tag} name="u{tag}" valueReference="{100 + i}" causality="input" start="{starts.get(tag, 0)}">{shape}'
        f'{alias if tag == "Int16" else ""}</{tag}><{tag} name="y{tag}" valueReference="{200 + i}" '
        f'causality="output">{shape}</{tag}>'
        for i, tag in enumerate(TYPES)
    )
    unknowns = [200 + i for i in range(len(TYPES))] + [301]
    outputs = "".join(f'<Output valueReference="{n}" dependencies=""/>' for n in unknowns)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="types" instantiationToken="t">
<CoSimulation modelIdentifier="probe" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>{as_fmi3.TIME}
<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="3"/>
{variables}{MORE}
</ModelVariables>
<ModelStructure>{outputs}{outputs.replace("<Output", "<InitialUnknown")}</ModelStructure>
</fmiModelDescription>"""


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with FMUs of FMI 3.0: ours, the motor and the regulator, and `types.fmu`."""
    folder = tmp_path_factory.mktemp("three")
    fmus.write_pair(folder)
    for name in ("motor", "regulator"):
        as_fmi3.write(folder / f"{name}3.fmu", folder / f"{name}.fmu")
    for name in ("plant", "controller", "allocator"):
        as_fmi3.write(folder / f"{name}3.fmu", locate(name, folder, "native"))
    as_fmi3.pack(folder / "types.fmu", _types(), fmus.library("types3"))
    return folder


def manoeuvre(three: Path, *blocks: str, **changes: Any) -> dict[str, Any]:
    data = {**load(SCENARIOS / "paper_no_singularity.yaml").source.data, "duration": 10, "expect": [], "holds": []}
    replaced = {name: {"fmu": str(three / f"{name}3.fmu"), "isolation": "none"} for name in blocks}
    entries = {name: {**entry, **replaced.get(name, {})} for name, entry in data["blocks"].items()}
    return {**data, "figures": [], **changes, "blocks": entries}


# ---------------------------------------------------------------- the same law behind either version


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
@pytest.mark.parametrize("blocks", [("controller",), ("plant", "controller", "allocator")], ids=["mixed", "all"])
def test_a_run_with_fmi_3_has_the_bits_of_one_with_fmi_2(three, blocks, exchange):
    expected = run(manoeuvre(three, exchange=exchange))
    for compiled in (True, False):
        found = run(manoeuvre(three, *blocks, exchange=exchange), compiled=compiled)
        assert list(found) == list(expected)
        assert all(found[signal].tobytes() == expected[signal].tobytes() for signal in expected)
    assert found.manifest["fmus"]["controller"]["fmi"] == "3.0"


def test_in_a_process_of_its_own_it_gives_the_same_bits(three):
    data = manoeuvre(three, "controller", duration=1)
    del data["blocks"]["controller"]["isolation"]
    found, expected = run(data), run(manoeuvre(three, duration=1))
    assert found.manifest["fmus"]["controller"]["isolation"] == "process"
    assert found["controller.tau_cmd_B"].tobytes() == expected["controller.tau_cmd_B"].tobytes()


def test_single_elements_of_arrays_are_wired_and_recorded(three):
    data = manoeuvre(three, "plant", "controller", duration=1)
    whole = next(wire for wire in data["connections"] if "R_NB" in wire and "judge" not in wire)
    others = [wire for wire in data["connections"] if wire != whole]
    places = [(i, j) for i in (1, 2, 3) for j in (1, 2, 3)]
    wires = [f"plant.R_NB[{i},{j}] -> controller.R_NB[{i},{j}]" for i, j in reversed(places)]
    data |= {"connections": [*others, *wires], "record": {"signals": ["controller.tau_cmd_B[2]", "plant.R_NB[1,2]"]}}
    results = {}
    for name in ("controller", str(three / "controller3.fmu")):
        data["blocks"]["controller"]["fmu"] = name
        results[name] = [run(data, compiled=compiled).samples.tobytes() for compiled in (True, False)]
    a, b = results.values()
    assert a == b
    assert a[0] == a[1]


def test_a_fault_changes_an_array_by_its_elements_as_in_fmi_2(three):
    faults = [{"cut": "controller.omega_B[2]", "at": 0.5}, {"set": "controller.a1 = 0.5", "at": 1}]
    a, b = (run(manoeuvre(three, *blocks, duration=2, faults=faults)) for blocks in ((), ("controller", "plant")))
    assert a["controller.tau_cmd_B"].tobytes() == b["controller.tau_cmd_B"].tobytes()
    unfaulted = run(manoeuvre(three, duration=2))["controller.tau_cmd_B"]
    assert not np.array_equal(a["controller.tau_cmd_B"], unfaulted)


# ---------------------------------------------------------------- swap, check, compare


def test_check_and_compare_find_the_swapped_controller_to_be_ours(three):
    findings, fitted = check(three / "controller3.fmu", "controller")
    assert fitted is not None
    assert [str(f.text) for f in findings if f.level == "error"] == []
    assert "version 3.0, co-simulation" in [f.text for f in findings if f.topic == "FMI"]
    assert any("all of FMI 3.0 are there" in f.text for f in findings)
    ours = load(SCENARIOS / "paper_no_singularity.yaml").source.with_entry(("duration",), 2.0)
    for key in ("expect", "holds", "figures"):
        ours = ours.with_entry((key,), [])
    theirs = ours.with_entry(("blocks", "controller", "fmu"), str(three / "controller3.fmu"))
    comparison = compare(ours, theirs.with_entry(("blocks", "controller", "interface"), "controller"), "controller")
    assert comparison.equivalent
    assert {d.largest for d in comparison.differences} == {0.0}


def test_a_mapping_stands_before_an_fmu_of_fmi_3(three, tmp_path, monkeypatch):
    vendor.write(tmp_path, runnable=True)
    as_fmi3.write(tmp_path / "vendor.fmu", tmp_path / "vendor.fmu")
    monkeypatch.chdir(three)
    scenario = three / "loop.yaml"
    scenario.write_text(SCENARIO + "isolation: none\n", "utf-8")
    expected = run(scenario)
    mapped = SCENARIO.replace(
        "regulator.fmu", f"{tmp_path}/vendor.fmu\n    interface: regulator.fmu\n    map: {tmp_path}/mapping.yaml"
    )
    scenario.write_text(mapped + "isolation: none\n", "utf-8")
    np.testing.assert_allclose(run(scenario)["motor.speed"], expected["motor.speed"], rtol=1e-12)


PYTHON = """
import numpy as np
from pythonfmu3 import Dimension, Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64

CONTINUOUS = Fmi3Variability.continuous


class Regulator(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time, self.speed, self.gain, self.samples = 0.0, 0.0, -1.0, np.zeros(2)
        pair = [Dimension(start="2")]
        self.register_variable(Float64("time", causality=Fmi3Causality.independent, variability=CONTINUOUS))
        self.register_variable(Float64("speed", causality=Fmi3Causality.input, variability=CONTINUOUS))
        self.register_variable(Float64("gain", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable))
        self.register_variable(Float64("voltage", causality=Fmi3Causality.output, variability=CONTINUOUS))
        self.register_variable(
            Float64("samples", causality=Fmi3Causality.output, variability=CONTINUOUS, dimensions=pair)
        )

    @property
    def voltage(self):
        return self.gain * self.speed

    def do_step(self, time, step):
        self.samples = np.array([self.speed, time])
        return True
"""


def test_an_fmu_by_pythonfmu3_takes_the_place_of_the_regulator(three, tmp_path, monkeypatch):
    from pythonfmu3.builder import FmuBuilder

    (tmp_path / "regulator_in_python.py").write_text(PYTHON, "utf-8")
    fmu = FmuBuilder.build_FMU(script_file=tmp_path / "regulator_in_python.py", dest=tmp_path)
    monkeypatch.chdir(three)
    (three / "loop.yaml").write_text(SCENARIO + "isolation: none\n", "utf-8")
    swap = f"{fmu}\n    interface: regulator.fmu\n    map: {{ignore: [enabled, fault, fault_time]}}"
    (three / "swapped.yaml").write_text(SCENARIO.replace("regulator.fmu", swap), "utf-8")
    expected, found = run(three / "loop.yaml"), run(three / "swapped.yaml")
    assert found["motor.speed"].tobytes() == expected["motor.speed"].tobytes()
    assert found["regulator.samples"][-1].tolist() == [found["motor.speed"][-1], 1.9]


# ---------------------------------------------------------------- types

VALUES = {
    "Float64": [[1.5, -2.25], [1e300, 0.1], [-0.0, 7.0]],
    "Float32": [[1.5, -2.25], [1e30, 0.1], [3.0, 7.0]],
    "Int8": [[-128, 127], [0, 1], [2, 3]],
    "UInt8": [[255, 0], [1, 2], [3, 4]],
    "Int16": [[-32768, 32767], [0, 1], [2, 3]],
    "UInt16": [[65535, 0], [1, 2], [3, 4]],
    "Int32": [[-(2**31), 2**31 - 1], [0, 1], [2, 3]],
    "UInt32": [[2**32 - 1, 0], [1, 2], [3, 4]],
    "Int64": [[-(2**53), 2**53], [0, 1], [2, 3]],
    "UInt64": [[2**53, 0], [1, 2], [3, 4]],
    "Boolean": [[True, False], [False, True], [True, True]],
}


def pair(three: Path, connections: list[str], start: dict[str, Any], b: dict[str, Any] | None = None) -> dict[str, Any]:
    """Two blocks of all types; an input of `b` that is neither connected nor given takes zeros."""
    fmu = {"fmu": str(three / "types.fmu"), "isolation": "none"}
    zeros = {f"u{tag}": np.zeros((3, 2), bool if tag == "Boolean" else int).tolist() for tag in TYPES}
    fed = {wire.split(" -> b.")[1].split("[")[0] for wire in connections}
    others = {name: value for name, value in zeros.items() if name not in fed}
    blocks = {"a": {**fmu, "start": {**zeros, **start}}, "b": {**fmu, "start": {**others, **(b or {})}}}
    return {"name": "pair", "step": 0.5, "duration": 2, "blocks": blocks, "connections": connections}


@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "python"])
def test_values_of_all_types_pass_as_they_are(three, compiled):
    wires = [f"a.y{tag} -> b.u{tag}" for tag in TYPES]
    data = pair(three, wires, {f"u{tag}": value for tag, value in VALUES.items()} | {"label": "first"})
    result = run(data, compiled=compiled)
    for tag, value in VALUES.items():
        wanted = np.array(value, np.float32) if tag == "Float32" else np.array(value)
        assert result[f"b.y{tag}"].shape == (5, 3, 2)
        np.testing.assert_array_equal(result[f"b.y{tag}"][-1], wanted)
    assert result["b.steps"].tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "python"])
def test_elements_that_nobody_connects_keep_what_they_were_set_to(three, compiled):
    """Five elements are set one by one, by the alias; a fault sets one of them in the run, when the sixth is 9."""
    given = {f"alias[{i},{j}]": 10 * i + j for i, j in ((1, 1), (2, 1), (2, 2), (3, 1), (3, 2))}
    data = pair(three, ["a.steps -> b.uInt16[1,2]"], {}, given)
    data |= {"duration": 5, "faults": [{"set": "b.uInt16[2,1] = 40", "at": 4.5}]}
    values = run(data, compiled=compiled)["b.yInt16"]
    assert values[8].tolist() == [[11, 8], [21, 22], [31, 32]]
    assert values[10].tolist() == [[11, 10], [40, 22], [31, 32]]


def test_a_parameter_is_changed_by_its_elements_and_keeps_the_others(three):
    """K0 is 0.585, 0.65, 0.715 N.m in the description, and the law refuses what is not in this order."""
    torques = []
    for blocks in ((), ("controller",)):
        data = manoeuvre(three, *blocks, duration=1)
        data["blocks"]["controller"]["start"] = {"K0[2]": 0.6}
        torques.append(run(data)["controller.tau_cmd_B"].tobytes())
    assert torques[0] == torques[1]
    assert torques[0] != run(manoeuvre(three, duration=1))["controller.tau_cmd_B"].tobytes()


@pytest.mark.parametrize("compiled", [True, False], ids=["compiled", "python"])
def test_a_value_that_a_type_cannot_hold_ends_the_run_by_name(three, compiled):
    """The number of steps comes to 256 in the step from 0.255 s."""
    start = {f"uUInt8[{i},{j}]": 1 for i in (1, 2, 3) for j in (1, 2) if (i, j) != (1, 1)}
    data = pair(three, ["a.steps -> b.uUInt8[1,1]"], {}, start)
    data |= {"step": 0.001, "duration": 0.3, "record": {"interval": 0.1}}
    message = r"b: fmi3SetUInt8 at 0.255 s: was given 256 for uUInt8\[1\]\[1\]; UInt8 holds 0 to 255"
    with pytest.raises(BlockError, match=message):
        run(data, compiled=compiled)


def test_a_start_value_beyond_the_type_is_refused_before_the_run(three):
    for value, message in ((-1, "expected a whole number of 8 bits from 0 on, found -1"), (1.5, "whole number")):
        with pytest.raises(InputError, match=message):
            run(pair(three, [], {"uUInt8[1,1]": value}))


def test_what_is_not_exchanged_is_refused_by_name(three):
    with pytest.raises(InputError, match=r"a\.n is a structural parameter, which keeps its start value"):
        run(pair(three, [], {"n": 4}))
    with pytest.raises(InputError, match=r"b\.frame is a Binary, which is not exchanged"):
        run(pair(three, ["a.yUInt8 -> b.frame"], {}))
    model = open_fmu(three / "types.fmu").model
    assert set(model.left_out) == {"n", "frame"}
    assert model.variables["uFloat64"].shape == (3, 2)
    assert model.aliases == {"alias": "uInt16"}
    assert model.feedthrough[Element("yInt8", 5)] == frozenset()


# ---------------------------------------------------------------- steps


@pytest.mark.parametrize(("inside", "steps"), [("0.05", 20), ("0.3", 6)])
def test_an_fmu_that_divides_its_steps_is_stepped_by_multiples_of_its_own(three, tmp_path, monkeypatch, inside, steps):
    as_fmi3.write(
        tmp_path / "motor.fmu",
        three / "motor.fmu",
        None,
        ("canHandleVariable", f'fixedInternalStepSize="{inside}" canHandleVariable'),
    )
    fmus.write(tmp_path / "regulator.fmu", fmus.description("regulator"), fmus.library())
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.yaml").write_text(SCENARIO + "isolation: none\n", "utf-8")
    assert run(tmp_path / "loop.yaml")["motor.steps"][-1] == steps
    with pytest.raises(InputError, match=r"its FMU steps inside by .* s, which is no multiple of the step, 0.07 s"):
        run(tmp_path / "loop.yaml", {"step": 0.07, "duration": 0.7})


# ---------------------------------------------------------------- archives of systems


def test_an_archive_of_a_system_may_hold_fmi_3_and_an_export_refuses_it(three, tmp_path, monkeypatch):
    monkeypatch.chdir(three)
    (three / "two.yaml").write_text(SCENARIO + "isolation: none\n", "utf-8")
    ssp.write(flat(load(three / "two.yaml")), tmp_path / "two.ssp")
    with zipfile.ZipFile(tmp_path / "two.ssp") as two, zipfile.ZipFile(tmp_path / "three.ssp", "w") as archive:
        for name in two.namelist():
            source = three / f"{Path(name).stem}3.fmu"
            archive.writestr(name, source.read_bytes() if name.endswith(".fmu") else two.read(name))
    a, b = (run(tmp_path / f"{name}.ssp") for name in ("two", "three"))
    assert a.samples.tobytes() == b.samples.tobytes()
    assert b.manifest["fmus"]["motor"]["fmi"] == "3.0"
    text = SCENARIO.replace("motor.fmu", "motor3.fmu")
    (three / "mixed.yaml").write_text(text, "utf-8")
    with pytest.raises(InputError, match=r"motor.* is an FMU of FMI 3.0; what is exported holds FMUs of FMI 2.0 only"):
        flat(load(three / "mixed.yaml"))
