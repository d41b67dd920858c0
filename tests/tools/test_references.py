"""Other tools reproduce the reference data that our FMUs carry, read from the FMU as a user of the tool would."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pandas
import pytest
from fmpy.util import read_csv
from lxml import etree

from fmus.build import ensure
from fmus.contents.references import FOLDER
from fmus.interface import BLOCKS, load
from tests.native.test_fmi3 import three

from .measure import ONES, Recipe
from .test_importers import needs

pytestmark = pytest.mark.thorough

READ = """\
import json, sys
fmu, step, start, names, inputs, outputs = json.loads(sys.stdin.read())  # inputs: a row of values an instant
words = {float: "real", int: "integer", bool: "boolean", str: "string"}
"""
SCRIPTS = {
    "FMPy": """
import numpy as np
from fmpy import simulate_fmu
columns = [("time", float), *((name, float) for name in names)]
signals = np.array([(step * k, *row) for k, row in enumerate(inputs)], dtype=columns)
end = step * (len(inputs) - 1)
result = simulate_fmu(
    fmu, stop_time=end, output_interval=step, start_values=start, input=signals, output=outputs
)
rows = [[float(row[name]) for name in outputs] for row in result][1:]
""",
    "libcosim": """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_step_size(round(1e9 * step))
block = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="block"))
reference = {v.name.decode(): v.reference for v in execution.slave_variables(block)}
for name, value in {**start, **dict(zip(names, inputs[0]))}.items():
    if name in reference:  # it lists no enumeration; those of our data have their default
        getattr(execution, f"{words[type(value)]}_initial_value")(block, reference[name], value)
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
execution.add_observer(observer), execution.add_manipulator(manipulator)
rows = []
for row in inputs[:-1]:
    for name, value in zip(names, row):
        getattr(manipulator, f"slave_{words[type(value)]}_values")(block, [reference[name]], [value])
    execution.step()
    rows.append(observer.last_real_values(block, [reference[name] for name in outputs]))
""",
    "ecos": """
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("block", fmu)
structure.add_parameter_set("start", {f"block::{k}": v for k, v in {**start, **dict(zip(names, inputs[0]))}.items()})
rows = []
with EcosSimulation(structure=structure, step_size=step) as simulation:
    simulation.init(parameter_set="start")
    for row in inputs[:-1]:
        for name, value in zip(names, row):
            getattr(simulation, f"set_{words[type(value)]}".replace("boolean", "bool"))(f"block::{name}", value)
        simulation.step()
        rows.append([simulation.get_real(f"block::{name}") for name in outputs])
""",
}


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("recipe", ONES, ids=lambda r: r.tool)
def test_a_tool_reproduces_what_the_fmu_carries(recipe: Recipe, block: str, tmp_path: Path) -> None:
    needs(recipe)
    fmu = tmp_path / f"{block}.fmu"
    fmu.write_bytes(ensure(block).read_bytes())
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "unpacked", [n for n in archive.namelist() if n.startswith(FOLDER)])
    folder = tmp_path / "unpacked" / FOLDER
    given, expected = (pandas.read_csv(folder / name) for name in ("inputs.csv", "outputs.csv"))
    values = _stated(folder)
    kinds = {v.name: v.type for v in fmpy.read_model_description(str(fmu)).modelVariables}
    start = {name: _typed(value, kinds[name]) for name, value in values.items()}
    experiment = etree.parse(str(folder / "smoke-test.exp")).find("Experiment")
    step = float(experiment.get("stepSize"))
    tolerances = {t.get("name"): float(t.get("absolute")) for t in experiment.iter("Tolerance")}
    names, outputs = list(given)[1:], list(tolerances)
    rows = [[_typed(value, kinds[name]) for name, value in zip(names, row, strict=True)] for row in given[names].values]
    task = (str(fmu), step, start, names, rows, outputs)
    script = f"{READ}{SCRIPTS[recipe.tool]}\nprint('\\n@' + json.dumps(rows))"
    run = subprocess.run(
        [sys.executable, "-c", script],
        input=json.dumps(task),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]
    seen = np.array(json.loads(run.stdout.rpartition("\n@")[2].partition("\n")[0]))
    assert len(seen) == len(expected) - 1
    for i, name in enumerate(outputs):
        difference = np.abs(seen[:, i] - expected[name][1:]).max()
        assert difference <= tolerances[name], f"{name}: {difference}"


def _stated(folder: Path) -> dict[str, str]:
    """The start values of the SSV; of an item of an enumeration its number."""
    root = etree.parse(str(folder / "parameters.ssv")).getroot()
    numbers = {
        (of.get("name"), item.get("name")): item.get("value")
        for of in root.iter("{*}Enumeration")
        for item in of.iter("{*}Item")
    }
    return {
        p.get("name"): numbers.get((p[0].get("name"), p[0].get("value")), p[0].get("value"))
        for p in root.iter("{*}Parameter")
    }


def _typed(value: object, kind: str) -> float | int | bool | str:
    """A value of a table or an SSV as the type of its variable."""
    if kind == "String":
        return str(value)
    number = float({"true": 1, "false": 0}.get(str(value).lower(), value))
    return number if kind == "Real" else bool(number) if kind == "Boolean" else int(number)


@pytest.mark.parametrize("block", BLOCKS)
def test_fmpy_maps_every_column_of_the_inputs(block: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It warns of an input without a column, and passes over a column without an input."""
    fmu = ensure(block, here=True)
    folder = Path(fmpy.extract(str(fmu), unzipdir=str(tmp_path))) / FOLDER
    signals, wanted = (pandas.read_csv(folder / n).to_records(index=False) for n in ("inputs.csv", "outputs.csv"))
    step = float(etree.parse(str(folder / "smoke-test.exp")).find("Experiment").get("stepSize"))
    start = _stated(folder)
    outputs = [name for name in wanted.dtype.names if name != "time"]
    result = fmpy.simulate_fmu(
        str(fmu), input=signals, start_values=start, output=outputs, output_interval=step, stop_time=signals["time"][-1]
    )
    assert "Warning" not in capsys.readouterr().out
    assert _inputs(fmu) == set(signals.dtype.names) - {"time"}
    for name in outputs:
        np.testing.assert_allclose(result[name], wanted[name], rtol=1e-6, atol=1e-6 * np.abs(wanted[name]).max())


@pytest.mark.parametrize("block", BLOCKS)
def test_of_fmi_3_each_column_is_an_array_of_the_fmu(block: str, tmp_path: Path) -> None:
    """By FMPy's reader. Its simulation stacks the inputs, so it takes arrays of one shape only (0.3.32)."""
    folder = Path(fmpy.extract(str(three(block)), unzipdir=str(tmp_path))) / FOLDER
    signals = read_csv(folder / "inputs.csv")
    assert _inputs(three(block)) == set(signals.dtype.names) - {"time"}
    for name in signals.dtype.names[1:]:
        variable, element = load(block).variables.get(name), load(block).elements.get(name)
        assert signals[name][0].size == (len(variable.elements) if variable is not None else 1)
        assert variable is not None or element is not None


STEPPED = """
import json, sys
from ecospy import EcosSimulation, EcosSimulationStructure
fmu, names = json.loads(sys.stdin.read())
structure = EcosSimulationStructure()
structure.add_model("block", fmu)
with EcosSimulation(structure=structure, step_size=0.1) as simulation:
    simulation.init()
    rows = []
    for k in range(20):
        simulation.step()
        rows.append([simulation.get_real(f"block::{name}") for name in names])
print("\\n@" + json.dumps(rows))
"""


@pytest.mark.parametrize("block", BLOCKS)
def test_of_fmi_3_ecos_shows_the_scalars_with_the_bits_of_fmi_2(block: str, tmp_path: Path) -> None:
    """It knows no arrays (0.7.2); libcosim (0.0.6) knows no FMI 3.0."""
    needs(ONES[2])
    names = [v.name for v in load(block).of("output") if v.type == "real" and not v.shape]
    seen = []
    for fmu in (ensure(block), three(block)):
        command = [sys.executable, "-c", STEPPED]
        run = subprocess.run(command, input=json.dumps([str(fmu), names]), capture_output=True, text=True, cwd=tmp_path)
        assert run.returncode == 0, run.stderr[-2000:]
        seen.append(json.loads(run.stdout.rpartition("\n@")[2].partition("\n")[0]))
    assert seen[0] == seen[1]
    assert np.isfinite(seen[0]).all()


def _inputs(fmu: Path) -> set[str]:
    return {v.name for v in fmpy.read_model_description(str(fmu)).modelVariables if v.causality == "input"}
